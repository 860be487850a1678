"""Policy files: what comes back from them, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from helpers import SEEN

from asv_env import Simulation, make_params
from asv_env.tasks import APPROACH, PUSH, TRANSPORT
from baselines.learned import policy_file
from baselines.learned.network import Metadata, NetworkPolicy
from baselines.learned.phases import Phase, PhasedPolicy

LAYERS = [(np.zeros((SEEN, 2)), np.zeros(2))]


def zeros(team_size=None, **metadata):
    return Phase(LAYERS, Metadata(**metadata), team_size=team_size)


def test_a_file_gives_back_what_was_written(tmp_path):
    rng, file = np.random.default_rng(0), tmp_path / "three.npz"
    written = [
        Phase([(rng.normal(size=(SEEN, 2)).astype(np.float32), np.ones(2, np.float32))], *rest)
        for rest in (
            (Metadata(tasks=("approach",)), 9.0),
            (Metadata(action_repeat=2, mirrors=True), None, None),
            (Metadata(activation="relu", residual=0.5), 3.0, 7),
        )
    ]
    policy_file.save(file, written, {"steps": 3})
    read, model_card = policy_file.read(file)
    assert model_card == {"steps": 3}
    for before, after in zip(written, read, strict=True):
        for one, other in zip(before.layers[0], after.layers[0], strict=True):
            assert one.tobytes() == other.tobytes()
        assert (before.metadata, before.patience) == (after.metadata, after.patience)
        assert before.team_size == after.team_size
    with pytest.raises(ValueError, match=r"three\.npz holds 3 networks"):
        policy_file.read_single(file)


def test_one_network_is_a_policy_and_several_are_one(tmp_path):
    file = tmp_path / "mine.npz"
    for phases, kind in (([zeros()], NetworkPolicy), ([zeros(), zeros()], PhasedPolicy)):
        policy_file.save(file, phases, {})
        assert isinstance(policy_file.load(file, make_params("push")), kind)


@pytest.mark.parametrize(
    ("phases", "message"),
    [
        ([], "0 networks for a team of 4: there must be two"),
        ([zeros(team_size=6), zeros(team_size=6)], "0 networks for a team of 4"),
        ([zeros(), zeros(action_mode="thrusters")], "gives 'thrusters' actions"),
        ([zeros(), zeros(observation_version=0)], "observes by version 0"),
        ([zeros(), Phase([(np.zeros((46, 2)), np.zeros(2))], Metadata())], "must map an observ"),
        ([Phase([(np.full((SEEN, 2), np.nan), np.zeros(2))], Metadata())], "not finite"),
    ],
)
def test_policies_that_do_not_fit_are_refused(tmp_path, phases, message):
    policy_file.save(tmp_path / "bad.npz", phases, {})
    with pytest.raises(ValueError, match=rf"bad\.npz.*{message}"):
        policy_file.load(tmp_path / "bad.npz", make_params("push"))


def test_files_of_another_format_are_refused(tmp_path):
    np.savez(tmp_path / "old.npz", policy=np.array('{"format": "asv-env policy 1"}'))
    with pytest.raises(ValueError, match="its format is 'asv-env policy 1'"):
        policy_file.read(tmp_path / "old.npz")


def test_nothing_is_unpickled(tmp_path):
    np.savez(tmp_path / "code.npz", policy=np.array([print], dtype=object))
    with pytest.raises(ValueError, match="not a policy file"):
        policy_file.read(tmp_path / "code.npz")


# ---------------------------------------------------------------- observation and tasks


@pytest.mark.parametrize("mirrors", [False, True])
def test_a_network_observes_the_features_that_it_needs(mirrors):
    names, rng = ("goal", "slot", "closure"), np.random.default_rng(0)
    layers, metadata = [(rng.normal(size=(5, 2)), np.zeros(2))], Metadata(observation=names)
    actions = []
    for shown in (names, None, ("slot", "own_velocity")):
        params = make_params("push", observation=shown)
        policy = NetworkPolicy(layers, replace(metadata, mirrors=mirrors), params)
        simulation, fresh = Simulation(params, 3), np.ones(3, dtype=bool)
        observed = simulation.reset(seeds=range(3))
        actions.append(policy.act(simulation.sensed, observed, None, fresh)[0])
    assert np.array_equal(actions[0], actions[1])
    assert np.array_equal(actions[0], actions[2])


def test_learned_policies_run_where_boats_observe_something_else(learned_files):
    actions = []
    for shown in (None, ("slot",)):
        params = make_params("transport", observation=shown)
        policy, simulation = policy_file.learned_policy(params), Simulation(params, 2)
        observed, fresh = simulation.reset(seeds=range(2)), np.ones(2, dtype=bool)
        actions.append(policy.act(simulation.sensed, observed, None, fresh)[0])
    assert np.array_equal(*actions)


def test_an_unknown_feature_is_refused(tmp_path):
    policy_file.save(tmp_path / "bad.npz", [zeros(observation=("gaol",))], {})
    with pytest.raises(ValueError, match=r"bad\.npz.*gaol.*goal"):
        policy_file.load(tmp_path / "bad.npz", make_params("push"))


@pytest.mark.parametrize("task", [APPROACH, PUSH, TRANSPORT], ids=lambda task: task.name)
def test_tasks_of_the_same_kind_are_served(task, learned_files):
    mine = make_params(replace(task, name="mine"))
    assert policy_file.learned_policy(mine)
    NetworkPolicy(LAYERS, Metadata(tasks=("mine",)), mine)
    NetworkPolicy(LAYERS, Metadata(tasks=(task.name,)), mine)
    others = tuple(other.name for other in (APPROACH, PUSH, TRANSPORT) if other is not task)
    with pytest.raises(ValueError, match="not for 'mine'"):
        NetworkPolicy(LAYERS, Metadata(tasks=others), mine)
