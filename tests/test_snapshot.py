"""Copies, pickles and snapshots of a simulation continue to the bit as the original does."""

import copy
import hashlib
import pickle
import subprocess
import sys

import numpy as np
import pytest
from helpers import same
from hypothesis import given, settings
from hypothesis import strategies as st

from asv_env import FEATURES, Simulation, make_params
from asv_env.sensing.observation import scalar
from asv_env.tasks import starts

STEPS = 250  #: control ticks, with an end of all worlds' episodes
CALLS = ("reset", "one", "step", "copy", "pickle", "snapshot", "restore")
WALLED = {"water": {"walls": 2.0}}
CASES = [
    ("push", "harsh", 1, 1, {}),
    ("push", "failure", 5, 2, WALLED),
    ("transport", "harsh", 3, 3, WALLED),
    ("approach", "noisy", 2, 2, {}),
    ("push", "nominal", 2, 1, {"action_mode": "thrusters"}),
    ("push", "noisy", 2, 2, {"preset": "experiment"}),
]


def made(task, scenario, worlds, num_threads, options):
    return Simulation(
        make_params(task, scenario=scenario, time_limit=20.0, **options), worlds, num_threads
    )


def begun(case, ticks=137):
    """A simulation in the middle of its first episodes, boats in contact with the vessel."""
    simulation = made(*case)
    simulation.reset(seeds=range(simulation.num_worlds))
    play(simulation, ticks, seed=7)
    return simulation


def play(simulation, ticks, seed=0):
    """All that comes of random actions; worlds that end begin their next episode."""
    rng, seen = np.random.default_rng(seed), []
    shape = simulation.state.thrust.shape
    for _ in range(ticks):
        step = simulation.step(rng.uniform(-0.3, 1.0, shape))
        over = step.ending.terminated | step.ending.truncated
        seen.append(step.observation.tobytes() + step.reward.tobytes() + over.tobytes())
        seen.append(simulation.state.motion.tobytes() + simulation.sensed.measured.tobytes())
        if over.any():
            seen.append(simulation.reset(over).tobytes())
    metrics = simulation.summary()
    return [*seen, *(metrics[name].tobytes() for name in metrics)]


@pytest.mark.parametrize("case", CASES, ids=str)
def test_copies_and_pickles_continue_like_the_original(case):
    original = begun(case)
    copies = [copy.deepcopy(original), pickle.loads(pickle.dumps(original)), copy.copy(original)]
    expected = play(original, STEPS)
    for each in copies:
        assert play(each, STEPS) == expected


@pytest.mark.parametrize("case", CASES, ids=str)
def test_a_snapshot_is_restored_as_often_as_one_likes(case):
    simulation = begun(case)
    snapshot = simulation.snapshot()
    expected = play(simulation, 60)
    play(simulation, 40, seed=3)
    for _ in range(2):
        simulation.restore(snapshot)
        assert play(simulation, 60) == expected
    another = made(*case)
    another.restore(snapshot)
    assert play(another, 60) == expected


def test_to_take_a_snapshot_changes_nothing():
    plain, watched = begun(CASES[0]), begun(CASES[0])
    for seed in range(20):
        watched.snapshot()
        copy.deepcopy(watched)
        assert play(watched, 3, seed) == play(plain, 3, seed)


def test_a_pickle_continues_in_another_process(tmp_path):
    simulation = begun(CASES[1])
    (tmp_path / "it").write_bytes(pickle.dumps(simulation))
    program = (
        "import sys, pickle, hashlib; from test_snapshot import play\n"
        "simulation = pickle.load(open(sys.argv[1], 'rb'))\n"
        "print(hashlib.sha256(b''.join(play(simulation, 100))).hexdigest())"
    )
    expected = hashlib.sha256(b"".join(play(simulation, 100))).hexdigest()
    command = [sys.executable, "-c", program, str(tmp_path / "it")]
    found = subprocess.run(command, capture_output=True, text=True, cwd="tests", check=True)
    assert found.stdout.strip() == expected


@settings(max_examples=25, deadline=None)
@given(
    calls=st.lists(
        st.sampled_from(["reset", "one", "step", "copy", "pickle", "snapshot", "restore"]),
        max_size=14,
    )
)
def test_any_order_of_calls_gives_what_it_gives_without_copies(calls):
    """``restore`` goes back to the latest snapshot, which the plain twin plays again."""
    params = make_params("push", scenario="harsh", time_limit=2.0)
    simulation = Simulation(params, 2)
    simulation.reset(seeds=[1, 2])
    done, saved, snapshot = [], [], simulation.snapshot()
    for call in calls:
        if call == "copy":
            simulation = copy.deepcopy(simulation)
        elif call == "pickle":
            simulation = pickle.loads(pickle.dumps(simulation))
        elif call == "snapshot":
            snapshot, saved = simulation.snapshot(), done[:]
        elif call == "restore":
            simulation.restore(snapshot)
            done = saved[:]
        else:
            do(simulation, call)
            done.append(call)
    twin = Simulation(params, 2)
    twin.reset(seeds=[1, 2])
    for call in done:
        do(twin, call)
    assert play(simulation, 5) == play(twin, 5)


def do(simulation, call):
    if call == "reset":
        simulation.reset()
    elif call == "one":
        simulation.reset(np.array([True, False]))
    else:
        play(simulation, 7)


@pytest.mark.parametrize(
    ("other", "names"),
    [
        (lambda p: Simulation(p, 3), "num_worlds = 3"),
        (lambda p: Simulation(make_params("push", 5), 2), "params"),
    ],
)
def test_a_snapshot_of_other_worlds_is_refused(other, names):
    params = make_params("push")
    simulation = Simulation(params, 2)
    before = simulation.reset(seeds=[0, 1])
    with pytest.raises(ValueError, match=names):
        simulation.restore(other(params).snapshot())
    np.testing.assert_array_equal(simulation.reset(seeds=[0, 1]), before)


def test_what_is_no_snapshot_is_refused():
    with pytest.raises(TypeError, match="Snapshot"):
        Simulation(make_params("push")).restore(b"")


def test_copies_before_the_first_reset_begin_alike():
    simulation = Simulation(make_params(scenario="noisy"), 2)
    twin = copy.deepcopy(simulation)
    for each in (simulation, twin):
        each.reset(seeds=[3, 4])
    assert play(simulation, 20) == play(twin, 20)


def in_contact(params, rng, goal):
    start = starts.in_slots(params, rng, goal)
    start.motion[1:, 1] -= start.side * 0.0016
    return start


def test_an_episode_that_begins_in_contact_does_not_depend_on_the_one_before():
    simulation = Simulation(make_params("push", time_limit=20.0), 2, initial_states=in_contact)
    first, again = [(simulation.reset(seeds=[0, 1]), play(simulation, 20)) for _ in range(2)]
    assert same(first, again)
    simulation.reset(seeds=[0, 1])
    twin = copy.deepcopy(simulation)
    assert same(play(simulation, 20), first[1])
    assert same(play(twin, 20), first[1])


def spin(view):
    return view.relations.yaw_rate[:, 1:]


@pytest.mark.parametrize("protocol", range(pickle.HIGHEST_PROTOCOL + 1))
def test_simulations_with_features_as_objects_can_be_pickled(protocol):
    own = scalar("spin", 1.0, 1.0, spin)
    simulation = Simulation(make_params("push", observation=["goal", FEATURES["slot"], own]))
    simulation.reset(seeds=[0])
    twin = pickle.loads(pickle.dumps(simulation, protocol))
    assert twin.params == simulation.params
    assert hash(twin.params) == hash(simulation.params)
    simulation.restore(twin.snapshot())
    assert play(simulation, 5) == play(twin, 5)


def test_features_are_equal_where_their_content_is():
    assert scalar("spin", 1.0, 1.0, spin) == scalar("spin", 1.0, 1.0, spin)
    assert scalar("spin", 1.0, 1.0, spin) != scalar("spin", 2.0, 1.0, spin)
