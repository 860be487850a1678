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

    folder = tmp_path_factory.mktemp("policies")
    for seed in (0, 1):
        rng = np.random.default_rng(seed)
        layers = [(rng.normal(size=(n, m)), rng.normal(size=m)) for n, m in [(SEEN, 32), (32, 2)]]
        policy_file.save(folder / f"net{seed}.npz", layers, Metadata(action_repeat=2), {})
    PPO("MlpPolicy", BoatVecEnv("push", num_envs=1), device="cpu").save(folder / "model.zip")
    return folder


@pytest.fixture
def learned_file(tmp_path, monkeypatch):
    """File of an untrained policy with a model card, which is the policy `learned` here."""
    from baselines.learned import policy_file, set_network, team_policy

    rng, weights = np.random.default_rng(0), {}
    for name, sizes in set_network.layers().items():
        weights[f"{name}.weight"] = rng.normal(size=sizes) / np.sqrt(sizes[0])
        weights[f"{name}.bias"] = np.zeros(sizes[1])
    score = {"num_boats": 4, "vessel": "plank", "episodes": 50, "median_time": 31.25}
    nothing = {"success": 0.0, "median_time": float("nan"), "position_error": float("nan")}
    software = {"libraries": {"torch": "2.1"}, "python": "3.12", "machine": "abacus"}
    card = {
        "command": "python -m train.recipe --seed 3",
        "options": {
            "teams": [4, 4, 12, 6],
            "scenarios": ["noisy", "gyre", "noisy"],
            "hulls": ["plank", "L"],
            "tasks": ["transport", "push", "transport"],
            "rounds": 9,
        },
        "rounds": 7,
        "decisions": 2_500_000,
        "training_seeds": [1_003_000_000, 1_003_999_999],
        "seconds": 6_000.0,
        "software": [
            {"revision": "a1", "code": "b2", **software},
            {"revision": None, "code": "c3", **software},
        ],
        "development": [
            score
            | {"task": "transport", "scenario": "noisy", "success": 0.5}
            | {"position_error": 0.021, "heading_error": 0.0625},
            score | {"task": "push", "scenario": "gyre", "heading_error": float("nan")} | nothing,
        ],
    }
    file = tmp_path / "learned.npz"
    team_policy.save(file, weights, card)
    monkeypatch.setattr(policy_file, "LEARNED", file)
    return file


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
