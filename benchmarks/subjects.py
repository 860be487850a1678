"""What is timed: environments of 4 boats, physics at 50 Hz and control at 10 Hz.

Only public names are used, so that an older version of the package can be timed too. The import of
``asv_env`` registers the environments.
"""

import inspect
import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode

import asv_env

NUM_BOATS = 4
CLOCK = {"physics": 50, "sensing": 10, "control": 10}
ACTIONS = 32  #: number of actions that are drawn beforehand and used in turn
SINGLE = "gym.make"  #: name of one world, stepped by itself


@dataclass(frozen=True)
class Situation:
    """What the boats are doing."""

    task: str  #: identifier of the environment
    time_limit: float  #: of an episode, s; episodes of many worlds are staggered
    actions: Callable[[Any], list[np.ndarray]]  #: of a simulation, those (W, A, 2) to use in turn
    others: Mapping[str, Any] = field(default_factory=dict)  #: further options

    @property
    def options(self) -> dict[str, Any]:
        """Arguments of the environment's adapters."""
        own = {"time_limit": self.time_limit, "num_boats": NUM_BOATS, "clock": CLOCK}
        return {**own, **self.others}


@dataclass
class Subject:
    """Something to be timed."""

    step: Callable[[], object]  #: advances all worlds by one step
    simulation: Any  #: behind the environment


def _random_actions(simulation: Any) -> list[np.ndarray]:
    rng = np.random.default_rng(0)
    shape = (simulation.num_worlds, NUM_BOATS, 2)
    return [rng.uniform(-1, 1, shape).astype(np.float32) for _ in range(ACTIONS)]


def _pushing_actions(simulation: Any) -> list[np.ndarray]:
    """Returns full speed for the boats at the side; those at the ends keep pace, yawed inwards."""
    along = simulation.state.slot.real
    vessel, _ = simulation.params.hulls()
    at_end = np.abs(along) > vessel.length / 2
    action = np.zeros((*along.shape, 2), dtype=np.float32)
    action[..., 0] = np.where(at_end, 0.44, 1.0)
    action[..., 1] = np.where(at_end, -0.02 * np.sign(along), 0.0)
    return [action]


SITUATIONS = {
    "unconstrained": Situation("asv_env/Transport-v0", 60.0, _random_actions),
    "pushing": Situation("asv_env/Push-v0", 20.0, _pushing_actions),
}
"""Random actions, few contacts; and a grasped vessel under way at 10 cm/s, contacts everywhere."""


def vector_subject(situation: Situation, worlds: int, threads: int) -> Subject:
    """Returns many worlds with SAME_STEP autoreset, their episodes staggered."""
    options = situation.options
    if "num_threads" in inspect.signature(asv_env.AsvVectorEnv.__init__).parameters:
        options |= {"num_threads": threads}
    options |= {"autoreset_mode": AutoresetMode.SAME_STEP}
    made = gymnasium.make_vec(situation.task, worlds, **options)
    made.reset(seed=0)
    env: Any = made.unwrapped
    step = in_turn(env.step, situation.actions(env.simulation))
    length = round(situation.time_limit * CLOCK["control"])
    begins = np.arange(worlds) * length // worlds
    for tick in range(length):
        step()
        if (begins == tick).any():
            env.reset(options={"reset_mask": begins == tick})
    return Subject(step, env.simulation)


def single_subject(situation: Situation) -> Subject:
    """Returns one world as ``gym.make`` makes it, reset by its user."""
    env: Any = gymnasium.make(situation.task, **situation.options)
    env.reset(seed=0)
    simulation = env.unwrapped.simulation
    advance = in_turn(env.step, [action[0] for action in situation.actions(simulation)])

    def step() -> None:
        _, _, terminated, truncated, _ = advance()
        if terminated or truncated:
            env.reset()

    for _ in range(100):
        step()
    return Subject(step, simulation)


def in_turn(function: Callable[[Any], Any], arguments: Sequence[Any]) -> Callable[[], Any]:
    """Returns a function that calls another one with the arguments in turn, over and over."""
    following = itertools.cycle(arguments)
    return lambda: function(next(following))
