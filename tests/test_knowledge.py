"""What boats and policies know: nothing but what was measured, as late and as often as it came."""

import copy
import itertools
import pickle
from dataclasses import fields, replace
from functools import cache
from unittest import mock

import numpy as np
import pytest
from helpers import copied, play, same
from hypothesis import given, settings
from hypothesis import strategies as st

from asv_env import Simulation, make_params
from asv_env.geometry import wrap
from asv_env.presets import NOISE
from asv_env.sensing.observation import NAMES
from asv_env.sensing.sensors import Sensors
from asv_env.tasks import formation, standing
from asv_env.types import Sensed, Standing, State, frozen
from baselines.scripted import ScriptedPolicy

ON_BOARD = ("touching",)
"""Fields that a boat measures itself, exactly."""
FELT = [NAMES.index(name) for name in ("touches_vessel", "touches_other")]
RARE = {"sensors": {**NOISE, "delay": 0.2, "dropout": 0.5}}
"""All that sensing can suffer from, at once."""
FAILURE = {"failures": 1, "failure_time": (0.5, 2.0)}
WORLDS = [
    {"scenario": "noisy"},
    {"scenario": "dropout"},
    # Without noise nothing would be measured by ``Sensors._measured``.
    {"task": "push", "scenario": "delay", "sensors": {"position_noise": 1e-6}},
    {"task": "push", "scenario": RARE, "variation": FAILURE},
    {"scenario": "noisy", "preset": "experiment"},
]
NOISY, EXPERIMENT = 0, len(WORLDS) - 1
worlds = pytest.mark.parametrize("world", range(len(WORLDS)))


def begun(count=4, task="transport", **options):
    sim = Simulation(make_params(task, **options), count)
    sim.reset(seeds=range(count))
    return sim


def driven(sim, ticks):
    """What comes of the scripted policy: actions, and what is known and true after each."""
    policy, memory, fresh = ScriptedPolicy(sim.params), None, np.ones(sim.num_worlds, dtype=bool)
    seen = []
    for _ in range(ticks):
        action, memory = policy.act(sim.sensed, None, memory, fresh)
        fresh = np.zeros_like(fresh)
        taken = sim.step(action)
        seen.append((action, taken, copied(sim.sensed), sim.state))
        if (taken.ending.terminated | taken.ending.truncated).any():
            break
    return seen


@cache
def drive(world, count=4):
    """A simulation before its first step, what came of the scripted policy, and what was measured.

    It is one of ``WORLDS``.
    """
    tape, measure = [], Sensors._measured

    def record(sensors, index, motion):
        measured, outcome = measure(sensors, index, motion)
        tape.append((measured.copy(), outcome))
        return measured, outcome

    with mock.patch.object(Sensors, "_measured", record):
        sim = begun(count, **WORLDS[world])
        return copy.copy(sim), driven(sim, 400), tape


def walk(sim, ticks):
    """What is sensed at the beginning and after each of some ticks of random actions."""
    rng, shape = np.random.default_rng(0), sim.state.thrust.shape
    seen = [sim.sensed]
    truth = [sim.state.motion]
    for _ in range(ticks):
        sim.step(rng.uniform(-1.0, 1.0, shape))
        seen.append(sim.sensed)
        truth.append(sim.state.motion)
    return seen, np.array(truth)


def stacked(seen, name):
    return np.array([getattr(one, name) for one in seen])


# ------------------------------------------------------- truth is in neither input


@worlds
def test_what_is_known_follows_from_what_was_measured_alone(world, monkeypatch):
    """A world in which nobody moves, measured as another was, is known as the other was."""
    _, seen, tape = drive(world)
    assert stacked([one[2] for one in seen], "closed").any()
    tape_again = iter(tape)

    def replay(sensors, index, motion):
        measured, outcome = next(tape_again)
        return measured.copy(), outcome

    monkeypatch.setattr(Sensors, "_measured", replay)
    other = begun(**WORLDS[world])
    apart = 0.0
    for action, taken, known, state in seen:
        step = other.step(np.zeros_like(action))
        now = other.sensed
        for field in fields(Sensed):
            if field.name not in ON_BOARD:
                assert same(getattr(now, field.name), getattr(known, field.name)), field.name
        columns = np.delete(np.arange(len(NAMES)), FELT)
        assert same(step.observation[..., columns], taken.observation[..., columns])
        apart = max(apart, np.abs(other.state.motion - state.motion)[..., :2].max())
    assert apart > 0.1, "the truths are not the same"


@worlds
def test_the_judge_sees_the_truth_alone(world):
    """With the same actions, states, rewards and endings are those of a world without noise."""
    options = {**WORLDS[world], "goal_anchor": "world"}
    exact = begun(**{**options, "sensors": exactly()})
    seen = driven(begun(**options), 400) if world == EXPERIMENT else drive(world)[1]
    for action, taken, _, state in seen:
        step = exact.step(action)
        for field in fields(State):
            assert same(getattr(exact.state, field.name), getattr(state, field.name)), field.name
        assert same(step.reward, taken.reward)
        assert same(step.ending.reached, taken.ending.reached)


def exactly():
    return dict.fromkeys([*NOISE, "dropout"], 0.0) | {"delay": 0.0}


def test_estimate_and_truth_disagree_on_closure():
    _, seen, _ = drive(NOISY, 16)
    believed = stacked([one[2] for one in seen], "closed")
    true = stacked([one[3] for one in seen], "closed")
    assert (believed & ~true).any()
    assert (true & ~believed).any()
    assert (believed == true).mean() > 0.9


def test_without_noise_the_truth_is_known():
    for _, _, known, state in driven(begun(scenario="failure"), 350):
        for field in fields(Standing):
            assert same(getattr(known, field.name), getattr(state, field.name))
        assert same(known.estimate, state.motion)
        assert known.received.all()


@pytest.mark.parametrize("noise", [0.01, 0.3])
def test_slots_are_assigned_by_the_first_measurement(noise):
    sim = begun(24, sensors={"position_noise": noise})
    known, differ = sim.sensed, 0
    for world in range(24):
        for record, motion in ((known, known.measured), (sim.state, sim.state.motion)):
            least, one = record.slot.copy(), np.array([world])
            teams = motion, record.working, record.side
            formation.assign_slots(sim.params, *teams, least, one)
            least = least[world]
            assert same(record.slot[world], least)
        differ += not same(known.slot[world], sim.state.slot[world])
    assert (differ > 6) == (noise > 0.1)


def test_occupied_slots_are_those_of_the_estimate():
    sim, seen, _ = drive(NOISY, 16)
    column, disagree = NAMES.index("slots_occupied"), False
    for _, taken, known, state in seen:
        held = standing.advanced(known, known.estimate, sim.params, 1).occupied
        assert same(known.occupied, held)
        np.testing.assert_allclose(taken.observation[..., column], held.mean(1)[:, None] + 0 * held)
        disagree |= (held != state.occupied).any()
    assert disagree


def test_a_goal_is_anchored_by_the_teams_closure_where_the_vessel_seems_to_be():
    sim, seen, _ = drive(EXPERIMENT)
    x, y, heading = sim.params.task.goal
    before = sim.sensed.anchored
    for _, _, known, state in seen:
        assert same(known.anchored, state.anchored)
        assert same(known.goal, state.goal)
        for world in np.flatnonzero(known.anchored & ~before):
            assert known.closed[world]
            goal, vessel = known.goal[world], known.estimate[world, 0]
            point = vessel[0] + 1j * vessel[1] + (x + 1j * y) * np.exp(1j * vessel[2])
            np.testing.assert_allclose(goal[:2], [point.real, point.imag])
            assert wrap(goal[2] - vessel[2] - heading) == pytest.approx(0.0, abs=1e-12)
        before = known.anchored
    assert before.any()


@pytest.mark.parametrize(("noise", "seen"), [(1e-4, True), (0.5, False)])
def test_boats_that_rest_in_each_others_slots_swap_them_when_they_seem_to_rest(noise, seen):
    sim = begun(1, task="push", sensors={"speed_noise": noise})
    slot, order = sim.state.slot, [1, 0, 2, 3]
    swapped = {"slot": slot[:, order], "closed": np.zeros(1, dtype=bool)}
    sim._state = frozen(replace(sim._state, **swapped))
    sim._knowledge.sensed = replace(sim._knowledge.sensed, **swapped)
    sim.step(np.zeros((1, 4, 2)))
    assert same(sim.state.slot, slot)
    assert same(sim.sensed.slot, slot if seen else slot[:, order])
    sim.step(np.zeros((1, 4, 2)))
    assert sim.state.closed.all()
    assert sim.sensed.closed.all() == seen


def test_rates_are_those_of_the_estimate():
    sim = begun(3, sensors={"speed_noise": 0.05, "yaw_rate_noise": 0.5})
    names = ["own_velocity_x", "own_velocity_y", "own_yaw_rate"]
    columns = [NAMES.index(name) for name in names]
    boat = sim.params.boat
    for _ in range(20):
        observed = sim.step(np.full((3, 4, 2), 0.5)).observation[..., columns]
        motion = sim.sensed.estimate[:, 1:]
        velocity = (motion[..., 3] + 1j * motion[..., 4]) * np.exp(-1j * motion[..., 2])
        scaled = [velocity.real / boat.full_speed, velocity.imag / boat.full_speed]
        scaled = np.stack([*scaled, motion[..., 5] / boat.full_yaw_rate], axis=-1)
        np.testing.assert_allclose(observed, np.clip(scaled, -4.0, 4.0), atol=1e-6)


# ------------------------------------------------------------------ delay


@given(ticks=st.integers(0, 7), noisy=st.booleans(), sensing=st.sampled_from([10, 20, 50]))
@settings(max_examples=15, deadline=None)
def test_a_delay_shifts_what_is_known_by_whole_control_ticks(ticks, noisy, sensing):
    noise = NOISE if noisy else {}
    options = {"clock": {"physics": 100, "sensing": sensing}}
    late, _ = walk(begun(2, sensors={**noise, "delay": ticks / 10}, **options), 20)
    prompt, truth = walk(begun(2, sensors=noise, **options), 20)
    for tick, known in enumerate(late):
        then = max(tick - ticks, 0)
        assert same(known.measured, prompt[then].measured)
        assert same(known.estimate, prompt[then].estimate)
        assert noisy or same(known.estimate, truth[then])
        assert known.received.all() == (tick == 0 or tick > ticks)
        assert known.received.any() == known.received.all()
        assert (known.tick == tick).all()


def test_a_boat_feels_its_own_contact_and_failure_at_once():
    sim = begun(8, task="push", sensors={"delay": 1.0}, variation=FAILURE)
    for _ in range(30):
        sim.step(np.full((8, 4, 2), (0.3, 0.0)))
        for name in ("touching", "working", "tick", "side"):
            assert same(getattr(sim.sensed, name), getattr(sim.state, name))
    assert sim.sensed.touching.any()
    assert not sim.sensed.working.all()


# ------------------------------------------------------------------ dropout


@pytest.mark.parametrize("dropout", [0.1, 0.5, 0.95])
def test_measurements_are_lost_as_often_as_said_and_independently(dropout):
    sim = begun(16, sensors={**NOISE, "dropout": dropout})
    received = stacked(walk(sim, 200)[0], "received")
    assert received[0].all()
    lost = ~received[1:]
    count = lost.size
    assert abs(lost.sum() - count * dropout) < 4.5 * np.sqrt(count * dropout * (1 - dropout))
    rest = (lost - dropout) / np.sqrt(dropout * (1 - dropout))
    for one, other in (
        (rest[1:], rest[:-1]),
        (rest[:, 1:], rest[:, :-1]),
        (rest[..., 1:], rest[..., :-1]),
    ):
        assert abs((one * other).mean()) < 4.5 / np.sqrt(one.size)


def test_the_latest_measurement_that_came_is_kept():
    """What comes is what comes without losses: these draw from a Generator of their own."""
    some, _ = walk(begun(3, sensors={**NOISE, "dropout": 0.5}), 150)
    every, _ = walk(begun(3, sensors=NOISE), 150)
    for before, now, all_now in zip(some, some[1:], every[1:], strict=False):
        assert same(now.measured[now.received], all_now.measured[now.received])
        assert same(now.measured[~now.received], before.measured[~now.received])
        assert all_now.received.all()


def test_the_filter_predicts_what_it_does_not_get():
    sim = begun(3, sensors={**NOISE, "dropout": 0.5})
    known, _ = walk(sim, 100)
    for before, now in itertools.pairwise(known):
        predicted = before.estimate.copy()
        predicted[..., :3] += 0.1 * predicted[..., 3:]
        predicted[..., 2] = wrap(predicted[..., 2])
        assert same(now.estimate[~now.received], predicted[~now.received])
        assert not (now.estimate == predicted)[now.received].any()


def test_a_measurement_of_the_control_tick_is_received_if_one_of_its_sensing_ticks_is():
    options = {"clock": {"sensing": 50}}
    sim = begun(16, sensors={"dropout": 0.8}, **options)
    received = stacked(walk(sim, 200)[0], "received")[1:]
    share, count = 1 - 0.8**5, received.size
    assert abs(received.sum() - count * share) < 4.5 * np.sqrt(count * share * (1 - share))


@pytest.mark.parametrize("name", ["pose", "rate"])
def test_errors_of_the_estimate_grow_with_the_losses_and_stay_below_those_of_what_came(name):
    columns = slice(0, 3) if name == "pose" else slice(3, 6)

    def error(dropout, field):
        known, truth = walk(begun(16, sensors={**NOISE, "dropout": dropout}), 200)
        off = stacked(known, field) - truth
        off[..., 2] = wrap(off[..., 2])
        return np.sqrt((off[50:, :, :, columns] ** 2).mean(axis=(0, 1, 2)))

    shares = [error(dropout, "estimate") for dropout in (0.0, 0.3, 0.6)]
    assert (shares[0] < shares[1]).all()
    assert (shares[1] < shares[2]).all()
    assert (shares[1] < error(0.3, "measured")).all()


def test_without_noise_what_comes_is_exact():
    known, truth = walk(begun(3, sensors={"dropout": 0.4}), 60)
    came = stacked(known, "received")
    np.testing.assert_allclose(stacked(known, "estimate")[came], truth[came], atol=1e-9)
    assert same(stacked(known, "measured")[came], truth[came])
    assert not np.array_equal(stacked(known, "measured"), truth)


# ------------------------------------------------------------ worlds and copies


def test_a_world_is_known_the_same_in_every_batch():
    params = make_params("push", scenario=RARE, time_limit=8.0)
    many = Simulation(params, 5)
    many.reset(seeds=range(5))
    alone = Simulation(params)
    alone.reset(seeds=[3])
    for tick in range(100):
        action = np.random.default_rng(tick).uniform(-1, 1, (5, 4, 2))
        one, all_ = alone.step(action[3:4]), many.step(action)
        assert same(one.observation[0], all_.observation[3])
        for field in fields(Sensed):
            assert same(getattr(alone.sensed, field.name)[0], getattr(many.sensed, field.name)[3])
        if (over := all_.ending.truncated | all_.ending.terminated)[3]:
            assert same(alone.reset()[0], many.reset()[3])
        elif tick % 30 == 20 or over.any():
            over[[0, 4]] = True
            many.reset(over)


@pytest.mark.parametrize("scenario", ["delay", "dropout", RARE], ids=str)
def test_what_is_known_continues_in_copies_and_from_snapshots(scenario):
    sim = begun(3, task="push", scenario=scenario, time_limit=4.0)
    play(sim, 25)
    snapshot, twin = sim.snapshot(), pickle.loads(pickle.dumps(sim))
    expected = play(sim, 60, seed=1)
    assert same(play(twin, 60, seed=1), expected)
    play(sim, 5, seed=2)
    sim.restore(snapshot)
    assert same(play(sim, 60, seed=1), expected)


def test_what_is_known_may_be_written_to():
    sim, twin = begun(2, scenario=RARE), begun(2, scenario=RARE)
    for _ in range(5):
        for array in vars(sim.sensed).values():
            array[...] = 0
        assert same(play(sim, 1), play(twin, 1))


@pytest.mark.parametrize(
    ("name", "value"),
    [("dropout", 1.0), ("dropout", -0.1)],
)
def test_a_dropout_that_cannot_be_is_refused_by_name(name, value):
    with pytest.raises(ValueError, match=name):
        make_params(sensors={name: value})
