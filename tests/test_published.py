"""Rows of files, and the published results that follow from them."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from baselines.evaluate.publish import pages
from baselines.evaluate.results import of_rows, read_csv, write_csv
from baselines.evaluate.suites import SUITES
from baselines.evaluate.summary import summarise
from baselines.rollout.episodes import Episode
from baselines.rollout.lock import locked

ROOT = Path(__file__).parents[1]
RESULTS = ROOT / "docs/results"
SUITE = SUITES["plane-v2"]


def row(condition, seed, policy="one", **changes):
    """An episode of a suite's condition, made up."""
    values = {
        "seed": seed, "policy": policy, "training_seed": None, "condition": condition.name,
        "task": condition.task, "scenario": condition.scenario, "num_boats": 4, "success": True,
        "cause": None, "goal_x": 0.1,
        "goal_y": -1 / 3, "goal_heading": None, "position_error": 1e-17, "heading_error": -0.1,
        "min_position_error": 0.01, "heading_error_at_min": 0.02, "time_to_closure": None,
        "closure_spread": None, "time_to_goal": 70.1, "duration": 70.1, "path_length_ratio": 1.5,
        "effort": 20.0, "collisions": 3, "closure_lost": 0, "episode_return": 0.1 + 0.2,
        "error": None,
    }  # fmt: skip
    return Episode(**{**values, **changes})


def all_rows(policy="one", episodes=3, **changes):
    seeds = SUITE.seeds[:episodes]
    return [
        row(condition, seed, policy, **changes) for condition in SUITE.conditions for seed in seeds
    ]


# ---------------------------------------------------------------- rows


def test_rows_come_back_from_a_file_as_they_were(tmp_path):
    rows = [
        *all_rows(),
        *all_rows("two", success=False, cause="policy error", error='ValueError: "a", b; ±1'),
        *all_rows("three", training_seed=1),
    ]
    write_csv(tmp_path / "episodes.csv", rows)
    assert read_csv(tmp_path / "episodes.csv") == rows


@pytest.mark.parametrize(
    ("distance", "heading", "within"),
    [
        (0.02, -0.04, ["0.5", "1", "wide"]),
        (0.02, 0.06, ["1", "wide"]),
        (0.051, 0.0, ["wide"]),
        (0.09, -0.49, ["wide"]),
        (0.101, 0.0, []),
        (0.0, 0.51, []),
    ],
)
def test_episodes_are_placed_within_the_tolerances_that_they_meet(distance, heading, within):
    rows = all_rows(min_position_error=distance, heading_error_at_min=heading, success=False)
    summary = summarise(of_rows(SUITE, rows))
    placed = summary["conditions"]["nominal"]["policies"]["one"]["placed"]
    assert [name for name, share in placed.items() if share["value"] == 1.0] == within
    assert {share["value"] for name, share in placed.items() if name not in within} <= {0.0}
    shares = [line for line in pages.page([of_rows(SUITE, rows)]).split("\n") if "| one |" in line]
    assert all((" | 100.0% | " in line) == ("wide" in within) for line in shares)


@pytest.mark.parametrize("text", ["", "seed,policy\n1,x\n"])
def test_a_file_of_other_columns_is_refused(tmp_path, text):
    (tmp_path / "episodes.csv").write_text(text)
    with pytest.raises(ValueError, match=r"episodes\.csv is damaged.*: its columns must be seed"):
        read_csv(tmp_path / "episodes.csv")


def test_rows_in_any_order_make_the_same_results():
    rows = [*all_rows("one"), *all_rows("two", training_seed=0), *all_rows("two", training_seed=1)]
    results = of_rows(SUITE, rows)
    assert results.suite.episodes == 3
    assert list(of_rows(SUITE, sorted(rows, key=lambda r: (r.policy, -r.seed)))) == list(results)
    assert results.column("noisy", "two", "seed").tolist() == [list(SUITE.seeds[:3])] * 2


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ([], "no episodes of plane-v2"),
        (all_rows()[1:], "seeds are not the first ones"),
        ([replace(one, seed=one.seed - 5) for one in all_rows()], "seeds are not the first ones"),
        (all_rows(task="push"), "not an episode of plane-v2"),
        (all_rows(num_boats=5), "not an episode of plane-v2"),
        ([one for one in all_rows() if one.condition == "noisy"], "its conditions are not those"),
        (
            [*all_rows(), row(replace(SUITE.conditions[0], name="more"), 0)],
            "its conditions are not",
        ),
        (
            [*all_rows(episodes=1), row(SUITE.conditions[0], SUITE.seed, training_seed=1)],
            "its conditions are not those",
        ),
    ],
)
def test_rows_that_are_not_the_suites_are_refused(rows, message):
    with pytest.raises(ValueError, match=message):
        of_rows(SUITE, rows)


# ---------------------------------------------------------------- pages


@pytest.fixture
def folder(tmp_path):
    """Results that are not very good, and a page for them."""
    (tmp_path / "plane-v2").mkdir()
    rows = [*all_rows("one"), *all_rows("two", success=False, cause="strayed", time_to_goal=None)]
    write_csv(tmp_path / "plane-v2/episodes.csv", rows)
    (tmp_path / "page.md").write_text(f"before\n{pages.START}\nold\n{pages.END}\nafter\n")
    return tmp_path


def command(folder, *more):
    pages.main(["--results", str(folder), "--page", str(folder / "page.md"), *more])


def test_nothing_is_published_while_a_suite_or_all_of_them_are_in_use(folder, monkeypatch):
    before = {path: path.read_bytes() for path in folder.rglob("*.*") if path.is_file()}
    for used in (folder, folder / "plane-v2"):
        with locked(used), pytest.raises(SystemExit, match="in use by another run"):
            command(folder)
    assert all(path.read_bytes() == text for path, text in before.items())
    monkeypatch.setenv("HOME", str(folder))
    pages.main(["--results=~", "--page=~/page.md"])
    command(folder, "--check")


def test_pages_show_the_numbers_of_the_rows(folder):
    command(folder)
    page = (folder / "page.md").read_text(encoding="utf-8")
    assert page.startswith("before\n")
    assert page.endswith("after\n")
    assert "| `plane-v2` | 2 × 3 | 100.0% (worst: nominal, 100.0%) | 0.0% (worst:" in page
    conditions = (folder / "README.md").read_text(encoding="utf-8")
    assert "| one | 100.0% [43.9, 100.0] |" in conditions
    assert "| two | 0.0% [0.0, 56.1] | −100.0 [" in conditions


def write_summary(folder):
    """Writes the summary of the rows, as the evaluation leaves it."""
    results = of_rows(SUITE, read_csv(folder / "plane-v2/episodes.csv"))
    provenance = {
        "set of episodes": SUITE.digest(),
        "state of the code": "b",
        "set of libraries": {"pymunk": "7"},
    }
    summary = {
        "suite": "plane-v2",
        "about": SUITE.about,
        "episodes": 3,
        "seeds": [3_000_000, 3_000_002],
        "provenance": provenance,
        "policies": {"one": ["one"], "two": ["two"]},
        **summarise(results),
    }
    (folder / "plane-v2/summary.json").write_text(json.dumps(summary))


def test_a_report_that_differs_from_its_summary_is_written_again(folder):
    write_summary(folder)
    (folder / "plane-v2/report.md").write_text("another report")
    command(folder)
    assert "Compared with one" in (folder / "plane-v2/report.md").read_text(encoding="utf-8")


def test_stale_pages_are_named_and_left_alone(folder):
    before = (folder / "page.md").read_text()
    with pytest.raises(SystemExit, match=r"stale: .*page\.md"):
        command(folder, "--check")
    assert (folder / "page.md").read_text() == before
    command(folder)
    command(folder, "--check")
    rows = read_csv(folder / "plane-v2/episodes.csv")
    write_csv(folder / "plane-v2/episodes.csv", [replace(rows[0], success=False), *rows[1:]])
    with pytest.raises(SystemExit, match="stale"):
        command(folder, "--check")


def test_pages_say_that_nothing_is_published_until_something_is(folder):
    (folder / "plane-v2").rename(folder / "elsewhere")
    with pytest.raises(SystemExit, match=r"elsewhere/episodes\.csv: unknown suite 'elsewhere'"):
        command(folder, "--check")
    (folder / "elsewhere/episodes.csv").rename(folder / "rows.csv")
    command(folder)
    command(folder, "--check")
    for name in ("page.md", "README.md"):
        page = (folder / name).read_text(encoding="utf-8")
        assert pages.NOT_YET in page
        assert "|" not in page
    (folder / "elsewhere").rename(folder / "plane-v2")
    (folder / "rows.csv").rename(folder / "plane-v2/episodes.csv")
    with pytest.raises(SystemExit, match=r"stale: .*page\.md, .*README\.md"):
        command(folder, "--check")
    command(folder)
    assert pages.NOT_YET not in (folder / "page.md").read_text(encoding="utf-8")


def test_a_page_without_marks_and_a_folder_that_is_none_are_refused(folder):
    (folder / "page.md").write_text("nothing")
    with pytest.raises(SystemExit, match="the page needs a line"):
        command(folder)
    with pytest.raises(SystemExit, match="nowhere does not exist"):
        pages.main(["--results", str(folder / "nowhere"), "--page", str(folder / "page.md")])


def check_summaries(folder):
    """Every published summary is that of the published rows."""
    for results in pages.read(folder):
        suite = results.suite
        summary = json.loads((folder / suite.name / "summary.json").read_text())
        assert summary["provenance"]["set of episodes"] == suite.digest()
        assert summary["episodes"] == suite.episodes
        for condition in suite.conditions:
            for policy in results.policies:
                found = summary["conditions"][condition.name]["policies"][policy]
                assert found["success"]["value"] == results.success(condition.name, policy).mean()
                distance = results.column(condition.name, policy, "min_position_error")
                assert found["min_position_error"]["median"] == np.median(distance)


def test_the_published_summaries_are_those_of_the_published_rows():
    check_summaries(RESULTS)


def test_a_summary_of_other_rows_is_noticed(folder):
    write_summary(folder)
    check_summaries(folder)
    file = folder / "plane-v2/episodes.csv"
    rows = read_csv(file)
    write_csv(file, [replace(rows[0], success=False, cause="strayed"), *rows[1:]])
    with pytest.raises(AssertionError):
        check_summaries(folder)


def test_the_pages_of_this_repository_are_not_stale(monkeypatch):
    monkeypatch.chdir(ROOT)
    pages.main(["--check"])
