"""The learned policies of the package."""

import subprocess
import sys

import numpy as np
import pytest

from asv_env import make_params
from asv_env.tasks import TASKS
from baselines.evaluate.policy_sources import find
from baselines.evaluate.publish import model_cards
from baselines.learned import policy_file
from baselines.rollout import runner, seeds
from baselines.scripted.scripted_policy import ScriptedPolicy

FILES = sorted(policy_file.FOLDER.glob("*.npz"))
DEVELOPMENT = range(seeds.DEVELOPMENT.start, seeds.DEVELOPMENT.start + 12)


def episodes(policy, task):
    params = make_params(task, scenario="noisy")
    return [track.episode for track in runner.run(policy, params, DEVELOPMENT, len(DEVELOPMENT))]


@pytest.mark.parametrize("task", ["approach", "push", "transport"])
def test_it_does_its_task_faster_than_the_scripted_policy(task):
    """On development seeds; the suites' results are in docs/results."""
    ours, theirs = episodes(policy_file.learned_policy, task), episodes(ScriptedPolicy, task)
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
    assert set(FILES) == set(map(policy_file.file_for, TASKS.values()))


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
    monkeypatch.setattr(policy_file, "FOLDER", tmp_path)
    assert find("learned").fingerprint() == before
    (tmp_path / FILES[0].name).write_bytes(b"other")
    assert find("learned").fingerprint() != before
