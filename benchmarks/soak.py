"""Random worlds of every kind for very many steps: ``python benchmarks/soak.py``.

A round is a random environment (layout of obstacles, hulls, team, task, walls, disturbances, size)
whose worlds take random actions or those of the scripted policy, and begin again when they end. It
exits with 1 where something raises or is not a finite number, and where a hull lies in another one
or in an obstacle by more than ``DEEPEST`` for ``LASTING``. (When hulls ram each other, they overlap
for a moment by what they move in a physics step.) The line gives the seed of the round, and
``--seed N --steps 1`` repeats it.
"""

import sys
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import tyro
from tqdm import tqdm

from asv_env import HULLS, SCENARIOS, EnvParams, Simulation, make_params
from asv_env.capsules import clearance
from asv_env.checks import check_whole
from asv_env.geometry import direction, xy
from asv_env.params.obstacle_params import grouping
from asv_env.polygons import complex_corners
from asv_env.types import Float, Int, given
from baselines.rollout.commands import command
from baselines.scripted import ScriptedPolicy

DEEPEST = 2e-3  #: depth to which hulls may lie in each other or in obstacles, m at scale 1
LASTING = 0.5  #: time for which they may lie deeper, s at scale 1
LAYOUTS = ("none", "pillars", "channel", "dock")


@dataclass(frozen=True)
class Options:
    """Steps random worlds and looks at every state."""

    steps: int = 1_000_000  #: number of world-steps
    worlds: int = 32  #: number of worlds side by side
    ticks: int = 300  #: control steps of a round
    seed: int = 0  #: of the first round

    def __post_init__(self) -> None:
        check_whole(self, "steps ticks", 1)
        check_whole(self, "worlds", 1, 10**6)
        check_whole(self, "seed", 0)


def sampled_options(rng: np.random.Generator) -> dict[str, Any]:
    """Returns options of a random environment."""
    options: dict[str, Any] = {
        "task": str(rng.choice(["approach", "push", "transport"])),
        "num_boats": int(rng.choice([2, 3, 4, 5, 8, 12])),
        "obstacles": str(rng.choice(LAYOUTS)),
        "scenario": str(rng.choice(list(SCENARIOS))),
        "action_mode": str(rng.choice(["tracking", "thrusters"])),
        "side": str(rng.choice(["+n", "-n", "goal"])),
        "scale": float(rng.choice([0.5, 1.0, 1.0, 4.0])),
        "time_limit": float(rng.choice([15.0, 60.0])),
    }
    if rng.random() < 0.5:
        options["vessel"] = str(rng.choice(list(HULLS)))
    return options


def made(rng: np.random.Generator) -> EnvParams:
    """Returns a random environment; what is refused is no failure, and another one is sampled."""
    while True:
        options = sampled_options(rng)
        try:
            params = make_params(**options)
            if rng.random() < 0.5:
                walls = {"walls": params.task.arena * rng.uniform(0.8, 1.2)}
                params = make_params(**options, water=walls | vars(params.water) | walls)
        except ValueError:
            continue
        return params


def inset(outline: Float, depth: float) -> Float:
    """Returns a hull (n, 2), corners counter-clockwise, with all sides moved inwards by a depth."""
    before, after = np.roll(outline, 1, axis=0), np.roll(outline, -1, axis=0)
    along, on = outline - before, after - outline
    along /= np.hypot(*along.T)[:, None]
    on /= np.hypot(*on.T)[:, None]
    cross = along[:, 0] * on[:, 1] - along[:, 1] * on[:, 0]
    straight = abs(cross) < 1e-9
    share = depth / np.where(straight, 1.0, cross)
    moved = outline + share[:, None] * (on - along)
    normal = np.stack([-along[:, 1], along[:, 0]], axis=-1)
    return np.where(straight[:, None], outline + depth * normal, moved)


def placed(shape: Float, motion: Float) -> Float:
    """Returns the corners (n, 2) in the world of a hull (n, 2) with a motion (6,)."""
    turned = complex_corners(shape) * direction(motion[2])
    return xy(turned + complex(motion[0], motion[1]))


def count_overlaps(
    motion: Float, vessel: Float, boat: Float, small_vessel: Float, small_boat: Float,
    obstacle: Float, groups: Int, ticks: Int,
) -> None:  # fmt: skip
    """Counts the ticks in a row for which hulls lie too deep in each other or in an obstacle.

    That is so where a hull that is smaller by the depth still overlaps the other.

    Args:
        motion: (W, B, 6) of the hulls.
        vessel: (n, 2) corners of the vessel.
        boat: (m, 2) corners of a boat.
        small_vessel: (n, 2) corners of the vessel, inset by the depth.
        small_boat: (m, 2) corners of a boat, inset by it.
        obstacle: (W, M, 5) obstacles.
        groups: (G + 1,) first rows of the obstacles.
        ticks: (W, B, B + 1) of each hull and each other; the last column is for obstacles.
    """
    reach = np.abs(boat).max() + max(np.abs(boat).max(), np.abs(vessel).max())
    place = motion[..., 0] + 1j * motion[..., 1]
    near = np.tril(abs(place[:, :, None] - place[:, None]) < 1.5 * reach, -1)
    deep = np.zeros_like(ticks, dtype=np.bool_)
    for world, body in np.ndindex(place.shape):
        corners = placed(small_boat if body else small_vessel, motion[world, body])
        deep[world, body, -1] = clearance(obstacle[world], groups, corners) <= 0.0
        for other in np.flatnonzero(near[world, body]):
            outline = placed(boat if other else vessel, motion[world, other])
            ends = np.roll(outline, -1, axis=0)
            edges = np.column_stack([outline, ends, np.zeros(len(outline))])
            alone = given(np.array([0, len(edges)]), np.int64)
            deep[world, body, other] = clearance(edges, alone, corners) <= 0.0
    ticks[...] = np.where(deep, ticks + 1, 0)


class Round:
    """A random environment and its worlds."""

    def __init__(self, options: Options, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self.params, self._rng, self._seed = made(rng), rng, seed
        self._simulation = Simulation(self.params, options.worlds)
        self._scripted = self.params.action_mode == "tracking" and rng.random() < 0.5
        depth = DEEPEST * self.params.scale
        outlines = [np.array(h.corners) for h in (self.params.vessel, self.params.boat)]
        self._shapes = *outlines, *(inset(outline, depth) for outline in outlines)
        bodies = 1 + self.params.num_boats
        self._overlaps = np.zeros((options.worlds, bodies, bodies + 1), dtype=np.int64)
        self._patience = LASTING * self.params.scale**0.5 * self.params.clock.control

    def run(self, ticks: int) -> None:
        """Steps the worlds; RuntimeError where a state is wrong."""
        simulation, team = self._simulation, self._simulation.state.thrust.shape
        observation = simulation.reset(seeds=range(self._seed, self._seed + team[0]))
        policy = ScriptedPolicy(self.params) if self._scripted else None
        memory, fresh = None, np.ones(team[0], dtype=bool)
        for tick in range(ticks):
            if policy is not None:
                action, memory = policy.act(simulation.sensed, observation, memory, fresh)
            elif tick % 10 == 0:
                action = self._rng.uniform(-0.5, 1.0, team)
            step = simulation.step(action)
            observation = step.observation.copy()
            self._look(observation, step.reward)
            fresh = step.ending.terminated | step.ending.truncated
            if fresh.any():
                self._overlaps[fresh] = 0
                observation[fresh] = simulation.reset(fresh)

    def _look(self, observation: Float, reward: Float) -> None:
        state = self._simulation.state
        for name, array in (("motion", state.motion), ("reward", reward), ("seen", observation)):
            if not np.isfinite(array).all():
                raise RuntimeError(f"{name} is not finite")
        known = state.obstacle.copy(), grouping(self.params).groups, self._overlaps
        count_overlaps(state.motion, *self._shapes, *known)
        if self._overlaps.max() > self._patience:
            world, body, other = np.unravel_index(self._overlaps.argmax(), self._overlaps.shape)
            met = "an obstacle" if other > body else f"hull {other}"
            raise RuntimeError(
                f"hull {body} stays in {met} in world {world} at {state.tick[world]}"
            )


def soak(options: Annotated[Options, tyro.conf.arg(name="")]) -> None:
    """Step random worlds, and look for exceptions, numbers that are not finite, and overlaps."""
    each = options.worlds * options.ticks
    rounds = -(-options.steps // each)
    failed = []
    with tqdm(total=rounds * each, unit="step", unit_scale=True, mininterval=5.0) as bar:
        for seed in range(options.seed, options.seed + rounds):
            try:
                Round(options, seed).run(options.ticks)
            except Exception as error:  # whatever it is, it is what is looked for
                failed.append(seed)
                bar.write(f"round {seed}: {type(error).__name__}: {error}")
            bar.update(each)
    print(f"{rounds * each:,} world-steps, {rounds} environments, {len(failed)} failed")
    if failed:
        sys.exit(1)


main = command(soak, "python benchmarks/soak.py")

if __name__ == "__main__":
    main()
