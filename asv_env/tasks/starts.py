"""Initial-state distributions: poses, goals, variations and failures, from one Generator."""

import cmath
import math
from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np

from asv_env.memo import by_identity
from asv_env.params import SMALLEST_CAGE, EnvParams
from asv_env.params.obstacle_params import grouped, grouping, rows, sampled
from asv_env.tasks import formation
from asv_env.tasks.reachability import Waters
from asv_env.tasks.sampling import between
from asv_env.text import shown
from asv_env.types import Complex, Float, InitialState, Int

PUSH_GAP = 1e-3  #: first gap between bows and vessel in Push, m at scale 1: no contact yet
LEFT_RIGHT = np.array([-1.0, 1.0])  #: sign of the thrust bias of the left and the right motor
AHEAD = {"+n": -1j, "-n": 1j}  #: direction in which a team pushes from a side
LAYOUTS = 200  #: goals and layouts of obstacles that are tried before one is found to be impossible
TRIES = 10_000  #: places that are tried before a distribution is found to be empty


def sample(params: EnvParams, rng: np.random.Generator, goal: Float | None = None) -> InitialState:
    """Samples the beginning of an episode; a goal pose (3,), m, m, rad, replaces the sampled one.

    Raises:
        ValueError: the boats do not fit between the distances, or no goal is allowed.
    """
    return params.definition.initial_states(params, rng, goal)


def scattered(params: EnvParams, rng: np.random.Generator, goal: Float | None) -> InitialState:
    """Samples boats all round a vessel at the origin, headings at random; see ``sample``."""
    goal, side, waters = _waters(params, rng, goal)
    motion = np.zeros((1 + params.num_boats, 6))
    boats, headings = _scattered(params, rng, waters)
    motion[1:, 0], motion[1:, 1], motion[1:, 2] = boats.real, boats.imag, headings
    variation = _variation(params, rng)
    return InitialState(motion, goal, side, **variation, obstacle=waters.obstacle.copy())


def in_slots(params: EnvParams, rng: np.random.Generator, goal: Float | None) -> InitialState:
    """Samples an episode whose boats begin in their slots; see ``sample``."""
    goal, side, waters = _waters(params, rng, goal, starts_grasped=True)
    motion = np.zeros((1 + params.num_boats, 6))
    variation = _variation(params, rng)
    put_into_slots(motion, params, side, variation.get("boat_size"))
    return InitialState(motion, goal, side, **variation, obstacle=waters.obstacle.copy())


def put_into_slots(
    motion: Float, params: EnvParams, side: float, size: Float | None = None
) -> None:
    """Places boats in their slots, bows to the vessel at the origin, in a motion (B, 6), in place.

    They are on the vessel's +n or -n side, which is +1 or -1. Boats whose lengths are ``size`` (A,)
    times the nominal ones are as near to the vessel as nominal ones.
    """
    slots = formation.slot_table(params)[0 if side > 0 else 1, -1]
    boats = slots + 1j * side * PUSH_GAP * params.scale
    if size is not None:
        longer = 0.5j * side * params.boat.length * (size - 1)
        boats += longer
        if len(boats) >= SMALLEST_CAGE:  # The ends are beside the vessel.
            wider = np.sign(boats.real) * params.boat.width / 2 * (size - 1)
            boats[[0, -1]] += (wider - longer)[[0, -1]]
    motion[1:, 0], motion[1:, 1] = boats.real, boats.imag
    motion[1:, 2] = -side * np.pi / 2


def _waters(
    params: EnvParams, rng: np.random.Generator, given: Float | None, starts_grasped: bool = False
) -> tuple[Float, float, Waters]:
    """Returns a goal, the side from which the team pushes, and the water between the obstacles.

    Goals and obstacles are sampled until the vessel can go from the origin to the goal; where
    it ``starts_grasped``, boats in their slots are free too.

    Raises:
        ValueError: it never can.
    """
    fixed = given is not None or params.task.goal is not None
    layout = not isinstance(params.obstacles, tuple)
    problem: str | None = None
    for _ in range(LAYOUTS if layout or (params.obstacles and not fixed) else 1):
        goal = _goal(params, rng, given)
        side = _side(params, goal)
        waters = _sampled(params, rng, goal, side) if layout else _fixed(params)
        problem = waters.problem(goal, side) if params.obstacles else None
        if problem is None and params.obstacles and starts_grasped:
            problem = _problem_of_slots(params, waters, side)
        if problem is None:
            return goal, side, waters
    tried = f" in each of {LAYOUTS} samples" if layout or not fixed else ""
    raise ValueError(
        f"obstacles = {shown(params.obstacles)}: {problem}{tried}; move them or make them smaller "
        "or fewer, or choose other goals"
    )


@by_identity
def _fixed(params: EnvParams) -> Waters:
    """Returns the water between obstacles that are the same in every episode."""
    return Waters(params, rows(params, params.obstacles))


def _sampled(params: EnvParams, rng: np.random.Generator, goal: Float, side: float) -> Waters:
    """Returns the water between the obstacles that a layout samples.

    Raises:
        ValueError: the layout has returned other kinds of shapes than before.
    """
    shapes = sampled(params, rng, tuple(goal.tolist()), side)
    groups, expected = grouped(params, shapes).groups, grouping(params).groups
    if not np.array_equal(groups, expected):
        raise ValueError(
            f"obstacles = {shown(params.obstacles)}: returned {len(groups) - 1} obstacles with "
            f"{groups[-1]} edges, and {len(expected) - 1} with {expected[-1]} before; return as "
            "many of the same kinds in every episode"
        )
    return Waters(params, rows(params, shapes))


def _problem_of_slots(params: EnvParams, waters: Waters, side: float) -> str | None:
    """Returns why boats cannot begin in their slots on a vessel at the origin; None if they can."""
    motion = np.zeros((1 + params.num_boats, 6))
    put_into_slots(motion, params, side)
    if all(waters.clear(params.boat, pose) > 0.0 for pose in motion[1:, :3]):
        return None
    return "boats in their slots would begin in an obstacle"


def _goal(params: EnvParams, rng: np.random.Generator, goal: Float | None) -> Float:
    """Returns the given or the fixed goal, or samples one from the ring ``goal_distance``."""
    if goal is not None:
        return np.asarray(goal, dtype=np.float64)
    if params.task.goal is not None:
        return np.array(params.task.goal)
    near, far = params.task.goal_distance
    bound = _bound(params, params.vessel.size / 2)
    turn = params.task.goal_turn
    for x, y in _goal_places(params, rng, near, far, bound):
        pose = (x, y, between(rng, -turn, turn))
        if params.goal_fits(pose):
            return np.array(pose)
    raise ValueError(
        f"no goal at goal_distance = {params.task.goal_distance!r} m from the origin lies within "
        f"{bound:g} m of it along both axes: bring goal_distance nearer, or widen arena and walls"
    )


def _goal_places(
    params: EnvParams, rng: np.random.Generator, near: float, far: float, bound: float
) -> Iterator[tuple[float, float]]:
    """Samples places of goals as ``_places`` does, within ``goal_bearing`` of where a team pushes.

    Teams push towards -n from the +n side and towards +n from the other; a team that chooses its
    side by the goal does either.
    """
    widest, side = params.task.goal_bearing, params.task.side
    if widest == np.pi:
        yield from _places(rng, near, far, bound)
        return
    for _ in range(TRIES):
        radius = math.sqrt(between(rng, near**2, far**2))
        ahead = AHEAD.get(side) or (-1j, 1j)[int(rng.integers(2))]
        place = radius * ahead * cmath.exp(1j * between(rng, -widest, widest))
        if max(abs(place.real), abs(place.imag)) <= bound:
            yield place.real, place.imag


def _places(
    rng: np.random.Generator, near: float, far: float, bound: float
) -> Iterator[tuple[float, float]]:
    """Samples places in a ring, uniformly by its area, none of whose coordinates exceeds a bound.

    They are found by rejection from a square, and where hardly any is found that way, one by one.
    """
    hits = TRIES * np.pi / 4 * (1 - (near / far) ** 2) if near > 0 else TRIES
    if near > math.sqrt(2) * bound:
        return
    for _ in range(TRIES if hits >= 1 else 0):
        x, y = between(rng, -far, far), between(rng, -far, far)
        if near <= math.hypot(x, y) <= far and max(abs(x), abs(y)) <= bound:
            yield x, y
    for _ in range(TRIES):
        place = _in_ring(rng, near, far, bound)
        yield place.real, place.imag


def _in_ring(rng: np.random.Generator, near: float, far: float, bound: float) -> complex:
    """Samples a place x + iy in a ring, uniformly by its area, within a bound on both coordinates.

    A part of the ring must lie within. In each quadrant the allowed angles of a radius are those
    between two limits, which approach each other as the radius grows.
    """

    def limits(radius: float) -> tuple[float, float]:
        reach = min(1.0, bound / radius) if radius > 0 else 1.0
        return math.acos(reach), max(math.acos(reach), math.asin(reach))

    far = min(far, math.sqrt(2) * bound)
    first, last = limits(near)
    while True:
        radius = min(max(near, math.sqrt(between(rng, near**2, far**2))), far)
        low, high = limits(radius)
        if rng.random() * (last - first) <= high - low:
            quadrant: complex = 1j ** int(rng.integers(4))
            return radius * quadrant * cmath.exp(1j * between(rng, low, high))


def _side(params: EnvParams, goal: Float) -> float:
    if params.task.side == "goal":
        # The team pushes towards -n from the +n side, so it takes the side away from the goal.
        return 1.0 if goal[1] <= 0 else -1.0
    return 1.0 if params.task.side == "+n" else -1.0


def _scattered(
    params: EnvParams, rng: np.random.Generator, waters: Waters
) -> tuple[Complex, Float]:
    """Samples positions in the ring ``start_distance``, apart from each other, and headings.

    Where there are obstacles, the boats can reach the vessel between them.
    """
    narrow = bool(params.obstacles)
    near, far = params.task.start_distance
    boat, team = params.boat, params.num_boats
    apart = params.task.start_spacing * max(boat.length, boat.width)
    bound = _bound(params, max(boat.length, math.hypot(boat.length, boat.width) / 2))
    boats: list[complex] = []
    found = 0
    for attempt in range(2 * TRIES if near <= math.sqrt(2) * bound else 0):
        if len(boats) == team:
            return np.array(boats), rng.uniform(-np.pi, np.pi, team)
        if attempt == TRIES and found > TRIES / 100:
            break  # It is crowded.
        if attempt < TRIES:
            radius = math.sqrt(between(rng, near**2, far**2))
            candidate = radius * cmath.exp(1j * between(rng, -np.pi, np.pi))
        else:  # Hardly any of the ring lies within the bound.
            candidate = _in_ring(rng, near, far, bound)
        inside = max(abs(candidate.real), abs(candidate.imag)) <= bound
        found += inside
        apart_from_all = all(abs(boat - candidate) >= apart for boat in boats)
        if (
            inside
            and apart_from_all
            and (not narrow or waters.free(candidate.real, candidate.imag))
        ):
            boats.append(candidate)
    places = _arranged(near, far, apart, bound, team)
    if narrow:
        places = np.array([p for p in places if waters.free(p.real, p.imag)], dtype=np.complex128)
    if len(places) >= team:
        chosen = rng.choice(places, team, replace=False)
        return chosen, rng.uniform(-np.pi, np.pi, team)
    raise ValueError(
        f"{team} boats {apart:.3g} m apart do not fit at start_distance = "
        f"{params.task.start_distance!r} m from the vessel and within {bound:.3g} m of it along "
        "both axes, free of obstacles: widen start_distance, arena and walls, lower start_spacing "
        "or the boats' length and width, or use fewer boats or obstacles"
    )


def _arranged(near: float, far: float, apart: float, bound: float, team: int) -> Complex:
    """Returns places of boats on circles within a ring, ``apart`` or more from each other, m.

    They are for teams that find no room at random: the outermost circles come first, and there
    are not many more places than boats.
    """
    places = np.empty(0, dtype=np.complex128)
    radius = min(far, math.sqrt(2) * bound)
    while radius >= near and radius > 0 and len(places) < 4 * team:
        count = int(np.pi / math.asin(apart / (2 * radius))) if apart <= 2 * radius else 1
        turns = (np.arange(min(count, 64 * team)) + 0.5) / count
        circle = radius * np.exp(2j * np.pi * (turns + (0.125 - 0.5 / count)))
        inside = np.maximum(abs(circle.real), abs(circle.imag)) <= bound
        places = np.append(places, circle[inside])
        radius -= apart
    return places


def _bound(params: EnvParams, margin: float) -> float:
    """Returns the largest coordinate at which something may be placed, m."""
    return min(params.task.arena, params.water.walls or params.task.arena) - margin


def _variation(params: EnvParams, rng: np.random.Generator) -> dict[str, Any]:
    """Samples what differs from the nominal in an episode, by the names of ``InitialState``."""
    spread, team = params.variation, params.num_boats

    def gain(width: float, *shape: int) -> Float:
        share = rng.random(shape)  # is drawn without a width too, so that others stay the same
        return 1.0 + (2.0 * width * share - width) if width else np.ones(shape)

    def sampled_or(interval: tuple[float, float] | None, nominal: float) -> float:
        return nominal if interval is None else between(rng, *interval)

    varied: dict[str, Any] = {
        "thrust_gain": gain(spread.thrust, team, 2) * _bias(spread.thrust_bias),
        "lag": sampled_or(spread.lag, params.boat.lag),
        "drag_gain": gain(spread.drag, 1 + team),
        "mass_gain": gain(spread.mass, 1 + team),
        "friction": sampled_or(spread.friction, params.water.contact_friction),
        "failure_tick": _failures(params, rng),
    }
    if spread.load is not None:
        varied["mass_gain"][0] *= between(rng, *spread.load)
    if spread.boat_size:
        varied["boat_size"] = 1.0 + spread.boat_size * (2.0 * rng.random(team) - 1.0)
    return varied


@cache
def _bias(bias: float) -> Float:
    """Returns the factors on the thrust of the left and the right motor."""
    return 1.0 + bias * LEFT_RIGHT


def _failures(params: EnvParams, rng: np.random.Generator) -> Int:
    """Samples the ticks (A,) at which thrusters fail, by ``failure_clock``; -1 never."""
    ticks = np.full(params.num_boats, -1)
    if not params.variation.failures:
        return ticks
    failing = rng.choice(params.num_boats, size=params.variation.failures, replace=False)
    times = rng.uniform(*params.variation.failure_time, size=len(failing))
    ticks[failing] = np.maximum(1, np.round(times * params.clock.control))
    return ticks
