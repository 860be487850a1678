"""Settings of all tests, and what several of their modules share."""

import os
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings

settings.register_profile("asv", deadline=None, derandomize=True, max_examples=50)
settings.load_profile("asv")
# Without bytecode, each of some hundred processes would take half a second to compile the sources.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False


@pytest.fixture(scope="session")
def report(tmp_path_factory):
    """The report on invented episodes; see ``invented.report``."""
    import invented  # needs the extra [eval]

    return invented.report(tmp_path_factory.mktemp("report"))


@pytest.fixture
def no_report(monkeypatch):
    """Drawing takes longer than a few episodes; ``test_report`` looks at reports."""
    monkeypatch.setattr("baselines.evaluate.report.document.write", lambda *arguments: [])


@pytest.fixture
def own_modules(monkeypatch):
    """Modules beside the tests can be imported, here and in workers."""
    monkeypatch.syspath_prepend(str(Path(__file__).parent))


@pytest.fixture(scope="session")
def policy_files(tmp_path_factory):
    """Policies in files, as they come from training, but untrained."""
    from helpers import SEEN
    from stable_baselines3 import PPO

    from asv_env.envs.sb3 import BoatVecEnv
    from baselines.learned import policy_file
    from baselines.learned.network import Metadata
    from baselines.learned.phases import Phase

    folder = tmp_path_factory.mktemp("policies")
    for seed in (0, 1):
        rng = np.random.default_rng(seed)
        layers = [(rng.normal(size=(n, m)), rng.normal(size=m)) for n, m in [(SEEN, 32), (32, 2)]]
        policy_file.save(folder / f"net{seed}.npz", [Phase(layers, Metadata(action_repeat=2))], {})
    PPO("MlpPolicy", BoatVecEnv("push", num_envs=1), device="cpu").save(folder / "model.zip")
    return folder


@pytest.fixture
def learned_files(tmp_path, monkeypatch):
    """Folder of untrained policies with model cards, which are the policy `learned` here."""
    from helpers import SEEN

    from baselines.learned import policy_file
    from baselines.learned.network import Metadata
    from baselines.learned.phases import Phase
    from baselines.rollout import seeds

    def invented(task, began_with=None):
        rng = np.random.default_rng(len(task))
        layers = [(rng.normal(size=(n, m)), np.zeros(m)) for n, m in [(SEEN, 16), (16, 2)]]
        card = {
            "options": {
                "task": task,
                "init_from": began_with and "best.npz",
                "worlds": {"scenarios": ["noisy", "nominal"], "teams": [4, 6]},
                "imitation": {"rounds": 3},
            },
            "timesteps": 2_500_000,
            "training_seeds": [seeds.TRAINING.start, seeds.TRAINING.start + 999_999],
            "development": [
                {"seconds": 660.0, "success": share, "median_time": 31.25} for share in (0.5, 1.0)
            ],
            "began_with": began_with,
        }
        return Phase(layers, Metadata(tasks=(task,), action_repeat=2)), card

    folder = tmp_path / "weights"
    folder.mkdir()
    approach, approach_card = invented("approach")
    push, push_card = invented("push", invented("push")[1])
    policy_file.save(folder / "approach.npz", [approach], approach_card)
    cards = {"phases": [approach_card, push_card]}
    policy_file.save(folder / "transport.npz", [approach, push], cards)
    monkeypatch.setattr(policy_file, "FOLDER", folder)
    return folder


@pytest.fixture(scope="session")
def trained(tmp_path_factory):
    """Folder of a tiny training that has come to its end; tests leave it as it is."""
    from train_helpers import train  # needs the extra [train]

    folder = tmp_path_factory.mktemp("train") / "run"
    train(folder)
    return folder


@pytest.fixture
def network_file(policy_files):
    return policy_files / "net0.npz"


@pytest.fixture
def other_network_file(policy_files):
    return policy_files / "net1.npz"


@pytest.fixture
def sb3_file(policy_files):
    return policy_files / "model.zip"
