"""The reward: named, bounded, weighted terms of the true motion.

Terms of progress are differences of potentials, so that they cannot be farmed: what is gained on
the way there is lost on the way back (Ng, Harada and Russell, 1999). All terms but effort and
collision are shared by the team. The sizes of the Gaussians grow with the vessel.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from asv_env.checks import REAL, FunctionError, choice, finite, values
from asv_env.geometry import wrap
from asv_env.params import NOMINAL_LENGTH, EnvParams, RewardParams
from asv_env.tasks.formation import Relations
from asv_env.text import shown
from asv_env.types import Ending, Float, State

HEADING_WEIGHT = 0.25  #: cost of a turn of the vessel by 1 rad, m at the nominal size
SIDEWAYS = 4.0  #: cost of a metre that the vessel moves without turning first, m
GAUSSIAN = (0.08, 0.2)  #: width of the Gaussian of precision, m at the nominal size and rad
NARROW_GAUSSIAN = (0.02, 0.05)  #: width of the Gaussian of a delivery's accuracy, likewise
KIND = "reward term"  #: word for a term in messages
LARGEST_STEP = 1.0  #: bound on the rise of a potential in one tick


@dataclass(frozen=True)
class Transition:
    """One control tick of all worlds, from which the reward terms are computed.

    Attributes:
        relations: true relations of vessel, boats, slots and goal after the tick.
        previous: true state before the tick.
        state: true state after the tick.
        ending: whether and why episodes end with the tick.
        params: parameters of the environment.
    """

    relations: Relations
    previous: State
    state: State
    ending: Ending
    params: EnvParams

    @property
    def second(self) -> float:
        """Duration of the tick, s."""
        return 1.0 / self.params.clock.control


Potential = Callable[[Relations, State, EnvParams], Float]
"""Potential (W,), dimensionless, of a true state."""


@dataclass(frozen=True)
class Term:
    """One term of the reward: a function of the transition, or the rise of a potential.

    Attributes:
        name: of the term, whose key in infos is ``reward_<name>``.
        value: function from a ``Transition`` to values (W,), or (W, A) if not shared.
        potential: function from true relations, state and parameters to a potential (W,), in place
            of ``value``. The value is its rise in a tick, limited to +-``LARGEST_STEP``.
        weight: factor on the value, or the name of the field of ``RewardParams`` that holds it.
        shared: whether all boats of a world get the same value.

    Raises:
        ValueError: both a value and a potential, or neither.
    """

    name: str
    value: Callable[[Transition], Float] | None = None
    potential: Potential | None = None
    weight: float | str = 1.0
    shared: bool = True

    def __post_init__(self) -> None:
        if (self.value is None) == (self.potential is None):
            raise ValueError(f"{KIND} {self.name!r}: give either a value or a potential")
        if isinstance(self.weight, str):
            choice(f"weight of {KIND} {self.name!r}", self.weight, RewardParams.__annotations__)
        elif finite(self.weight) is None:
            raise ValueError(f"{KIND} {self.name!r}: weight = {shown(self.weight)}: must be finite")

    def factor(self, params: EnvParams) -> float:
        """Returns the weight of the term in an environment."""
        if isinstance(self.weight, str):
            return float(getattr(params.reward, self.weight))
        return self.weight


def closeness_to_slots(relations: Relations, state: State, params: EnvParams) -> Float:
    """Minus the mean distance of the working boats to their slots, vessel lengths."""
    total = np.add.reduce(relations.slot_error * state.working, axis=1)
    return total / (-params.vessel.length * np.add.reduce(state.working, axis=1))


def closeness_to_goal(relations: Relations, state: State, params: EnvParams) -> Float:
    """Minus the cost-to-go, vessel lengths."""
    size = params.vessel.length / NOMINAL_LENGTH
    return cost_to_go(relations, state.side, size) / -params.vessel.length


def precision(relations: Relations, state: State, params: EnvParams) -> Float:
    """Gaussian round the goal pose, ``GAUSSIAN`` wide; 1 at the goal."""
    return _gaussian(relations, params, *GAUSSIAN)


def cost_to_go(relations: Relations, side: Float, size: float) -> Float:
    """Length (W,) of the vessel's path to its goal, m, where a turn counts as a distance too.

    Either the vessel turns until the goal lies where the team pushes (from ``side`` (W,), +1 or
    -1), goes there, and turns to the goal's heading; or, near the goal, it moves there without
    turning first, which costs several times the distance, and turns. The cheaper one counts: a
    plain distance would take the first turn for a step back. ``size`` is that over the nominal
    vessel's.
    """
    distance, turn = relations.goal_error, -relations.heading_error
    ahead = relations.goal * (1j * side)
    bearing = np.arctan2(ahead.imag, ahead.real)
    turns = np.abs(bearing) + np.abs(wrap(turn - bearing))
    straight = SIDEWAYS * distance + size * HEADING_WEIGHT * np.abs(turn)
    return np.minimum(distance + size * HEADING_WEIGHT * turns, straight)


def success(now: Transition) -> Float:
    """Reward (W,) of the tick at which the task is done."""
    return now.params.reward.success * now.ending.reached


def accurate_success(now: Transition) -> Float:
    """Reward (W,) of a delivery, a fraction of which is a Gaussian, ``NARROW_GAUSSIAN`` wide."""
    reward = success(now)
    if now.ending.reached.any():
        missed = 1.0 - _gaussian(now.relations, now.params, *NARROW_GAUSSIAN)
        reward *= 1.0 - now.params.reward.accuracy * missed
    return reward


def strayed(now: Transition) -> Float:
    """Penalty (W,) for leaving the arena, with that of the time that was left."""
    weight, ticks_left = now.params.reward, now.params.time_limit_ticks - now.state.tick
    return now.ending.strayed * (-weight.strayed - weight.time * now.second * ticks_left)


def time(now: Transition) -> Float:
    """Penalty (W,) of a tick."""
    return np.full(len(now.state.tick), -now.params.reward.time * now.second)


def effort(now: Transition) -> Float:
    """Penalty (W, A) of the boat's mean squared thrust over full thrust."""
    params, squares = now.params, np.add.reduce(np.square(now.state.thrust), axis=-1)
    return squares * (-0.5 * params.reward.effort * now.second / params.boat.thrust**2)


def collision(now: Transition) -> Float:
    """Penalty (W, A) of contact with another boat or a wall."""
    return -now.params.reward.collision * now.second * now.state.touching[..., 1]


TERMS = (
    Term("closure", potential=closeness_to_slots, weight="closure"),
    Term("delivery", potential=closeness_to_goal, weight="delivery"),
    Term("precision", potential=precision, weight="precision"),
    Term("success", accurate_success),
    Term("strayed", strayed),
    Term("time", time),
    Term("effort", effort, shared=False),
    Term("collision", collision, shared=False),
)  #: all terms, as Transport has them


def without(*names: str) -> tuple[Term, ...]:
    """Returns ``TERMS`` with some terms of weight zero; they are still reported."""
    return tuple(replace(term, weight=0.0) if term.name in names else term for term in TERMS)


def potentials(
    terms: Sequence[Term], relations: Relations, state: State, params: EnvParams
) -> Float:
    """Returns the potentials (W, P) of those terms that are the rise of one."""
    rising = [(term.name, term.potential) for term in terms if term.potential is not None]
    found, forms = np.empty((len(state.tick), len(rising))), {state.tick.shape: REAL}
    for column, (name, potential) in enumerate(rising):
        found[:, column] = values(forms, KIND, name, potential, relations, state, params)
    return found


def weighted(
    terms: Sequence[Term], before: Float, after: Float, now: Transition
) -> dict[str, Float]:
    """Returns the weighted terms of one control tick by name, (W, 1) shared or (W, A) per boat.

    The potentials ``before`` and ``after`` the tick are (W, P); see ``potentials``.
    """
    rises = iter(np.minimum(np.maximum(after - before, -LARGEST_STEP), LARGEST_STEP).T)
    team, each = {now.state.tick.shape: REAL}, {now.state.slot.shape: REAL}
    found: dict[str, Float] = {}
    for term in terms:
        if term.value is None:
            value: Float = next(rises)
        else:
            value = values(team if term.shared else each, KIND, term.name, term.value, now)
        if term.weight != 1.0:
            value = term.factor(now.params) * value
        found[term.name] = value[:, None] if term.shared else value
    return found


def total(terms: Sequence[Term], found: dict[str, Float], num_boats: int) -> Float:
    """Returns the reward (W, A) of each boat: the sum of the terms.

    Raises:
        FunctionError: a term is not finite.
    """
    own = [found[term.name] for term in terms if not term.shared]
    first, *others = own + [found[term.name] for term in terms if term.shared]
    reward = np.empty((len(first), num_boats))
    reward[...] = first
    for value in others:
        reward += value
    if not np.isfinite(reward).all():
        name = next((n for n, value in found.items() if not np.isfinite(value).all()), "sum")
        raise FunctionError(f"{KIND} {name!r} is not finite")
    return reward


def _gaussian(relations: Relations, params: EnvParams, width: float, angle: float) -> Float:
    """Gaussian (W,) of the distance and the heading error to the goal; 1 at the goal."""
    size = params.vessel.length / NOMINAL_LENGTH
    squares = np.square(relations.goal_error / (width * size))
    return np.exp(-(squares + np.square(np.abs(relations.heading_error) / angle)))
