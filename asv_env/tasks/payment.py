"""The built-in reward terms of a world."""

from typing import NamedTuple

from asv_env.compiled import compiled
from asv_env.memo import by_identity
from asv_env.params import NOMINAL_LENGTH, EnvParams
from asv_env.tasks.laws import aim, cost_to_go, direction_of, gaussian, heading_error_of, size_of
from asv_env.types import Bool, Float, Int

LARGEST_STEP = 1.0  #: bound on the rise of a potential in one tick
GAUSSIAN = (0.08, 0.2)  #: width of the Gaussian of precision, m at the nominal size and rad
NARROW_GAUSSIAN = (0.02, 0.05)  #: width of the Gaussian of a delivery's accuracy, likewise
POTENTIALS = ("closure", "delivery", "precision")  #: columns of the built-in potentials
COLUMNS = (*POTENTIALS, "success", "accurate_success", "strayed", "time", "effort", "collision")
"""Columns of all built-in terms; the last two are each boat's own."""
CLOSURE, DELIVERY, PRECISION, SUCCESS, ACCURATE_SUCCESS, STRAYED, TIME = range(7)
SHARED, OWN = 7, 2  #: number of columns that the team shares, and of the others
EFFORT, COLLISION = range(OWN)


class Prices(NamedTuple):
    """What things are worth, for a tick where they grow with time; see ``RewardParams``."""

    length: float  #: the vessel's size, m
    size: float  #: the same over the nominal one
    success: float
    accuracy: float
    strayed: float
    time: float
    effort: float  #: of 1 N^2
    collision: float
    time_limit: int  #: ticks


class Happened(NamedTuple):
    """What is paid for in a tick, besides potentials; read-only."""

    reached: Bool  #: (W,) whether the task is done
    strayed: Bool  #: (W,) whether a body has left the arena
    tick: Int  #: (W,) control ticks since the episodes began
    thrust: Float  #: (W, A, 2) of the motors, N
    touching: Bool  #: (W, A, 2) whether boats touch the vessel, another boat or an obstacle
    aground: Bool  #: (W,) whether the vessel touches an obstacle


class Payments(NamedTuple):
    """Weighted terms of a tick, by the columns ``COLUMNS``."""

    shared: Float  #: (W, 7) those that the team shares
    own: Float  #: (W, A, 2) those of each boat
    reward: Float  #: (W, A) sum of the boats' terms


@by_identity
def prices(params: EnvParams) -> Prices:
    """Returns the prices of an environment."""
    reward, tick = params.reward, 1.0 / params.clock.control
    return Prices(
        length=params.vessel.size,
        size=params.vessel.size / NOMINAL_LENGTH,
        success=reward.success,
        accuracy=reward.accuracy,
        strayed=reward.strayed,
        time=reward.time * tick,
        effort=0.5 * reward.effort * tick / params.boat.thrust**2,
        collision=reward.collision * tick,
        time_limit=params.time_limit_ticks,
    )


class Worth(NamedTuple):
    """What true states are worth, and how far the vessels are from their goals."""

    #: (W, P) potentials, dimensionless: minus the mean distance of the working boats to their
    #: slots and minus the cost-to-go, both in vessel lengths; and a Gaussian round the goal pose
    potential: Float
    error: Float  #: (W, 2) errors of position, m, and heading, rad


@compiled
def evaluate(
    world: int,
    slot_distance: float,
    goal: Float,
    motion: Float,
    side: float,
    prices: Prices,
    worth: Worth,
) -> None:
    """Writes what the state of a world is worth.

    Args:
        world: row of the world in ``worth``.
        slot_distance: mean distance of the working boats to their slots, m.
        goal: (3,) pose of the goal.
        motion: (B, 6) of the world.
        side: from which the team pushes, +1 or -1.
        prices: what things are worth.
        worth: receives it.
    """
    position, turn = aim(motion, goal, direction_of(motion[0, 2]).conjugate())
    distance, heading_error = size_of(position), heading_error_of(turn)
    cost = cost_to_go(position, heading_error, side, prices.size)
    precision = gaussian(distance, heading_error, GAUSSIAN[0] * prices.size, GAUSSIAN[1])
    worth.potential[world, CLOSURE] = -slot_distance / prices.length
    worth.potential[world, DELIVERY] = -cost / prices.length
    worth.potential[world, PRECISION] = precision
    worth.error[world, 0], worth.error[world, 1] = distance, heading_error


@compiled
def accurate_success(error: Float, prices: Prices) -> float:
    """Returns the reward of a delivery, a fraction of which is a Gaussian of its errors (2,)."""
    width = NARROW_GAUSSIAN[0] * prices.size
    missed = 1.0 - gaussian(error[0], error[1], width, NARROW_GAUSSIAN[1])
    return prices.success * (1.0 - prices.accuracy * missed)


@compiled
def straying(tick: int, prices: Prices) -> float:
    """Returns the penalty for leaving the arena, with that of the time that was left."""
    return -prices.strayed - prices.time * (prices.time_limit - tick)


@compiled
def pay(
    world: int,
    before: Float,
    worth: Worth,
    happened: Happened,
    prices: Prices,
    weight: Float,
    paid: Payments,
) -> None:
    """Computes the reward terms of a tick of a world.

    Args:
        world: row of the world in all arrays.
        before: (W, P) potentials before the tick.
        worth: what the states after it are worth.
        happened: what else is paid for.
        prices: what things are worth.
        weight: (9,) factors on the columns ``COLUMNS``.
        paid: receives the weighted terms and their sums.
    """
    terms = paid.shared[world]
    for k in range(SUCCESS):
        rise = worth.potential[world, k] - before[world, k]
        terms[k] = min(max(rise, -LARGEST_STEP), LARGEST_STEP)
    terms[SUCCESS] = terms[ACCURATE_SUCCESS] = terms[STRAYED] = 0.0
    if happened.reached[world]:
        terms[SUCCESS] = prices.success
        terms[ACCURATE_SUCCESS] = accurate_success(worth.error[world], prices)
    if happened.strayed[world]:
        terms[STRAYED] = straying(happened.tick[world], prices)
    terms[TIME] = -prices.time
    team_reward = 0.0
    for k in range(SHARED):
        terms[k] *= weight[k]
        team_reward += terms[k]
    for boat in range(paid.own.shape[1]):
        thrust, own = happened.thrust[world, boat], paid.own[world, boat]
        squares = thrust[0] * thrust[0] + thrust[1] * thrust[1]
        own[EFFORT] = -prices.effort * squares * weight[SHARED + EFFORT]
        bump = -prices.collision * happened.touching[world, boat, 1]
        bump -= prices.collision * happened.aground[world]
        own[COLLISION] = bump * weight[SHARED + COLLISION]
        paid.reward[world, boat] = team_reward + (own[EFFORT] + own[COLLISION])
