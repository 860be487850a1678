"""Imitation: recorded episodes, and a learner that comes near to its expert."""

import pytest
import torch
from train_helpers import refusal, tiny

from asv_env import make_params
from baselines.rollout import runner, trajectories
from baselines.scripted.scripted_policy import ScriptedPolicy
from train import imitation
from train.launch import open_run


@pytest.fixture(scope="module")
def demonstrations(tmp_path_factory):
    out = tmp_path_factory.mktemp("recorded")
    params = make_params("push", time_limit=5.0)
    for seed in (10**9, 5):
        (log,) = runner.run(ScriptedPolicy, params, [seed], 1, record=True)
        trajectories.save(out / str(seed), log, params)
    return out


def test_recorded_episodes_are_imitated(demonstrations, tmp_path):
    folder = demonstrations / str(10**9)
    open_run(tiny(imitation={"demonstrations": folder}, out=tmp_path / "run"))
    ((seen, done),) = imitation.demonstrations(folder)
    trajectory, _ = trajectories.load(next(folder.rglob("*.npz")))
    assert len(seen) == len(done) == 4 * len(trajectory.action)


def test_episodes_of_the_tests_are_not_learned_from(demonstrations, tmp_path):
    options = ("--imitation.demonstrations", demonstrations / "5", "--out", tmp_path / "run")
    assert "seed 5 is for test, not for training" in refusal(*options)
    assert not (tmp_path / "run").exists()


def test_episodes_of_another_task_are_not_learned_from(demonstrations):
    options = ("--imitation.demonstrations", demonstrations / str(10**9), "--task", "transport")
    assert "its task is 'push'" in refusal(*options)


def test_imitation_comes_near_to_an_expert_that_acts_on_what_is_observed(monkeypatch):
    monkeypatch.setattr(imitation, "BATCH", 256)
    torch.manual_seed(0)
    seen = torch.randn(4000, 5)
    wanted = torch.tanh(seen[:, :2])
    actor = torch.nn.Sequential(torch.nn.Linear(5, 64), torch.nn.ReLU(), torch.nn.Linear(64, 2))
    optimizer = torch.optim.Adam(actor.parameters(), 1e-2)
    shuffle = torch.Generator().manual_seed(0)
    before = imitation.fit(actor, optimizer, seen, wanted, 1, shuffle)
    assert imitation.fit(actor, optimizer, seen, wanted, 200, shuffle) < before / 10
