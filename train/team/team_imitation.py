"""Teaches one policy for all teams, hulls and waters: the stage of ``train.recipe``.

The policy ``allocation`` is imitated by DAgger (Ross, Gordon and Bagnell, 2011), see
``train.imitation``. In each round worlds of several kinds run side by side, in a growing part of
them the learner acts, and it is trained on what the expert would have done in all of them.

The expert remembers more than a learner can see. At every tick its memory is therefore that of one
who takes over now, see ``take_over``: what it wants then follows from what is seen. Half of each
batch is seen in the mirror.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar

import numpy as np
import torch
from torch import Tensor, nn

from asv_env.checks import TINY, check_num_boats, check_numbers, check_whole
from asv_env.geometry import plane, wrap
from asv_env.params import EnvParams
from asv_env.presets import HULLS, SCENARIOS, make_params
from asv_env.simulation import Simulation
from asv_env.tasks import TASKS
from asv_env.types import Action, Bool, Float, Observation, Sensed
from baselines.allocation import AllocationPolicy
from baselines.allocation.allocation_gains import AllocationGains
from baselines.allocation.allocation_memory import Memory
from baselines.allocation.contact_approach import ContactApproach
from baselines.learned.seen import MIRROR, Seen
from baselines.learned.set_network import SetNetwork
from baselines.learned.team_view import TeamView, ViewMemory, driven
from baselines.rollout.loop import rollout
from train.sections import LARGEST_RATE
from train.team.set_actor import SetActor

Thing = TypeVar("Thing")
NAMED: dict[str, Callable[[Any], object]] = {
    "teams": check_num_boats,
    "scenarios": SCENARIOS.find,
    "hulls": HULLS.find,
    "tasks": TASKS.find,
}
"""What refuses a name that does not exist, by option."""
MOST_ROUND = 8  #: largest team round another hull than the plank, which grows along its side alone
PLANK = "plank"
TRIES = 100  #: kinds of worlds that are drawn for one that serves
EXPERT_FRACTION = 0.6  #: fraction of the worlds in which the expert acts, to the power of the round
EVERY = 4  #: control ticks between two that are recorded
TURN = 5.0  #: time between two random choices of these worlds, s
TOLERANCE = 0.1  #: error of an action beyond which the loss grows linearly
AVERAGE = 0.995  #: part of the averaged weights that a gradient step leaves
LEADS = (0.01, 0.03)  #: by how much the expert's reference leads the vessel, m/s and rad/s


class Block(NamedTuple):
    """What boats (n,) of a kind of worlds have seen in a round, and what the expert wanted."""

    seen: tuple[Tensor, ...]  #: the fields of ``Seen``, half precision
    wanted: Tensor  #: (n, 3) see ``TeamView.command``


@dataclass(frozen=True)
class Kind:
    """A kind of worlds."""

    task: str = "transport"
    num_boats: int = 4
    scenario: str = "noisy"
    vessel: str = PLANK

    @property
    def params(self) -> EnvParams:
        """The parameters of its worlds."""
        return make_params(self.task, self.num_boats, self.scenario, vessel=self.vessel)

    @property
    def spans(self) -> bool:
        """Whether the expert has a formation for the team, also after a failure, or needs none."""
        params = self.params
        if not params.definition.has_goal:
            return True
        least = params.num_boats - params.variation.failures
        approach = ContactApproach(params, AllocationGains())
        return all(approach.formation(team).spans for team in {least, params.num_boats})


@dataclass(frozen=True)
class Rounds:
    """How much is imitated, and in which worlds.

    What is named twice is drawn twice as often; of each list the first names are drawn from the
    first round on, the last ones from ``whole`` on.
    """

    teams: tuple[int, ...] = (4, 4, 4, 3, 6, 8, 5, 12, 20, 32)  #: team sizes
    scenarios: tuple[str, ...] = (
        *("noisy", "nominal", "noisy", "gyre", "current", "mismatch", "noisy", "load", "failure"),
    )  #: disturbances
    hulls: tuple[str, ...] = (
        *(PLANK, PLANK, PLANK, "square", "L", "barge", "T", "triangle", "hexagon"),
    )  #: vessels
    tasks: tuple[str, ...] = ("transport", "transport", "approach", "transport", "push")  #: tasks
    whole: float = 0.4  #: fraction of the rounds after which all worlds are drawn
    rounds: int = 32  #: number of rounds
    kinds: int = 6  #: kinds of worlds in a round
    boats: int = 240  #: boats of each kind, in as many worlds as they fill
    time: float = 90.0  #: simulated time of a round, s
    steps: int = 1000  #: gradient steps after a round
    batch: int = 256  #: boats of each of ``kinds`` blocks in a gradient step
    first_rate: float = 1e-3  #: learning rate of the first round
    last_rate: float = 1e-4  #: learning rate of the last round

    def __post_init__(self) -> None:
        for name, find in NAMED.items():
            if not getattr(self, name):
                raise ValueError(f"{name}: give one at least")
            for each in getattr(self, name):
                find(each)
        check_whole(self, "rounds kinds boats steps", 1, 10**6)
        check_whole(self, "batch", 2, 10**6)
        check_numbers(self, "time", TINY)
        check_numbers(self, "whole", TINY, 1.0)
        check_numbers(self, "first_rate last_rate", TINY, LARGEST_RATE)

    def has(self, kind: Kind) -> bool:
        """Returns whether worlds of a kind are drawn."""
        named = self.tasks, self.teams, self.scenarios, self.hulls
        return all(own in names for own, names in zip(vars(kind).values(), named, strict=True))


class Imitation:
    """A learner, what it has seen, and its averaged weights."""

    def __init__(self, options: Rounds, first_seed: int) -> None:
        torch.manual_seed(first_seed)
        self.actor, self.averaged = SetActor(), SetActor()
        self.averaged.load_state_dict(self.actor.state_dict())
        self.options, self.first_seed = options, first_seed
        self.blocks: list[Block] = []
        self.round = self.decisions = 0  #: done, and decisions of boats that were recorded
        self._optimizer = torch.optim.Adam(self.actor.parameters(), options.first_rate)

    def advance(self) -> float:
        """Runs the worlds of a round and trains; returns the mean loss."""
        seed = self.first_seed + self.round * self.options.kinds * self.options.boats
        rng, share = np.random.default_rng(seed), EXPERT_FRACTION**self.round
        network = SetNetwork(self.averaged.weights())
        for kind in kinds(rng, self.options, self.round):
            seeds = range(seed, seed + max(1, self.options.boats // kind.num_boats))
            self.blocks.append(dagger_rollout(network, kind, seeds, self.options.time, share, rng))
            self.decisions += len(self.blocks[-1].wanted)
            seed = seeds.stop
        loss = self._fit(rng)
        self.round += 1
        return loss

    def state(self) -> dict[str, Any]:
        """Returns all that a resumed run needs but the blocks."""
        return {
            "round": self.round,
            "decisions": self.decisions,
            "actor": self.actor.state_dict(),
            "averaged": self.averaged.state_dict(),
            "optimizer": self._optimizer.state_dict(),
        }

    def restore(self, state: Mapping[str, Any], blocks: Iterable[Block]) -> None:
        """Continues as the run does whose state and blocks these are."""
        self.round, self.decisions = state["round"], state["decisions"]
        self.blocks = list(blocks)
        self.actor.load_state_dict(state["actor"])
        self.averaged.load_state_dict(state["averaged"])
        self._optimizer.load_state_dict(state["optimizer"])

    def _fit(self, rng: np.random.Generator) -> float:
        """Trains on blocks that are drawn by their sizes; returns the mean loss."""
        options, total = self.options, 0.0
        first, last = options.first_rate, options.last_rate
        rate = first * (last / first) ** (self.round / max(options.rounds - 1, 1))
        self._optimizer.param_groups[0]["lr"] = rate
        sizes = np.array([len(block.wanted) for block in self.blocks], dtype=np.float64)
        for _ in range(options.steps):
            self._optimizer.zero_grad()
            for number in rng.choice(len(sizes), options.kinds, p=sizes / sizes.sum()):
                block = self.blocks[number]
                rows = torch.from_numpy(rng.integers(len(block.wanted), size=options.batch))
                loss = batch_loss(self.actor, block, rows) / options.kinds
                loss.backward()
                total += loss.item()
            self._optimizer.step()
            with torch.no_grad():
                pairs = zip(self.averaged.parameters(), self.actor.parameters(), strict=True)
                for mean, now in pairs:
                    mean.lerp_(now, 1.0 - AVERAGE)
        return total / options.steps


def drawn(things: Sequence[Thing], share: float, rng: np.random.Generator) -> Thing:
    """Returns one of the first things, of the share of them that may be drawn."""
    return things[int(rng.integers(math.ceil(share * len(things))))]


def kinds(rng: np.random.Generator, options: Rounds, number: int) -> list[Kind]:
    """Returns the kinds of worlds of round ``number``, where the expert acts by its own laws."""
    found: list[Kind] = []
    share = min(1.0, (number + 1) / (options.whole * options.rounds))
    for _ in range(TRIES * options.kinds):
        team = drawn(options.teams, share, rng)
        names = options.tasks, options.scenarios, options.hulls
        task, scenario, vessel = (drawn(each, share, rng) for each in names)
        kind = Kind(task, team, scenario, vessel if team <= MOST_ROUND else PLANK)
        if kind.spans:
            found.append(kind)
        if len(found) == options.kinds:
            return found
    raise ValueError(
        f"teams = {options.teams}, hulls = {options.hulls}: the expert, allocation, has formations "
        "for few of them; take larger teams, or other hulls"
    )


def batch_loss(actor: nn.Module, block: Block, rows: Tensor) -> Tensor:
    """Returns the loss on some rows of a block, the first half of them seen in the mirror."""
    seen = [part[rows].float() for part in block.seen]
    wanted, half = block.wanted[rows].clone(), len(rows) // 2
    for part, sign in zip(seen, MIRROR, strict=True):
        part[:half] *= torch.from_numpy(sign)
    wanted[:half, 2] *= -1.0
    loss: Tensor = nn.functional.smooth_l1_loss(actor(*seen), wanted, beta=TOLERANCE)
    return loss


def dagger_rollout(
    network: SetNetwork,
    kind: Kind,
    seeds: range,
    seconds: float,
    share: float,
    rng: np.random.Generator,
) -> Block:
    """Returns what boats have seen and the labels; the expert acts in a ``share`` of the worlds."""
    params = kind.params
    simulation = Simulation(params, len(seeds))
    expert, view = AllocationPolicy(params), TeamView(params)
    rate, leads = params.clock.control, np.ones(len(seeds), dtype=np.bool_)
    seen: list[Seen] = []
    wanted: list[Float] = []
    ticks = 0

    def act(
        sensed: Sensed, observation: Observation, memory: Any, fresh: Bool
    ) -> tuple[Action, tuple[Memory, ViewMemory]]:
        nonlocal ticks
        before, sight = memory or (None, None)
        action, after = expert.act(sensed, observation, before, fresh)
        now, sight = view.observe(sensed, sight, fresh)
        if ticks % round(TURN * rate) == 0:
            leads[:] = rng.random(len(leads)) < share
        if ticks % EVERY == 0:
            works = sensed.working
            seen.append(Seen(*(part[works].astype(np.float16) for part in now)))
            wanted.append(view.label(after.wanted, sight)[works].astype(np.float32))
        ticks += 1
        learned = action if leads.all() else view.command(network(now), sight)
        sight.reference[leads] = after.reference[leads]
        take_over(after, sight, sensed)
        return np.where(leads[:, None, None], action, learned), (after, sight)

    for _ in rollout(simulation, act, seeds, round(seconds * rate)):
        pass
    parts = zip(*seen, strict=True)
    return Block(
        tuple(torch.from_numpy(np.concatenate(part)) for part in parts),
        torch.from_numpy(np.concatenate(wanted)),
    )


def take_over(memory: Memory, sight: ViewMemory, sensed: Sensed) -> None:
    """Gives an expert the memory of one who takes over now.

    Its references lead the motion of boats and vessel by little, and it drives the vessel the way
    that takes less turning now.
    """
    course, motion = memory.course, memory.vessel.motion
    memory.reference = sight.reference.copy()
    if memory.scripted is not None:
        memory.scripted.reference = memory.reference[memory.lacking]
    to_vessel = np.exp(-1j * motion[:, 2])
    goal = (plane(sensed.goal) - plane(motion)) * to_vessel
    axis = driven(course.axis, goal, wrap(sensed.goal[:, 2] - motion[:, 2]))
    turned = ~course.arrived & ((axis * course.axis.conj()).real < 0)
    course.axis = np.where(turned, -course.axis, course.axis)
    course.speed = np.where(turned, -course.speed, course.speed)
    speed = (plane(motion, 3) * to_vessel * course.axis.conj()).real
    for name, now, lead in (("speed", speed, LEADS[0]), ("yaw_rate", motion[:, 5], LEADS[1])):
        setattr(course, name, np.clip(getattr(course, name), now - lead, now + lead))
