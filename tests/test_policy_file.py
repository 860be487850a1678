"""Policy files: what comes back from them, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from helpers import SEEN

from asv_env import Simulation, make_params
from asv_env.tasks import APPROACH, PUSH, TRANSPORT
from baselines.learned import policy_file
from baselines.learned.network import Metadata, NetworkPolicy
from baselines.learned.team_policy import TeamPolicy

LAYERS = [(np.zeros((SEEN, 2)), np.zeros(2))]


@pytest.mark.parametrize(
    "metadata",
    [
        Metadata(tasks=("approach",), action_repeat=2),
        Metadata(activation="relu", residual=0.5, observation=("slot",)),
    ],
)
def test_a_file_gives_back_what_was_written(metadata, tmp_path):
    rng, file = np.random.default_rng(0), tmp_path / "mine.npz"
    written = [
        (rng.normal(size=(n, m)).astype(np.float32), np.ones(m, np.float32))
        for n, m in [(SEEN, 3), (3, 2)]
    ]
    policy_file.save(file, written, metadata, {"steps": 3})
    layers, *rest = policy_file.read(file)
    assert rest == [metadata, {"steps": 3}]
    for before, after in zip(written, layers, strict=True):
        for one, other in zip(before, after, strict=True):
            assert one.tobytes() == other.tobytes()


def test_either_format_is_loaded(network_file, learned_file):
    for file, kind in ((network_file, NetworkPolicy), (learned_file, TeamPolicy)):
        assert isinstance(policy_file.load(file, make_params("push")), kind)
    with pytest.raises(ValueError, match="its format is 'asv-env team policy"):
        policy_file.read(learned_file)
    with pytest.raises(ValueError, match=r"learned\.npz: the policy gives 'tracking' actions"):
        policy_file.load(learned_file, make_params("push", action_mode="thrusters"))


@pytest.mark.parametrize(
    ("layers", "metadata", "message"),
    [
        ([], {}, r"layers of shapes \[\] do not fit"),
        (LAYERS, {"action_mode": "thrusters"}, "gives 'thrusters' actions"),
        (LAYERS, {"observation_version": 0}, "observes by version 0"),
        ([(np.zeros((46, 2)), np.zeros(2))], {}, "must map an observ"),
        ([(np.full((SEEN, 2), np.nan), np.zeros(2))], {}, "not finite"),
    ],
)
def test_policies_that_do_not_fit_are_refused(tmp_path, layers, metadata, message):
    policy_file.save(tmp_path / "bad.npz", layers, Metadata(**metadata), {})
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


def test_a_network_observes_the_features_that_it_needs():
    names, rng = ("goal", "slot", "closure"), np.random.default_rng(0)
    layers, metadata = [(rng.normal(size=(5, 2)), np.zeros(2))], Metadata(observation=names)
    actions = []
    for shown in (names, None, ("slot", "own_velocity")):
        params = make_params("push", observation=shown)
        policy = NetworkPolicy(layers, metadata, params)
        simulation, fresh = Simulation(params, 3), np.ones(3, dtype=bool)
        observed = simulation.reset(seeds=range(3))
        actions.append(policy.act(simulation.sensed, observed, None, fresh)[0])
    assert np.array_equal(actions[0], actions[1])
    assert np.array_equal(actions[0], actions[2])


def test_the_learned_policy_runs_where_boats_observe_something_else(learned_file):
    actions = []
    for shown in (None, ("slot",)):
        params = make_params("transport", observation=shown)
        policy, simulation = policy_file.learned_policy(params), Simulation(params, 2)
        observed, fresh = simulation.reset(seeds=range(2)), np.ones(2, dtype=bool)
        actions.append(policy.act(simulation.sensed, observed, None, fresh)[0])
    assert np.array_equal(*actions)


def test_an_unknown_feature_is_refused(tmp_path):
    policy_file.save(tmp_path / "bad.npz", LAYERS, Metadata(observation=("gaol",)), {})
    with pytest.raises(ValueError, match=r"bad\.npz.*gaol.*goal"):
        policy_file.load(tmp_path / "bad.npz", make_params("push"))


@pytest.mark.parametrize("task", [APPROACH, PUSH, TRANSPORT], ids=lambda task: task.name)
def test_tasks_of_the_same_kind_are_served(task, learned_file):
    mine = make_params(replace(task, name="mine"))
    assert policy_file.learned_policy(mine)
    NetworkPolicy(LAYERS, Metadata(tasks=("mine",)), mine)
    NetworkPolicy(LAYERS, Metadata(tasks=(task.name,)), mine)
    others = tuple(other.name for other in (APPROACH, PUSH, TRANSPORT) if other is not task)
    with pytest.raises(ValueError, match="not for 'mine'"):
        NetworkPolicy(LAYERS, Metadata(tasks=others), mine)
