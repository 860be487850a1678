"""The policy `learned`: the file of the package, where it has one, and what it says without."""

import subprocess
import sys
from pathlib import Path

import pytest

from asv_env import make_params
from asv_env.tasks import TASKS
from baselines import evaluate
from baselines.evaluate import compare
from baselines.evaluate.policy_sources import find
from baselines.evaluate.publish import model_card, pages
from baselines.learned import policy_file, team_policy
from baselines.rollout import seeds

SHIPPED = policy_file.LEARNED
ROOT = Path(__file__).parents[1]


def test_the_file_of_the_package_is_sound():
    """It is small, fits every task, and says where it comes from."""
    if not SHIPPED.exists():
        return
    assert SHIPPED.stat().st_size < 1_000_000
    _, card = team_policy.read(SHIPPED)
    first, last = card["training_seeds"]
    assert seeds.TRAINING.start <= first < last < seeds.TRAINING.stop
    assert card["decisions"] > 0
    assert "/" not in card["command"]
    for task in TASKS:
        assert policy_file.learned_policy(make_params(task))


@pytest.mark.parametrize("task", TASKS)
def test_it_is_found_where_its_file_is(task, learned_file):
    params = make_params(task, time_limit=1.0)
    found = compare({"learned": "learned"}, suite=params, episodes=2, workers=0, progress=False)
    assert found.episodes["error"].isna().all()


def test_without_a_file_it_says_how_to_train_one(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(policy_file, "LEARNED", tmp_path / "learned.npz")
    with pytest.raises(FileNotFoundError, match=r"no learned\.npz yet: .*python -m train\.recipe"):
        policy_file.learned_policy(make_params())
    options = ["--policies", "learned", "--episodes", "1", "--workers", "0"]
    with pytest.raises(SystemExit):
        evaluate.main([*options, "--out", str(tmp_path / "run")])
    message = capsys.readouterr().err
    assert "give its file, such as runs/train/recipe-0/policy.npz" in message
    assert not (tmp_path / "run/episodes.csv").exists()


def test_it_runs_where_there_is_no_torch(learned_file):
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

policy_file.LEARNED = Path(sys.argv[1])
found = compare({"learned": "learned"}, make_params(time_limit=1.0), episodes=2, workers=0)
assert found.episodes["error"].isna().all()
"""
    subprocess.run([sys.executable, "-c", code, learned_file], check=True, capture_output=True)


def test_what_is_kept_of_a_run_is_bound_to_the_file(learned_file):
    before = find("learned").fingerprint()
    assert find("learned").fingerprint() == before
    learned_file.write_bytes(b"other")
    assert find("learned").fingerprint() != before


# ---------------------------------------------------------------- model card


def test_the_page_of_the_model_card_says_how_it_was_trained_and_what_it_reached(learned_file):
    page = model_card.page(learned_file)
    assert f"`learned.npz` ({learned_file.stat().st_size:,} bytes)" in page
    lines = page.splitlines()
    for line in (
        "| command | `python -m train.recipe --seed 3` |",
        "| kind | imitation of `allocation`, 7 of 9 rounds |",
        "| decisions | 2.5 M of single boats |",
        "| time | 1.7 h |",
        "| seeds of its worlds | 1,003,000,000 to 1,003,999,999 |",
        "| tasks | transport, push |",
        "| boats | 4, 6, 12 |",
        "| scenarios | noisy, gyre |",
        "| hulls | plank, L |",
        "| code | a1 (instructions b2), torch 2.1, Python 3.12, abacus; then "
        "unknown (instructions c3), torch 2.1, Python 3.12, abacus |",
        "| transport | 4 | noisy | plank | 50 | 50.0% | 31.2 | 2.10 | 0.062 |",
        "| push | 4 | gyre | plank | 50 | 0.0% | – | – | – |",
    ):
        assert line in lines


def test_the_page_of_the_model_card_says_where_there_is_none(learned_file):
    learned_file.unlink()
    page = model_card.page(learned_file)
    assert "holds none yet" in page
    assert "|" not in page


def test_a_model_card_that_lacks_something_is_named(learned_file, monkeypatch):
    weights, card = team_policy.read(learned_file)
    del card["development"]
    team_policy.save(learned_file, weights, card)
    monkeypatch.chdir(ROOT)
    with pytest.raises(SystemExit, match=r"learned\.npz: its model card lacks 'development'"):
        pages.main(["--check"])
