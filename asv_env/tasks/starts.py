"""Initial-state distributions: poses, goals, variations and failures, from one Generator."""

from typing import Any

import numpy as np

from asv_env.params import EnvParams
from asv_env.tasks import formation
from asv_env.types import Complex, Float, InitialState, Int

PUSH_GAP = 1e-3  #: first gap between bows and vessel in Push, m: no contact yet
TRIES = 10_000  #: places that are tried before a distribution is found to be empty


def sample(params: EnvParams, rng: np.random.Generator, goal: Float | None = None) -> InitialState:
    """Samples the beginning of an episode; a goal pose (3,), m, m, rad, replaces the sampled one.

    Raises:
        ValueError: the boats do not fit between the distances, or no goal is allowed.
    """
    return params.definition.initial_states(params, rng, goal)


def scattered(params: EnvParams, rng: np.random.Generator, goal: Float | None) -> InitialState:
    """Samples boats all round a vessel at the origin, headings at random; see ``sample``."""
    goal = _goal(params, rng, goal)
    motion = np.zeros((1 + params.num_boats, 6))
    boats, headings = _scattered(params, rng)
    motion[1:, 0], motion[1:, 1], motion[1:, 2] = boats.real, boats.imag, headings
    return InitialState(motion, goal, _side(params, goal), **_variation(params, rng))


def in_slots(params: EnvParams, rng: np.random.Generator, goal: Float | None) -> InitialState:
    """Samples an episode whose boats begin in their slots; see ``sample``."""
    goal = _goal(params, rng, goal)
    motion, side = np.zeros((1 + params.num_boats, 6)), _side(params, goal)
    put_into_slots(motion, params, side)
    return InitialState(motion, goal, side, **_variation(params, rng))


def put_into_slots(motion: Float, params: EnvParams, side: float) -> None:
    """Places boats in their slots, bows to the vessel at the origin, in a motion (B, 6), in place.

    They are on the vessel's +n or -n side, which is +1 or -1.
    """
    boats = formation.slots(params, params.num_boats) + 1j * PUSH_GAP
    motion[1:, 0], motion[1:, 1] = boats.real, side * boats.imag
    motion[1:, 2] = -side * np.pi / 2


def _goal(params: EnvParams, rng: np.random.Generator, goal: Float | None) -> Float:
    """Returns the given or the fixed goal, or samples one from the ring ``goal_distance``."""
    if goal is not None:
        return np.asarray(goal, dtype=np.float64)
    if params.task.goal is not None:
        return np.array(params.task.goal)
    near, far = params.task.goal_distance
    bound = _bound(params, params.vessel.length / 2)
    for _ in range(TRIES):
        x, y = rng.uniform(-far, far, 2)
        if near <= np.hypot(x, y) <= far and max(abs(x), abs(y)) <= bound:
            return np.array([x, y, rng.uniform(-np.pi, np.pi)])
    raise ValueError(
        f"no goal at {params.task.goal_distance!r} m from the origin lies within {bound:g} m "
        "of it along both axes; bring `goal_distance` nearer or widen the basin"
    )


def _side(params: EnvParams, goal: Float) -> float:
    if params.task.side == "goal":
        # The team pushes towards -n from the +n side, so it takes the side away from the goal.
        return 1.0 if goal[1] <= 0 else -1.0
    return 1.0 if params.task.side == "+n" else -1.0


def _scattered(params: EnvParams, rng: np.random.Generator) -> tuple[Complex, Float]:
    """Samples positions in the ring ``start_distance``, apart from each other, and headings."""
    near, far = params.task.start_distance
    apart = params.task.start_spacing * params.boat.length
    bound = _bound(params, params.boat.length)
    boats = np.empty(0, dtype=np.complex128)
    for _ in range(TRIES):
        if len(boats) == params.num_boats:
            return boats, rng.uniform(-np.pi, np.pi, params.num_boats)
        radius = np.sqrt(rng.uniform(near**2, far**2))
        candidate = radius * np.exp(1j * rng.uniform(-np.pi, np.pi))
        inside = max(abs(candidate.real), abs(candidate.imag)) <= bound
        if inside and np.all(np.abs(boats - candidate) >= apart):
            boats = np.append(boats, candidate)
    raise ValueError(
        f"{params.num_boats} boats {apart:.3g} m apart do not fit between {near:g} m and "
        f"{far:g} m from the vessel; widen `start_distance` or lower `start_spacing`"
    )


def _bound(params: EnvParams, margin: float) -> float:
    """Returns the largest coordinate at which something may be placed, m."""
    return (params.task.arena if params.water.walls is None else params.water.walls) - margin


def _variation(params: EnvParams, rng: np.random.Generator) -> dict[str, Any]:
    """Samples what differs from the nominal in an episode, by the names of ``InitialState``."""
    spread, team = params.variation, params.num_boats

    def gain(width: float, *shape: int) -> Float:
        return 1.0 + rng.uniform(-width, width, shape)

    def between(interval: tuple[float, float] | None, nominal: float) -> float:
        return nominal if interval is None else float(rng.uniform(*interval))

    return {
        "thrust_gain": gain(spread.thrust, team, 2),
        "lag": between(spread.lag, params.boat.lag),
        "drag_gain": gain(spread.drag, 1 + team),
        "mass_gain": gain(spread.mass, 1 + team),
        "friction": between(spread.friction, params.water.contact_friction),
        "failure_tick": _failures(params, rng),
    }


def _failures(params: EnvParams, rng: np.random.Generator) -> Int:
    """Samples the ticks (A,) at which thrusters fail; -1 never."""
    ticks = np.full(params.num_boats, -1)
    failing = rng.choice(params.num_boats, size=params.variation.failures, replace=False)
    times = rng.uniform(*params.variation.failure_time, size=len(failing))
    ticks[failing] = np.maximum(1, np.round(times * params.clock.control))
    return ticks
