"""The compiled laws agree with another formulation, in NumPy, to rounding."""

import numpy as np
import pytest
from helpers import actions

from asv_env import Simulation, make_params
from asv_env.params import NOMINAL_LENGTH
from asv_env.sensing import observation
from asv_env.sensing.view import View
from asv_env.tasks import TASKS, formation, reward

W = 5
CASES = pytest.mark.parametrize(
    ("task", "options"),
    [
        ("push", {"scenario": "harsh", "num_boats": 4}),
        ("push", {"scenario": "gyre", "num_boats": 7, "vessel": {"length": 0.7}}),
        ("transport", {"scenario": "failure", "num_boats": 3}),
        ("approach", {"scenario": "noisy", "num_boats": 2}),
        ("transport", {"scenario": "current", "num_boats": 12, "side": "goal"}),
    ],
)


def driven(task, options, ticks=60):
    """A simulation after each of some ticks, with the state before it and what it gave back."""
    sim, rng = Simulation(make_params(task, **options), W), np.random.default_rng(5)
    sim.reset(seeds=range(W))
    for tick in range(ticks):
        if tick % 7 == 0:
            action = rng.uniform(-1, 1, sim.state.thrust.shape)
        before, totals = sim.state, sim.summary()
        done = sim.step(actions(sim, action))
        yield sim, before, totals, done
        if done.ending.terminated.any():
            return


def close(found, expected):
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


def rotated(vectors, angle):
    """Vectors (..., 2), turned by minus an angle."""
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([cos * x + sin * y, cos * y - sin * x], axis=-1)


def pairs(numbers):
    return np.stack([numbers.real, numbers.imag], axis=-1)


def between(angle):
    """An angle in (-pi, pi]."""
    return np.arctan2(np.sin(angle), np.cos(angle))


class Relations:
    """What is known of teams, vessels and goals from a motion, in plain x and y."""

    def __init__(self, motion, goal, slot, side):
        vessel, boats = motion[:, :1], motion[:, 1:]
        self.heading, self.boat_heading = vessel[..., 2], boats[..., 2]
        offset = boats[..., :2] - vessel[..., :2]
        self.boat = rotated(offset, self.heading)
        self.gap = pairs(slot) - self.boat
        self.slot_error = np.hypot(*np.moveaxis(self.gap, -1, 0))
        across = self.heading - side[:, None] * np.pi / 2
        self.turned = between(self.boat_heading - across)
        rate = vessel[..., 5]
        carried = np.stack([-rate * offset[..., 1], rate * offset[..., 0]], axis=-1)
        self.slip = boats[..., 3:5] - vessel[..., 3:5] - carried
        self.goal = rotated(goal[:, :2] - motion[:, 0, :2], motion[:, 0, 2])
        self.distance = np.hypot(*self.goal.T)
        self.heading_error = between(motion[:, 0, 2] - goal[:, 2])


def potentials(relations, state, params):
    """Those of all worlds (W, 3): to the slots, to the goal, precision."""
    length, size = params.vessel.length, params.vessel.length / NOMINAL_LENGTH
    error = np.ma.array(relations.slot_error, mask=~state.working)
    turn, (x, y) = -relations.heading_error, relations.goal.T
    # The team pushes to -n from the +n side, and to +n from the other.
    bearing = np.arctan2(state.side * x, -state.side * y)
    first = relations.distance + 0.25 * size * (abs(bearing) + abs(between(turn - bearing)))
    second = 4.0 * relations.distance + 0.25 * size * abs(turn)
    squares = (relations.distance / (0.08 * size)) ** 2 + (turn / 0.2) ** 2
    to_slots = -error.mean(axis=1).data / length
    return np.stack([to_slots, -np.minimum(first, second) / length, np.exp(-squares)], axis=1)


def of(state):
    return Relations(state.motion, state.goal, state.slot, state.side)


@CASES
def test_relations(task, options):
    for sim, *_ in driven(task, options, 20):
        expected, state = of(sim.state), sim.state
        found = formation.relate(state.motion, state.goal, state.slot, state.side)
        close(pairs(found.boat), expected.boat)
        close(pairs(found.slot_gap), expected.gap)
        close(found.slot_error, expected.slot_error)
        close(between(np.angle(found.alignment) - expected.turned), 0.0)
        close(pairs(found.slip), expected.slip)
        close(pairs(found.goal), expected.goal)
        close(found.goal_error, expected.distance)
        close(between(found.heading_error - expected.heading_error), 0.0)
        close(pairs(found.velocity), state.motion[..., 3:5])


@CASES
def test_slots_are_occupied_and_closure_is_lost(task, options):
    for sim, before, _, _ in driven(task, options):
        state, p = sim.state, sim.params.task
        kept = (state.slot == before.slot).all(axis=1) & (state.goal == before.goal).all(axis=1)
        seen = of(state)
        rests = (abs(seen.turned) < p.slot_angle) & (
            np.hypot(*np.moveaxis(seen.slip, -1, 0)) < p.slot_speed
        )
        occupied = rests & (seen.slot_error < p.slot_distance)
        np.testing.assert_array_equal(state.occupied, occupied)
        idle = ~before.working
        formed = (occupied | idle).all(axis=1)
        near = ((seen.slot_error <= 2 * p.slot_distance) | idle).all(axis=1)
        closed = formed | (before.closed & near)
        np.testing.assert_array_equal(state.closed[kept], closed[kept])
        counted = np.where(formed, before.occupied_ticks + 1, 0)
        np.testing.assert_array_equal(state.occupied_ticks[kept], counted[kept])


@CASES
def test_reward_terms(task, options):
    for sim, before, _, done in driven(task, options):
        state, params = sim.state, sim.params
        price, second = params.reward, 1.0 / params.clock.control
        kept = (state.slot == before.slot).all(axis=1) & (state.goal == before.goal).all(axis=1)
        kept &= (state.working == before.working).all(axis=1)
        rise = potentials(of(state), state, params) - potentials(of(before), before, params)
        rise = np.clip(rise, -1.0, 1.0)
        seen, ending = of(state), done.ending
        size = params.vessel.length / NOMINAL_LENGTH
        squares = (seen.distance / (0.02 * size)) ** 2 + (seen.heading_error / 0.05) ** 2
        accuracy = 0.0 if task == "approach" else price.accuracy
        success = price.success * (1.0 - accuracy * (1.0 - np.exp(-squares)))
        left = params.time_limit_ticks - state.tick
        full = params.boat.thrust**2
        lost = price.strayed + price.time * second * left
        expected = {
            "closure": price.closure * rise[:, :1],
            "delivery": price.delivery * rise[:, 1:2],
            "precision": price.precision * rise[:, 2:],
            "success": (ending.reached * success)[:, None],
            "strayed": ending.strayed[:, None] * -lost[:, None],
            "time": np.full((W, 1), -price.time * second),
            "effort": -price.effort * second * (state.thrust**2).mean(axis=-1) / full,
            "collision": -price.collision * second * state.touching[..., 1],
        }
        assert set(done.terms) == set(expected)
        weightless = {term.name for term in TASKS[task].reward if term.weight == 0.0}
        total = np.zeros(done.reward.shape)
        for name, value in expected.items():
            value = 0.0 * value if name in weightless else value
            close(done.terms[name][kept], value[kept])
            total += value
        close(done.reward[kept], total[kept])


@CASES
def test_metrics(task, options):
    for sim, before, totals, done in driven(task, options):
        found, state, seen = sim.summary(), sim.state, of(sim.state)
        close(found["position_error"], seen.distance)
        close(between(found["heading_error"] - seen.heading_error), 0.0)
        moved = np.hypot(*(state.motion - before.motion)[:, 0, :2].T)
        close(found["path_length"] - totals["path_length"], moved)
        full = sim.params.boat.thrust * sim.params.clock.control
        close(found["effort"] - totals["effort"], abs(state.thrust).mean(axis=(1, 2)) / full)
        bumps = (state.touching[..., 1] & ~before.touching[..., 1]).sum(axis=1)
        np.testing.assert_array_equal(found["collisions"] - totals["collisions"], bumps)
        close(found["episode_return"] - totals["episode_return"], done.reward.mean(axis=1))


@CASES
def test_observation(task, options):
    for sim, *_, done in driven(task, options, 30):
        known, params = sim.sensed, sim.params
        seen = Relations(known.estimate, known.goal, known.slot, known.side)
        boats, vessel = known.estimate[:, 1:], known.estimate[:, :1]
        count, ones = known.working.sum(axis=1), np.ones(known.slot.shape)
        all_boats = ones[..., None]
        vessel_velocity = rotated(vessel[..., 3:5], seen.heading)
        turn = -seen.heading_error
        half = np.array([params.vessel.length, params.vessel.width]) / 2
        to_hull = np.clip(seen.boat, -half, half) - seen.boat  # of boats outside
        values = {
            "own_velocity": rotated(boats[..., 3:5], seen.boat_heading),
            "slot": rotated(seen.gap, seen.boat_heading - seen.heading),
            "slot_alignment": np.stack([np.cos(seen.turned), np.sin(seen.turned)], axis=-1),
            "own_position": seen.boat,
            "slot_position": pairs(known.slot),
            "vessel_velocity": vessel_velocity * all_boats,
            "goal": seen.goal[:, None] * all_boats,
            "goal_direction": np.stack([np.cos(turn), np.sin(turn)], axis=-1)[:, None] * all_boats,
            "own_yaw_rate": boats[..., 5],
            "vessel_yaw_rate": vessel[..., 5] * ones,
            "touches_vessel": known.touching[..., 0],
            "touches_other": known.touching[..., 1],
            "thrusters_work": known.working,
            "slots_occupied": ((known.occupied & known.working).sum(1) / count)[:, None] * ones,
            "closure": known.closed[:, None] * ones,
            "turn_to_goal": turn[:, None] * ones,
            "inverse_team_size": (1 / count)[:, None] * ones,
            "inverse_vessel_length": ones / params.vessel.length,
            "vessel_seen": ones,
            "hull": rotated(to_hull, seen.boat_heading - seen.heading),
            "neighbours": neighbours(boats),
        }
        for fine in ("slot", "hull", "goal", "vessel_velocity", "turn_to_goal", "vessel_yaw_rate"):
            values[f"{fine}_fine"] = values[fine]
        lengths = dict(zip(observation.SCALES, observation.units(params), strict=True))
        columns = []
        for feature in observation.DEFAULT:
            if feature.name.endswith("obstacles"):  # There are none.
                values[feature.name] = np.zeros((*ones.shape, len(feature.scale)))
            value = values[feature.name].reshape(*known.slot.shape, -1)
            close(columns_of(feature.value(View(known, params))), value)
            scale = np.array([lengths.get(one, one) for one in feature.scale], dtype=float)
            columns.append(np.clip(value / scale, -np.array(feature.bound), feature.bound))
        expected = np.concatenate(columns, axis=-1)
        np.testing.assert_allclose(done.observation, expected, rtol=2e-7, atol=1e-7)


def columns_of(value):
    """What a feature's function returns, as columns (W, A, n)."""
    value = pairs(value) if value.dtype.kind == "c" else value
    return value if value.ndim == 3 else value[..., None]


def neighbours(boats):
    """The nearest four boats of each (W, A, 20), in its frame."""
    worlds, team = boats.shape[:2]
    found = np.zeros((worlds, team, 4, 5))
    for world in range(worlds):
        for boat in range(team):
            gap = boats[world] - boats[world, boat]
            order = sorted(range(team), key=lambda k: np.hypot(*gap[k, :2]))
            others = [k for k in order if k != boat][:4]
            heading = boats[world, boat, 2]
            for place, k in enumerate(others):
                place_of = found[world, boat, place]
                place_of[:2] = rotated(gap[k, :2], heading)
                place_of[2:4] = rotated(gap[k, 3:5], heading)
                place_of[4] = 1.0
    return found.reshape(worlds, team, 20)


def test_built_in_functions_give_users_what_is_paid():
    sim, before, _, done = list(driven("transport", {"scenario": "harsh", "num_boats": 4}, 12))[-1]
    now = reward.Transition(before, sim.state, done.ending, sim.params)
    for term in reward.TERMS:
        if term.value is not None:
            value = term.value(now)
            close(value[:, None] if term.shared else value, done.terms[term.name])
    seen = potentials(of(sim.state), sim.state, sim.params)
    for column, name in enumerate(("closure", "delivery", "precision")):
        (law,) = (term.potential for term in reward.TERMS if term.name == name)
        close(law(now.relations, sim.state, sim.params), seen[:, column])
