"""The policy `learned`: the files of the package, where it has any, and what it says without."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from asv_env import make_params
from asv_env.tasks import TASKS
from baselines import evaluate
from baselines.evaluate import compare
from baselines.evaluate.policy_sources import find
from baselines.evaluate.publish import model_cards, pages
from baselines.learned import policy_file
from baselines.rollout import seeds

SHIPPED = policy_file.FOLDER
ROOT = Path(__file__).parents[1]


def check_files(folder):
    """Files are small, are for some task, and say where they come from."""
    files = sorted(folder.glob("*.npz"))
    assert set(files) <= set(map(policy_file.file_for, TASKS.values()))
    for file in files:
        assert file.stat().st_size < 1_000_000
        for network in model_cards.of_networks(file):
            for card in model_cards.trainings(network):
                first, last = card["training_seeds"]
                assert seeds.TRAINING.start <= first < last < seeds.TRAINING.stop
                assert card["timesteps"] > 0 or card["options"]["imitation"]["rounds"] > 0
                assert "/" not in str(card["options"]["init_from"])


def test_the_files_of_the_package_are_sound():
    check_files(SHIPPED)


def test_unsound_files_are_noticed(learned_files):
    check_files(learned_files)
    shutil.copy(learned_files / "approach.npz", learned_files / "other.npz")
    with pytest.raises(AssertionError):
        check_files(learned_files)


@pytest.mark.parametrize("task", TASKS)
def test_it_is_found_where_its_files_are(task, learned_files):
    params = make_params(task, time_limit=1.0)
    found = compare({"learned": "learned"}, suite=params, episodes=2, workers=0, progress=False)
    assert found.episodes["error"].isna().all()


@pytest.mark.parametrize("task", TASKS)
def test_without_files_it_says_how_to_train_them(task, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(policy_file, "FOLDER", tmp_path)
    with pytest.raises(FileNotFoundError, match=r"python -m train --task approach`.*`--task push`"):
        policy_file.learned_policy(make_params(task))
    options = ["--task", task, "--policies", "learned", "--episodes", "1", "--workers", "0"]
    with pytest.raises(SystemExit):
        evaluate.main([*options, "--out", str(tmp_path / "run")])
    message = capsys.readouterr().err
    assert "`python -m train --task approach`, `--task push`" in message
    assert "give its file, such as runs/train/push-sb3-0/best.npz" in message
    assert not (tmp_path / "run/episodes.csv").exists()


def test_it_runs_where_there_is_no_torch(learned_files):
    """Neither torch nor anything else of the extra `train` is loaded."""
    code = """
import sys
from pathlib import Path

class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("torch", "stable_baselines3", "tensorboard"):
            raise ModuleNotFoundError(name)

sys.meta_path.insert(0, Missing())
from asv_env import make_params
from baselines.evaluate import compare
from baselines.learned import policy_file

policy_file.FOLDER = Path(sys.argv[1])
found = compare({"learned": "learned"}, make_params(time_limit=1.0), episodes=2, workers=0)
assert found.episodes["error"].isna().all()
"""
    subprocess.run([sys.executable, "-c", code, learned_files], check=True, capture_output=True)


def test_what_is_kept_of_a_run_is_bound_to_the_files(learned_files):
    before = find("learned").fingerprint()
    assert find("learned").fingerprint() == before
    (learned_files / "approach.npz").write_bytes(b"other")
    assert find("learned").fingerprint() != before


# ---------------------------------------------------------------- model cards


def test_the_page_of_model_cards_lists_every_training_of_every_network(learned_files):
    page = model_cards.page(learned_files)
    size = (learned_files / "approach.npz").stat().st_size
    assert f"## approach.npz\n\nFor Approach; {size:,} bytes." in page
    assert "For Push and Transport;" in page
    trained = "noisy, nominal | 4, 6 | 2.5 M | 11 | 1,000,000,000 to 1,000,999,999 | 50.0%, 100.0%"
    assert page.count(f"| approach | imitation of `scripted` | {trained} | 31.2, 31.2 |") == 2
    assert f"| push | imitation of `scripted` | {trained}" in page
    assert f"| push | the one above | {trained}" in page


def test_the_page_of_model_cards_says_where_there_are_none(learned_files):
    for file in learned_files.iterdir():
        file.unlink()
    page = model_cards.page(learned_files)
    assert "holds none yet" in page
    assert "|" not in page


def test_a_model_card_that_lacks_something_is_named(learned_files, monkeypatch):
    file = learned_files / "approach.npz"
    phases, card = policy_file.read(file)
    del card["development"]
    policy_file.save(file, phases, card)
    monkeypatch.chdir(ROOT)
    with pytest.raises(SystemExit, match=r"weights: a model card lacks 'development', train"):
        pages.main(["--check"])
