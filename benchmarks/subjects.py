"""What is timed: adapters of this environment in two situations, and VMAS ``transport``."""

import contextlib
import io
import itertools
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from tqdm import tqdm

from asv_env.envs.joint import JointEnv
from asv_env.envs.vector import AsvVectorEnv
from asv_env.simulation import Simulation

NUM_BOATS = 4
CLOCK = {"physics": 50, "sensing": 10, "control": 10}
ACTIONS = 32  #: number of actions that are drawn beforehand and used in turn


@dataclass(frozen=True)
class Situation:
    """What the boats are doing."""

    name: str  #: in the table
    task: str  #: of the environment
    time_limit: float  #: of an episode, s
    actions: Callable[[Simulation], list[np.ndarray]]  #: returns those (W, A, 2) to use in turn

    @property
    def options(self) -> dict[str, Any]:
        """Arguments of the environment's adapters."""
        own = {"task": self.task, "time_limit": self.time_limit}
        return own | {"num_boats": NUM_BOATS, "clock": CLOCK}


@dataclass
class Subject:
    """Something to be timed."""

    worlds: int  #: number of worlds
    situation: str  #: name of the situation
    adapter: str  #: name of what is stepped
    step: Callable[[], object]  #: advances all worlds by one step
    simulation: Simulation | None = None  #: behind the adapter; None for VMAS


def _random_actions(simulation: Simulation) -> list[np.ndarray]:
    rng = np.random.default_rng(0)
    shape = (simulation.num_worlds, NUM_BOATS, 2)
    return [rng.uniform(-1, 1, shape).astype(np.float32) for _ in range(ACTIONS)]


def _pushing_actions(simulation: Simulation) -> list[np.ndarray]:
    """Returns full speed for the boats at the side; those at the ends keep pace, yawed inwards."""
    along = simulation.state.slot.real
    vessel, _ = simulation.params.hulls()
    at_end = np.abs(along) > vessel.length / 2
    action = np.zeros((*along.shape, 2), dtype=np.float32)
    action[..., 0] = np.where(at_end, 0.44, 1.0)
    action[..., 1] = np.where(at_end, -0.02 * np.sign(along), 0.0)
    return [action]


UNCONSTRAINED = Situation("unconstrained", "transport", 60.0, _random_actions)
PUSHING = Situation("pushing", "push", 20.0, _pushing_actions)


def vector_subject(situation: Situation, worlds: int) -> Subject:
    """Returns ``AsvVectorEnv`` with SAME_STEP autoreset, its episodes staggered."""
    env = AsvVectorEnv(worlds, autoreset_mode=AutoresetMode.SAME_STEP, **situation.options)
    env.reset(seed=0)
    step = _in_turn(env.step, situation.actions(env.simulation))
    length = round(situation.time_limit * CLOCK["control"])
    begins = np.arange(worlds) * length // worlds
    for tick in tqdm(range(length), f"{worlds} {situation.name}", leave=False, delay=1):
        step()
        if (begins == tick).any():
            env.reset(options={"reset_mask": begins == tick})
    return Subject(worlds, situation.name, "AsvVectorEnv", step, env.simulation)


def joint_subject(situation: Situation) -> Subject:
    """Returns ``JointEnv``, reset by its user."""
    env = JointEnv(**situation.options)
    env.reset(seed=0)
    advance = _in_turn(env.step, [action[0] for action in situation.actions(env.simulation)])

    def step() -> None:
        _, _, terminated, truncated, _ = advance()
        if terminated or truncated:
            env.reset()

    for _ in range(100):
        step()
    return Subject(1, situation.name, "JointEnv", step, env.simulation)


def _in_turn(function: Callable[[Any], Any], arguments: Sequence[Any]) -> Callable[[], Any]:
    """Returns a function that calls another one with the arguments in turn, over and over."""
    following = itertools.cycle(arguments)
    return lambda: function(next(following))


def vmas_subject(worlds: int) -> Subject:
    """Returns VMAS ``transport`` under random actions."""
    with contextlib.redirect_stderr(io.StringIO()):  # an old gym complains of its age
        import torch
        from vmas import make_env
    torch.set_num_threads(1)
    options: dict[str, Any] = {"continuous_actions": True, "n_agents": NUM_BOATS, "seed": 0}
    env = make_env("transport", num_envs=worlds, device="cpu", **options)
    env.reset()
    actions = [[2 * torch.rand(worlds, 2) - 1 for _ in range(NUM_BOATS)] for _ in range(ACTIONS)]
    step = _in_turn(env.step, actions)
    for _ in range(20):
        step()
    return Subject(worlds, "", "VMAS", step)


def all_subjects(sizes: Sequence[int], vmas: bool) -> list[Subject]:
    """Returns all that is timed, by numbers of worlds; VMAS too where wanted and installed."""
    found = []
    if vmas and find_spec("vmas") is None:
        vmas = False
        print("No comparison with VMAS: pip install vmas", file=sys.stderr)
    for worlds in sizes:
        if vmas:
            found.append(vmas_subject(worlds))
        for situation in (UNCONSTRAINED, PUSHING):
            found.append(vector_subject(situation, worlds))
            if worlds == 1:
                found.append(joint_subject(situation))
    return found
