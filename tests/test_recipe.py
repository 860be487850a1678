"""The recipe of the policy `learned`: ``python -m train.recipe``."""

import shlex

import pytest
import tyro

from baselines.evaluate.publish import model_card
from baselines.learned import team_policy

torch = pytest.importorskip("torch")
from train import recipe  # noqa: E402
from train.recipe import CHECKPOINT, CURVE, POLICY, ROUND, Options  # noqa: E402
from train.team.team_imitation import Kind, Rounds  # noqa: E402

TINY = [
    *("--seed", "2", "--rounds", "2", "--kinds", "1", "--boats", "4", "--time", "1"),
    *("--steps", "1", "--batch", "4", "--episodes", "1", "--every", "1", "--teams", "4"),
    *("--hulls", "plank", "--tasks", "push", "approach"),
]


@pytest.fixture(scope="module")
def followed(tmp_path_factory):
    """Folder of a tiny recipe that has come to its end."""
    out = tmp_path_factory.mktemp("recipe") / "run"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(recipe, "EVALUATED", (Kind("push"), Kind("transport")))
        recipe.main([*TINY, "--out", str(out)])
    return out


def test_it_leaves_a_policy_its_curve_and_its_checkpoint(followed):
    left = {file.name for file in followed.iterdir() if not file.name.startswith(".")}
    assert left == {POLICY, CURVE, CHECKPOINT}
    _, card = team_policy.read(followed / POLICY)
    assert card["training_seeds"] == [1_002_000_000, 1_002_999_999]
    assert card["rounds"] == 2
    assert card["seconds"] > 0
    (score,) = card["development"]  # of the kinds of worlds that the run has
    assert (score["task"], score["vessel"], score["episodes"]) == ("push", "plank", 1)
    assert f"`{card['command']}`" in model_card.page(followed / POLICY)
    assert (followed / CURVE).read_text().count("push, noisy") == 2


def test_its_model_card_names_a_command_that_trains_the_same(followed):
    _, card = team_policy.read(followed / POLICY)
    program, given = card["command"].split(" --", 1)
    assert program == recipe.PROGRAM
    again = tyro.cli(Options, args=shlex.split(f"--{given}"))
    asked = tyro.cli(Options, args=TINY)
    assert (again.seed, again.imitation) == (asked.seed, asked.imitation)
    assert Options().command == f"{program} --seed 0"


def test_the_same_command_does_nothing_more(followed):
    before = {file: file.stat().st_mtime_ns for file in followed.glob("*.*")}
    recipe.main([*TINY, "--out", str(followed)])
    assert {file: file.stat().st_mtime_ns for file in followed.glob("*.*")} == before


def test_a_killed_run_resumes_and_ends_with_the_same_policy(followed, tmp_path, monkeypatch):
    monkeypatch.setattr(recipe, "EVALUATED", (Kind("push"),))
    evaluate, seen = recipe._evaluate, []

    def killed(imitation, progress, options):
        seen.append(imitation.round)
        if len(seen) == 1:
            raise KeyboardInterrupt
        evaluate(imitation, progress, options)

    monkeypatch.setattr(recipe, "_evaluate", killed)
    given = [*TINY, "--out", str(tmp_path / "run")]
    with pytest.raises(SystemExit, match="give the same command to continue"):
        recipe.main(given)
    assert (tmp_path / "run" / ROUND.format(1)).exists()
    recipe.main(given)
    assert seen == [1, 2, 2]
    (one, card), (other, _) = (team_policy.read(f / POLICY) for f in (tmp_path / "run", followed))
    assert all((one[name] == other[name]).all() for name in other)
    assert len(card["software"]) == 1


def test_what_makes_no_sense_is_refused_before_anything_is_made(followed, tmp_path):
    with pytest.raises(SystemExit, match="its run has rounds = 2, not 3"):
        recipe.main([*TINY, "--rounds", "3", "--out", str(followed)])
    with pytest.raises(ValueError, match="need 1,024,000 seeds, a run has 1,000,000"):
        Options(imitation=Rounds(rounds=1000, kinds=8, boats=128))


def test_it_is_noted_when_a_run_is_resumed_with_other_code():
    progress = recipe.Progress()
    one = {"code": "a", "libraries": {"torch": "2"}, "revision": "r"}
    for software in (one, one | {"revision": "s"}, one | {"code": "b"}):
        progress.note(software)
    assert progress.software == [one, one | {"code": "b"}]
