"""Boats with sensors of their own: who sees what, and teams whose boats each act on that."""

import pickle
from dataclasses import fields, replace

import numpy as np
import pytest
from helpers import begin_at, bodies, copied, decide, play, same, successes
from hypothesis import given, settings
from hypothesis import strategies as st

import asv_env
from asv_env import Simulation, make_params
from asv_env.geometry import wrap
from asv_env.presets import NOISE
from asv_env.sensing import feature_table
from asv_env.sensing.observation import NAMES, observe, own_rows, scalar
from asv_env.sensing.sensors import FADING
from asv_env.types import Sensed, rows
from baselines.distributed import Distributed, distributed
from baselines.policy import POLICIES
from baselines.rollout.guard import Guard
from baselines.rollout.loop import rollout
from baselines.scripted.scripted_policy import ScriptedPolicy, unfiltered

OWN = {"sensors": {"shared": False}}
"""Nothing is unseen, late, lost or noisy: every boat knows the truth."""
HARD = {"sensors": {**NOISE, "shared": False, "range": 0.6, "delay": 0.2, "dropout": 0.3}}
FAILURE = {"failures": 1, "failure_time": (0.5, 2.0)}


def begun(count=3, task="transport", **options):
    sim = Simulation(make_params(task, **options), count)
    sim.reset(seeds=range(count))
    return sim


def driven(sim, ticks, policy="scripted"):
    """Actions, steps, what is known and true after each, under a policy of the boats."""
    guard, seen = Guard(POLICIES[policy], sim.params), []
    for tick in rollout(sim, guard.act, range(sim.num_worlds), ticks):
        assert not guard.errors
        seen.append((tick.action, tick.step, copied(sim.sensed), copied(sim.state)))
    return seen


def by_boat(values, team=4):
    """Rows of all boats as (W, A, ...)."""
    return values.reshape(-1, team, *values.shape[1:])


# ------------------------------------------------------------ nothing lost, nothing changed


@pytest.mark.parametrize(
    ("policy", "options"),
    [
        ("scripted", {"preset": "experiment", "variation": FAILURE}),
        ("paper-tuned", {}),
        ("learned", {"task": "push"}),
    ],
    ids=str,
)
def test_boats_that_see_everything_exactly_do_what_a_team_with_one_measurement_does(
    policy, options
):
    options = {"time_limit": 12.0, **options}
    shared, each = (driven(begun(2, **options, **own), 140, policy) for own in ({}, OWN))
    for (action, step, known, state), (action_2, step_2, known_2, state_2) in zip(
        shared, each, strict=True
    ):
        assert same(action, action_2)
        assert same(step.observation, step_2.observation)
        assert same(step.reward, step_2.reward)
        for field in fields(state):
            assert same(getattr(state, field.name), getattr(state_2, field.name)), field.name
        for field in fields(Sensed):
            every = np.repeat(getattr(known, field.name), 4, axis=0)
            assert same(getattr(known_2, field.name), every), field.name


def test_a_filter_without_noise_or_range_changes_nothing_either():
    """The range is too large to matter, so only the path of the computation differs."""
    wide = {"sensors": {"shared": False, "range": 1e3}}
    exact, filtered = (driven(begun(2, **options), 60) for options in (OWN, wide))
    for (action, _, known, _), (action_2, _, known_2, _) in zip(exact, filtered, strict=True):
        np.testing.assert_allclose(action_2, action, atol=1e-5)
        np.testing.assert_allclose(known_2.estimate, known.estimate, atol=1e-8)
        assert known_2.seen.all()


# ------------------------------------------------------------ who sees what


@given(reach=st.floats(0.2, 3.0), delay=st.sampled_from([0.0, 0.3]))
@settings(max_examples=10)
def test_a_boat_sees_what_is_within_its_range(reach, delay):
    sim = begun(4, sensors={"shared": False, "range": reach, "delay": delay})
    rng, truth = np.random.default_rng(0), [sim.state.motion]
    for tick in range(1, 12):
        known = sim.step(rng.uniform(-1, 1, (4, 4, 2))) and sim.sensed
        truth.append(sim.state.motion)
        then = tick - round(10 * delay)
        if then < 1:  # The briefing is all that is known.
            assert known.seen.all()
            assert same(known.estimate, np.repeat(truth[0], 4, axis=0))
            continue
        point = truth[then][..., 0] + 1j * truth[then][..., 1]
        near = np.abs(point[:, 1:, None] - point[:, None, :]) <= reach
        assert same(by_boat(known.seen), near)
        assert same(known.received, known.seen)
        own = by_boat(known.estimate)[:, range(4), range(1, 5)]
        np.testing.assert_allclose(own, truth[then][:, 1:], atol=1e-8)
        came = np.repeat(truth[then], 4, axis=0)[known.seen]
        assert same(known.measured[known.seen], came)


def test_what_is_unseen_is_dead_reckoned_and_its_rates_fade():
    params = make_params("push", sensors={"shared": False, "range": 1.0}, goal=(0.5, -0.5, 0.0))
    sim = Simulation(params)
    far = bodies((), *[(0.9 + 0.9 * k, 0.0, 1.6, 0.0, 0.1) for k in range(3)], (-1.0, 0.5, 1.6))
    begin_at(sim, [far])
    before = sim.sensed
    for _ in range(10):
        sim.step(np.full((1, 4, 2), (0.5, 0.3)))
        now = sim.sensed
        hidden = ~now.seen
        expected = before.estimate + 0.1 * np.concatenate(
            [before.estimate[..., 3:], np.zeros((4, 5, 3))], axis=-1
        )
        expected[..., 2] = wrap(expected[..., 2])
        expected[..., 3:] *= np.exp(-0.1 / FADING)
        np.testing.assert_allclose(now.estimate[hidden], expected[hidden], atol=1e-12)
        assert same(now.measured[hidden], before.measured[hidden])
        before = now
    assert now.seen.tolist() == [
        [True, True, True, False, False],
        [False, True, True, True, False],
        [False, False, True, True, False],
        [False, False, False, False, True],
    ]


def test_a_body_that_comes_into_sight_is_known_by_its_measurement_alone():
    noisy = {**NOISE, "shared": False, "range": 1.2}
    seen = driven(begun(4, sensors=noisy), 150)
    appears, was = 0, np.ones((16, 5), dtype=bool)
    for _, _, known, _ in seen:
        new = known.seen & ~was
        assert same(known.estimate[new], known.measured[new])
        appears, was = appears + new.sum(), known.seen
    assert appears > 5


def test_observers_have_noise_of_their_own_and_one_briefing():
    sim = begun(2, sensors={**NOISE, "shared": False})
    first = by_boat(sim.sensed.measured)
    assert same(first, np.repeat(first[:, :1], 4, axis=1))
    noise = []
    for _ in range(300):
        sim.step(np.zeros((2, 4, 2)))
        off = by_boat(sim.sensed.measured) - sim.state.motion[:, None]
        off[..., 2] = wrap(off[..., 2])
        noise.append(off / [0.01, 0.01, 0.05, 0.01, 0.01, 0.1])
    noise = np.moveaxis(np.array(noise), 2, 0).reshape(4, -1)  # by observer
    limit = 4.5 / np.sqrt(noise.shape[1])
    assert np.abs(noise.mean(axis=1)).max() < limit
    np.testing.assert_allclose(np.corrcoef(noise), np.eye(4), atol=limit)
    assert np.abs(noise.std(axis=1) - 1).max() < limit


def test_losses_are_each_observers_own_and_never_of_itself():
    sim = begun(4, sensors={"shared": False, "dropout": 0.4})
    received = []
    for _ in range(200):
        sim.step(np.zeros((4, 4, 2)))
        known = sim.sensed
        received.append(by_boat(known.received))
        assert known.seen.all(), "a lost measurement does not hide a body"
    received = np.array(received)
    itself = np.zeros((4, 5), dtype=bool)
    itself[range(4), range(1, 5)] = True
    assert received[:, :, itself].all()
    lost = ~received[:, :, ~itself].reshape(200, 4, 4, 4)
    limit = 4.5 * np.sqrt(0.24 / lost[:, :, 0].size)
    assert np.abs(lost.mean(axis=(0, 1, 3)) - 0.4).max() < limit
    vessel = ~received[..., 0].reshape(-1, 4).T
    np.testing.assert_allclose(np.corrcoef(vessel), np.eye(4), atol=4.5 / np.sqrt(800))


def test_reports_come_as_far_as_boats_are_seen():
    """Thrusters and contacts of others are known by the last report, one's own at once."""
    sim = begun(16, task="push", sensors={"shared": False, "range": 0.25}, variation=FAILURE)
    own, stale = np.eye(4, dtype=bool), 0
    working = by_boat(sim.sensed.working)
    for _ in range(40):
        sim.step(np.full((16, 4, 2), (0.3, 0.0)))
        known, state = sim.sensed, sim.state
        heard = by_boat(known.received)[..., 1:] | own
        working = np.where(heard, state.working[:, None], working)
        assert same(by_boat(known.working), working)
        touching = state.touching[:, None] & heard[..., None]
        assert same(by_boat(known.touching), touching)
        stale += (working != state.working[:, None]).sum()
    assert stale
    assert not sim.state.working.all()


def test_boats_that_cannot_know_of_a_failure_keep_their_slots():
    options = {"sensors": {"shared": False, "range": 0.25}, "variation": FAILURE}
    sim = begun(8, task="push", **options)
    for _ in range(30):
        before = sim.sensed
        sim.step(np.zeros((8, 4, 2)))
        informed = (sim.sensed.working != before.working).any(axis=1)
        moved = (sim.sensed.slot != before.slot).any(axis=1)
        assert (moved <= informed).all()
    assert (by_boat(sim.sensed.slot) != sim.state.slot[:, None]).any()


def test_the_goal_becomes_final_by_the_view_of_the_first_boat_that_works():
    options = {"preset": "experiment", "sensors": {**NOISE, "shared": False}}
    sim = begun(2, variation={"failures": 1, "failure_time": (0.0, 0.0)}, **options)
    x, y, heading = sim.params.task.goal
    was = sim.state.anchored
    for _, _, known, state in driven(sim, 450):
        for world in np.flatnonzero(state.anchored & ~was):
            row = 4 * world + int(np.argmax(state.working[world]))
            vessel = known.estimate[row, 0]
            assert known.closed[row]
            point = vessel[0] + 1j * vessel[1] + (x + 1j * y) * np.exp(1j * vessel[2])
            np.testing.assert_allclose(state.goal[world][:2], [point.real, point.imag])
            assert wrap(state.goal[world][2] - vessel[2] - heading) == pytest.approx(0, abs=1e-12)
        assert same(known.goal, np.repeat(state.goal, 4, axis=0))
        assert same(known.anchored, np.repeat(state.anchored, 4))
        was = state.anchored
    assert was.any()


# ------------------------------------------------------------ observation


def test_each_boat_observes_its_own_row_and_the_unseen_is_told_as_unseen():
    spread = scalar(
        "spread", 1.0, 10.0, lambda view: np.ptp(view.sensed.measured[..., 0], axis=1)[:, None]
    )
    names = tuple(asv_env.FEATURES)
    sim = begun(6, observation=[*names, spread], **HARD)
    hidden = 0
    for tick, (_, step, known, _) in enumerate(driven(sim, 80)):
        everything = observe(sim._features, known, sim.params)
        assert same(step.observation, own_rows(everything)), tick
        seen, columns = by_boat(known.seen), step.observation
        assert same(columns[..., NAMES.index("vessel_seen")], seen[..., 0].astype(np.float32))
        present = [
            NAMES.index(f"neighbour_{k + 1}_present") for k in range(feature_table.NEIGHBOURS)
        ]
        others = seen[..., 1:].sum(axis=-1) - 1
        assert same(columns[..., present].sum(axis=-1), others.astype(np.float32))
        hidden += (~seen).sum()
    assert hidden
    chosen = sim.reset(np.array([False, True, False, True, False, False]))
    assert same(
        chosen, own_rows(observe(sim._features, rows(sim.sensed, np.r_[4:8, 12:16]), sim.params))
    )


@pytest.mark.parametrize("adapter", ["gym", "vec", "parallel", "sb3"])
def test_every_adapter_gives_what_each_boat_observes(adapter):
    options = HARD | {"time_limit": 20.0}
    sim = begun(1, **options)
    action = np.full((4, 2), (0.6, 0.2), dtype=np.float32)
    if adapter == "gym":
        import gymnasium

        env = gymnasium.make("asv_env/Transport-v0", **options)
        env.reset(seed=0)
        step = lambda: env.step(action)[0]  # noqa: E731
    elif adapter == "vec":
        import gymnasium

        env = gymnasium.make_vec("asv_env/Transport-v0", 1, **options)
        env.reset(seed=0)
        step = lambda: env.step(action[None])[0][0]  # noqa: E731
    elif adapter == "parallel":
        env = asv_env.parallel_env("transport", **options)
        env.reset(seed=0)
        step = lambda: np.stack(  # noqa: E731
            list(env.step(dict(zip(env.agents, action, strict=True)))[0].values())
        )
    else:
        env = asv_env.BoatVecEnv("transport", num_envs=1, **options)
        env.seed(0)
        env.reset()
        step = lambda: env.step(action)[0]  # noqa: E731
    for _ in range(60):
        assert same(np.array(step()), sim.step(action[None]).observation[0])


# ------------------------------------------------------------ distributed execution


@pytest.mark.parametrize("policy", ["scripted", "allocation", "paper-tuned", "learned"])
def test_a_team_does_what_each_boat_decides_alone(policy):
    """The first boat's row, given to a policy by itself, is enough for what the boat does."""
    sim = begun(2, "push" if policy == "learned" else "transport", **HARD)
    make = POLICIES[policy]
    team, alone = distributed(make(sim.params), sim.params), make(sim.params)
    memory, memories, fresh = None, [None] * 8, np.ones(2, dtype=bool)
    for _ in range(20):
        known, observed = sim.sensed, np.zeros(0)
        action, memory = team.act(copied(known), observed, memory, fresh)
        for row in range(8):
            view = rows(known, [row])
            seen = observe(sim._features, view, sim.params)
            did, memories[row] = alone.act(view, seen, memories[row], fresh[:1])
            assert same(action[row // 4, row % 4], did[0, row % 4])
        fresh = np.zeros(2, dtype=bool)
        sim.step(action)


def test_a_policy_that_shares_its_measurement_is_not_wrapped():
    params = make_params()
    policy = POLICIES["idle"](params)
    assert distributed(policy, params) is policy
    assert isinstance(distributed(policy, make_params(**OWN)), Distributed)


@pytest.mark.parametrize("wrong", [np.zeros((1, 4, 2)), np.full((4, 4, 2), np.nan), "no"])
def test_a_policy_that_decides_for_other_rows_fails_its_episode(wrong):
    class Wrong:
        def act(self, sensed, observation, memory, fresh):
            return wrong, memory

    sim = begun(1, **OWN)
    guard = Guard(lambda params: Wrong(), sim.params)
    tick = next(rollout(sim, guard.act, [0]))
    assert guard.errors[0]
    assert not tick.action.any()


@pytest.mark.parametrize("task", ["approach", "push", "transport"])
def test_the_scripted_team_runs_in_every_task_however_little_it_sees(task):
    blind = {**NOISE, "shared": False, "range": 0.15, "delay": 0.3, "dropout": 0.8}
    failing = {"failures": 1, "failure_time": (0.0, 10.0)}
    options = {"sensors": blind, "variation": failing, "time_limit": 10.0}
    for _, step, known, _ in driven(begun(2, task=task, **options), 120):
        assert np.isfinite(known.estimate).all()
        assert np.isfinite(step.observation).all()


def test_an_unfiltered_team_acts_on_measurements_alone():
    sim = begun(3, **HARD)
    for _ in range(5):
        sim.step(np.zeros((3, 4, 2)))
    known, policy = sim.sensed, unfiltered(sim.params)
    action, memory = decide(policy, known)
    other = replace(known, estimate=known.estimate + 0.1)
    assert same(action, decide(policy, other)[0])
    assert same(decide(policy, known, memory)[0], decide(policy, other, memory)[0])
    assert not same(action, decide(ScriptedPolicy(sim.params), other)[0])


def test_the_scripted_team_delivers_while_each_boat_sees_for_itself():
    own = {**NOISE, "shared": False, "range": 1.0}
    params = make_params("push", sensors=own, goal=(0.1, -0.4, 0.3), delivery="passing")
    assert successes(POLICIES["scripted"], params, 4, enough=3) == 3


# ------------------------------------------------------------ worlds, threads and copies


def test_a_world_is_known_the_same_in_every_batch():
    params = make_params("push", variation=FAILURE, time_limit=8.0, **HARD)
    many, alone = Simulation(params, 5), Simulation(params)
    many.reset(seeds=range(5))
    alone.reset(seeds=[3])
    for tick in range(100):
        action = np.random.default_rng(tick).uniform(-1, 1, (5, 4, 2))
        one, every = alone.step(action[3:4]), many.step(action)
        assert same(one.observation[0], every.observation[3])
        for field in fields(Sensed):
            there = getattr(many.sensed, field.name)[12:16]
            assert same(getattr(alone.sensed, field.name), there)
        if (over := every.ending.truncated | every.ending.terminated)[3]:
            assert same(alone.reset()[0], many.reset()[3])
        elif tick % 30 == 20 or over.any():
            over[[0, 4]] = True
            many.reset(over)


def test_threads_change_nothing():
    params = make_params("push", time_limit=4.0, **HARD)
    one, two = Simulation(params, 7, num_threads=1), Simulation(params, 7, num_threads=3)
    for sim in (one, two):
        sim.reset(seeds=range(7))
    assert same(play(one, 60), play(two, 60))


@pytest.mark.parametrize("options", [OWN, HARD], ids=["exact", "hard"])
def test_what_is_known_continues_in_copies_and_from_snapshots(options):
    sim = begun(3, task="push", time_limit=4.0, **options)
    play(sim, 25)
    snapshot, twin = sim.snapshot(), pickle.loads(pickle.dumps(sim))
    expected = play(sim, 60, seed=1)
    assert same(play(twin, 60, seed=1), expected)
    play(sim, 5, seed=2)
    sim.restore(snapshot)
    assert same(play(sim, 60, seed=1), expected)


def test_what_is_known_may_be_written_to():
    sim, twin = begun(2, **OWN), begun(2, **OWN)
    for _ in range(5):
        for array in vars(sim.sensed).values():
            array[...] = 0
        assert same(play(sim, 1), play(twin, 1))


# ------------------------------------------------------------ bad input


@pytest.mark.parametrize(
    ("sensors", "message"),
    [
        ({"shared": False, "range": 0.0}, "range = 0 m: .*above 0, or None"),
        ({"shared": False, "range": -1}, "range = -1 m: .*above 0, or None"),
        ({"shared": False, "range": "far"}, "range = 'far'"),
        ({"shared": False, "range": float("nan")}, "range = nan"),
        ({"range": 1.0}, "range = 1 m .*shared=False"),
        ({"shared": 1}, "shared = 1: must be True or False"),
        ({"shared": None}, "shared = None"),
        ({"delay": 0.25}, "delay = 0.25 s .*ticks of 0.1 s; give 0.2 or 0.3 s"),
        ({"delay": 0.04}, "give 0 or 0.1 s"),
        ({"delay": -0.1}, "delay = -0.1"),
        ({"delay": 11.0}, "delay = 11 s: at most 100 control ticks, 10 s"),
        ({"latency": 2}, "latency"),
    ],
)
def test_sensors_that_cannot_be_are_refused(sensors, message):
    with pytest.raises(ValueError, match=message):
        make_params(sensors=sensors)


def test_a_delay_of_actions_is_a_whole_number_of_ticks_too():
    with pytest.raises(ValueError, match=r"actuation_delay = 0.05 s .*give 0 or 0.1 s"):
        make_params(variation={"actuation_delay": 0.05})
    assert make_params(variation={"actuation_delay": 0.3}).clock.ticks(0.3) == 3


@pytest.mark.parametrize("scale", [1.0, 2.0, 4.0, 16.7])
def test_delay_and_range_grow_with_the_scale_and_delays_stay_whole_ticks(scale):
    scenario = {"sensors": {"shared": False, "range": 1.0, "delay": 0.2}}
    params = make_params(scenario=scenario, scale=scale)
    ticks = params.sensors.delay * params.clock.control
    assert ticks == pytest.approx(round(ticks))
    assert params.sensors.delay == pytest.approx(0.2 * scale**0.5, abs=0.5 / params.clock.control)
    assert params.sensors.range == pytest.approx(scale)
    assert params.rescaled(1 / scale).sensors.delay == pytest.approx(0.2, abs=0.05)
