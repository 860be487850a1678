"""What several tests need: worlds placed by hand, and records of what happens in them."""

import resource
from contextlib import contextmanager
from dataclasses import fields, replace
from unittest import mock

import numpy as np

from asv_env.geometry import direction, wrap
from asv_env.presets import make_params
from asv_env.sensing import observation
from asv_env.simulation import Simulation
from asv_env.tasks import starts
from baselines.rollout import runner

NO_DRAG = {"surge": (0.0, 0.0), "sway": (0.0, 0.0), "yaw": (0.0, 0.0)}
NO_VESSEL_DRAG = {**NO_DRAG, "fins": 0.0}
ROUND = {"boat": {"added_mass": (0.02, 0.02)}, "vessel": {"added_mass": (0.08, 0.08)}}
"""Hulls with as much added mass in surge as in sway, for which contact has no privileged axis."""
SEEN = len(observation.NAMES)
"""Numbers that a boat observes."""
DOWN = -np.pi / 2
"""Heading of a boat that pushes the vessel from its +n side."""
AHEAD, OFF = (1.0, 1.0), (0.0, 0.0)
"""Commands of both thrusters: full ahead, and off."""
VESSEL, BOAT = 0, 1
"""Rows of the vessel and the first boat."""


def open_water(num_boats=2, rate=50, control=None, **options):
    """Parameters of a wide basin where nothing ends an episode; thrusters driven directly.

    Args:
        num_boats: 2 or more.
        rate: of the physics, Hz.
        control: of actions and records, Hz; None records every physics step.
        **options: as of ``make_params``.
    """
    control = rate if control is None else control
    free = {
        "action_mode": "thrusters",
        "clock": {"physics": rate, "sensing": control, "control": control},
        "arena": 100.0,
        "goal": (90.0, 90.0, 0.0),
        "time_limit": 1e5,
    }
    return make_params("push", num_boats, **{**free, **options})


def dragless(hulls=None, **options):
    """Parameters of open water without drag; ``hulls`` may be ``ROUND``."""
    no_drag = {"boat": NO_DRAG, "vessel": NO_VESSEL_DRAG}
    if hulls:
        no_drag = {name: {**drag, **hulls[name]} for name, drag in no_drag.items()}
    return open_water(**{**no_drag, **options})


def bodies(vessel=(), *boats):
    """Motion (B, 6) of a vessel and boats; each row may leave out its last entries."""
    motion = np.zeros((1 + len(boats), 6))
    for row, given in zip(motion, (vessel, *boats), strict=True):
        row[: len(given)] = given
    return motion


@contextmanager
def no_larger_than(size):
    """Files cannot grow beyond a size, bytes, as on a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


class World:
    """Simulation of one world that begins with a given motion (B, 6)."""

    def __init__(self, params, motion, **start):
        self.params = params
        self.sim = Simulation(params)
        begin_at(self.sim, [motion], **start)

    @property
    def motion(self):
        return self.sim.state.motion[0]

    @property
    def thrust(self):
        return self.sim.state.thrust[0]

    def step(self, action=0.0):
        self.sim.step(actions(self.sim, action))
        return self.motion

    def run(self, seconds, action=0.0):
        """Motion (B, 6) after some time under one action."""
        for _ in range(round(seconds * self.params.clock.control)):
            self.step(action)
        return self.motion

    def record(self, seconds, action=0.0):
        """Motions (T + 1, B, 6) at every control tick, headings unwrapped."""
        ticks = round(seconds * self.params.clock.control)
        motions = np.array([self.motion] + [self.step(action) for _ in range(ticks)])
        motions[..., 2] = np.unwrap(motions[..., 2], axis=0)
        return motions


def begin_at(sim, motions, mask=None, **start):
    """Resets worlds to given motions (n, B, 6) and other fields of ``InitialState``."""
    sample, waiting = starts.sample, iter(motions)

    def given(params, rng, goal=None):
        return replace(sample(params, rng, goal), motion=np.array(next(waiting)), **start)

    with mock.patch.object(sim, "_initial_states", given):
        return sim.reset(mask, seeds=[0] * len(motions))


def actions(sim, action):
    """An action of any shape that broadcasts, for all boats of all worlds."""
    return np.broadcast_to(np.asarray(action, dtype=np.float32), sim.state.thrust.shape)


def masses(params):
    """Effective masses and inertias (B, 3) of vessel and boats: surge, sway, yaw."""
    vessel, boat = params.hulls()
    return np.array([vessel.masses] + [boat.masses] * params.num_boats)


def momenta(params, motion):
    """Linear momentum (..., B, 2) of each body of motions (..., B, 6), kg m/s, world frame."""
    mass, ahead = masses(params), np.exp(1j * motion[..., 2])
    own = (motion[..., 3] + 1j * motion[..., 4]) / ahead
    vector = (mass[:, 0] * own.real + 1j * mass[:, 1] * own.imag) * ahead
    return np.stack([vector.real, vector.imag], axis=-1)


def momentum(params, motion):
    """Linear momentum (..., 2) of all bodies of motions (..., B, 6), kg m/s."""
    return momenta(params, motion).sum(axis=-2)


def kinetic_energy(params, motion):
    """Kinetic energy (...,) of motions (..., B, 6), J, that of the water with them included."""
    own = (motion[..., 3] + 1j * motion[..., 4]) * np.exp(-1j * motion[..., 2])
    squares = np.stack([own.real, own.imag, motion[..., 5]], axis=-1) ** 2
    return 0.5 * (masses(params) * squares).sum(axis=(-1, -2))


def terminal(force, linear, quadratic):
    """Speed at which (linear + quadratic v) v balances a force."""
    if quadratic == 0:
        return force / linear
    return (np.sqrt(linear**2 + 4 * quadratic * force) - linear) / (2 * quadratic)


def turned(motion, angle, shift=0j):
    """Motions or poses (..., 3 or 6) of a world turned about its origin, then moved."""
    moved = np.array(motion, dtype=float)
    for column in (0, 3)[: moved.shape[-1] // 3]:
        vector = (moved[..., column] + 1j * moved[..., column + 1]) * np.exp(1j * angle)
        vector = vector + (shift if column == 0 else 0)
        moved[..., column], moved[..., column + 1] = vector.real, vector.imag
    moved[..., 2] = (moved[..., 2] + angle + np.pi) % (2 * np.pi) - np.pi
    return moved


def copied(record):
    """A record whose arrays stay what they are while the simulation continues."""
    return type(record)(**{f.name: np.array(getattr(record, f.name)) for f in fields(record)})


def known_at_start(params, seeds):
    """What the boats know at the start of episodes."""
    sim = Simulation(params, len(seeds))
    sim.reset(seeds=list(seeds))
    return copied(sim.sensed)


def moved(sensed, poses):
    """The same with vessels at other poses (W, 3), their boats taken along."""
    motion, old = sensed.measured.copy(), sensed.measured[:, :1]
    turn = poses[:, None, 2] - old[..., 2]
    offset = motion[..., 0] - old[..., 0] + 1j * (motion[..., 1] - old[..., 1])
    offset = offset * direction(turn)
    motion[..., 0], motion[..., 1] = poses[:, :1] + offset.real, poses[:, 1:2] + offset.imag
    motion[..., 2] = wrap(motion[..., 2] + turn)
    return replace(sensed, measured=motion, estimate=motion)


def decide(policy, sensed, memory=None):
    """One decision of a policy that reads ``sensed`` alone, and its memory."""
    fresh = np.full(len(sensed.side), memory is None)
    return policy.act(sensed, np.empty(0), memory, fresh)


def same(one, other):
    """Whether two returned values are equal in type, shape and every bit; NaN equals NaN."""
    if type(one) is not type(other):
        return False
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[k], other[k]) for k in one)
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, np.ndarray):
        if one.shape != other.shape or one.dtype != other.dtype:
            return False
        if one.dtype == object:
            return all(map(same, one.flat, other.flat))
        return one.tobytes() == other.tobytes() or np.array_equal(one, other, equal_nan=True)
    return one == other or (one != one and other != other)


def successes(policy, params, episodes, enough):
    """Number of successes in episodes side by side, which end as soon as there are enough."""
    done = 0
    for log in runner.run(policy, params, range(episodes), episodes):
        done += log.episode.success
        if done == enough:
            break
    return done


def play(sim, ticks, seed=0):
    """All that comes of random actions; worlds that end begin their next episode."""
    rng, seen = np.random.default_rng(seed), []
    for _ in range(ticks):
        step = sim.step(rng.uniform(-0.3, 1.0, sim.state.thrust.shape))
        over = step.ending.terminated | step.ending.truncated
        seen += [step.observation, step.reward, *vars(sim.sensed).values()]
        if over.any():
            seen.append(sim.reset(over))
    return seen
