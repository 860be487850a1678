"""The learned policies of the package, and the recipe that makes them."""

import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from asv_env import make_params
from asv_env.tasks import TASKS
from baselines.evaluate.policy_sources import find
from baselines.evaluate.publish import model_cards
from baselines.learned import policy_file, shipped
from baselines.rollout import runner, seeds
from baselines.scripted.scripted_policy import ScriptedPolicy
from train import recipe
from train.config import Config
from train.recipe import APPROACH, Training

FILES = sorted(shipped.FOLDER.glob("*.npz"))
PUSH = "second"
DEVELOPMENT = range(seeds.DEVELOPMENT.start, seeds.DEVELOPMENT.start + 12)
TINY = {
    "num_envs": 8, "num_steps": 16, "num_minibatches": 2, "update_epochs": 1, "hidden": (16,),
    "imitation_rounds": 0, "critic_updates": 0, "total_timesteps": 1024, "time_limit": 5.0,
    "checkpoint_every": 512, "eval_every": 512, "eval_episodes": 2, "scenarios": ("noisy",),
}  # fmt: skip


def episodes(policy, task):
    params = make_params(task, scenario="noisy")
    return [track.episode for track in runner.run(policy, params, DEVELOPMENT, len(DEVELOPMENT))]


@pytest.mark.parametrize("task", ["approach", "push", "transport"])
def test_it_does_its_task_faster_than_the_scripted_policy(task):
    """On development seeds; the suites' results are in docs/results."""
    ours, theirs = episodes(shipped.learned_policy, task), episodes(ScriptedPolicy, task)
    both = [(a.duration, b.duration) for a, b in zip(ours, theirs, strict=True) if a.success]
    assert len(both) >= 0.9 * len(ours)
    assert np.median([a - b for a, b in both]) < 0


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_files_are_small_and_say_where_they_come_from(file):
    assert file.stat().st_size < 1_000_000
    for network in model_cards.of_networks(file):
        for card in model_cards.trainings(network):
            first, last = card["training_seeds"]
            assert seeds.TRAINING.start <= first < last < seeds.TRAINING.stop
            assert card["timesteps"] > 0
            assert "/" not in str(card["options"]["init_from"])


def test_all_files_are_for_some_task():
    assert set(FILES) == set(map(shipped.file_for, TASKS.values()))


def test_it_runs_where_there_is_no_torch():
    """Neither torch nor anything else of the extra `train` is loaded."""
    code = """
import sys, tempfile

class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("torch", "stable_baselines3", "tensorboard"):
            raise ModuleNotFoundError(name)

sys.meta_path.insert(0, Missing())
from baselines import evaluate

with tempfile.TemporaryDirectory() as out:
    options = ["--policies", "learned", "--episodes", "2", "--workers", "0"]
    evaluate.main([*options, "--out", out + "/run"])
"""
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)


def test_what_is_kept_of_a_run_is_bound_to_the_files(monkeypatch, tmp_path):
    before = find("learned").fingerprint()
    for file in FILES:
        (tmp_path / file.name).write_bytes(file.read_bytes())
    monkeypatch.setattr(shipped, "FOLDER", tmp_path)
    assert find("learned").fingerprint() == before
    (tmp_path / FILES[0].name).write_bytes(b"other")
    assert find("learned").fingerprint() != before


# ---------------------------------------------------------------- the recipe


@pytest.fixture
def short(monkeypatch):
    """A recipe that is over in seconds."""
    approach, push = Config(task="approach", **TINY), Config(task="push", mirror=True, **TINY)
    steps = {
        APPROACH: Training(approach),
        "first": Training(push),
        PUSH: Training(replace(push, log_std_init=-2.0, hidden=(24,)), after="first"),
    }
    monkeypatch.setattr(recipe, "TRAININGS", steps)
    monkeypatch.setattr(recipe, "PAIRS", ((APPROACH, PUSH, None), (APPROACH, "first", 4)))


def test_the_recipe_leaves_policy_files(short, tmp_path):
    recipe.main(["--out", str(tmp_path / "r"), "--torch-threads", "1", "--seed", "2"])
    made, card = policy_file.read(tmp_path / "r/transport.npz")
    assert [phase.team_size for phase in made] == [None, None, 4, 4]
    for phase, name in zip(made, (APPROACH, PUSH, APPROACH, "first"), strict=True):
        own, own_card = policy_file.read_single(tmp_path / "r" / name / "best.npz")
        assert all(
            np.array_equal(a, b)
            for one, other in zip(phase.layers, own.layers, strict=True)
            for a, b in zip(one, other, strict=True)
        )
        assert phase.metadata == own.metadata
        assert own_card in card["phases"]
        assert own_card["training_seeds"][0] == seeds.TRAINING.start + 2_000_000
    began = [one["options"]["init_from"] for one in model_cards.trainings(card["phases"][1])]
    assert began == [None, "best.npz"]
    (own,) = policy_file.read(tmp_path / "r/approach.npz")[0]
    assert own.metadata.tasks == ("approach",)
    assert policy_file.load(tmp_path / "r/transport.npz", make_params("push"))


def test_the_recipe_goes_on_where_it_was_stopped(short, tmp_path):
    out = tmp_path / "r"
    recipe.follow(0, out, 1)
    stamps = {file: file.stat().st_mtime_ns for file in out.glob("*/checkpoint.zip")}
    (out / PUSH / "checkpoint.zip").unlink()
    recipe.follow(0, out, 1)
    changed = {
        file.parent.name for file, stamp in stamps.items() if file.stat().st_mtime_ns > stamp
    }
    assert changed == {PUSH}


def test_a_folder_of_another_recipe_is_refused(short, tmp_path, capsys):
    out = tmp_path / "r"
    recipe.follow(0, out, 1)
    with pytest.raises(SystemExit):
        recipe.main(["--out", str(out), "--seed", "1", "--torch-threads", "1"])
    assert "holds a run with other options (seed was 0 and is 1)" in capsys.readouterr().err


def test_the_recipe_begins_each_training_after_the_one_it_needs():
    names = list(recipe.TRAININGS)
    for name, training in recipe.TRAININGS.items():
        assert training.after is None or names.index(training.after) < names.index(name)
    joined = {name for approach, push, _ in recipe.PAIRS for name in (approach, push)}
    assert {APPROACH, *joined} <= set(names)
    assert json.dumps({name: one.config.learned() for name, one in recipe.TRAININGS.items()})
