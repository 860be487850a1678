"""A task, a scenario and a feature from a file of one's own are trained like the built-in ones."""

import importlib
import sys

import numpy as np
import pytest
from train_helpers import refusal, train

from asv_env import Simulation, make_params
from baselines.learned import policy_file
from train.config import preset
from train.sb3 import export

OWN = """
from dataclasses import replace
from asv_env.sensing.observation import Feature
from asv_env.tasks import APPROACH, PUSH

SHORT = replace(PUSH, name="short-push", time_limit=8.0)
NEAR = replace(APPROACH, name="near")
MURKY = {"sensors": {"position_noise": 0.03}}
FIRST = Feature("first", lambda view: view.sensed.estimate[:, 1:, 0], scale=(1.0,), bound=(9.0,))
"""
OPTIONS = ("--task", "own_task:SHORT", "--scenarios", "own_task:MURKY")
OPTIONS += ("--observation", "slot", "goal", "own_task:FIRST", "--total-timesteps", "512")


@pytest.fixture
def own(tmp_path, monkeypatch):
    """The module ``own_task``, beside which commands run."""
    (tmp_path / "own_task.py").write_text(OWN)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "own_task", raising=False)
    return importlib.import_module("own_task")


def test_it_is_trained_evaluated_and_exported(own, tmp_path):
    train(tmp_path / "run", *OPTIONS)
    _, metadata, card = policy_file.read(tmp_path / "run/best.npz")
    assert metadata.tasks == ("short-push",)
    assert metadata.observation == ("slot", "goal", "own_task:FIRST")
    assert card["options"]["task"] == "own_task:SHORT"
    params = make_params(own.SHORT)  # which observes all: the policy takes what it needs
    policy, simulation = policy_file.load(tmp_path / "run/best.npz", params), Simulation(params, 2)
    action, _ = policy.act(
        simulation.sensed, simulation.reset(seeds=[1, 2]), None, np.ones(2, dtype=bool)
    )
    assert action.shape == (2, 4, 2)
    export.main([str(tmp_path / "run"), str(tmp_path / "mine.npz")])
    train(tmp_path / "run", *OPTIONS)  # is over
    assert "task was 'own_task:SHORT'" in refusal("--out", tmp_path / "run")


def test_it_has_the_preset_of_its_kind(own):
    assert preset("own_task:SHORT") == preset("push").changed(task="own_task:SHORT")
    assert preset("own_task:NEAR") == preset("approach").changed(task="own_task:NEAR")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--task", "own_task:SHORTER"), "no attribute 'SHORTER'"),
        (("--task", "own_task:MURKY"), "give the name of a task"),
        (("--task", "nowhere:TASK"), "nowhere"),
        (("--observation", "slott"), "Did you mean 'slot'"),
    ],
)
def test_what_is_not_there_is_refused(options, message, own):
    assert message in refusal(*options)
