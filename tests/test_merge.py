"""Policies are put beside published ones only where the episodes are the same."""

import json
import shutil
from dataclasses import replace

import pytest

from baselines import evaluate
from baselines.evaluate.publish import merge
from baselines.evaluate.results import of_rows, read_csv, write_csv
from baselines.evaluate.suites import SUITES

SUITE = ["--suite", "plane-v1", "--workers", "0"]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Results of one policy, and a run of another with more episodes."""
    folder = tmp_path_factory.mktemp("beside")
    for name, policy, episodes in (("published", "idle", 3), ("run", "random", 4)):
        options = ["--policies", policy, "--episodes", str(episodes), "--out", str(folder / name)]
        evaluate.main([*SUITE, *options])
    return folder


@pytest.fixture
def folder(made, tmp_path):
    shutil.copytree(made, tmp_path / "here")
    return tmp_path / "here"


def refusal(folder, capsys):
    before = (folder / "published/episodes.csv").read_bytes()
    with pytest.raises(SystemExit):
        merge.main([str(folder / "run"), str(folder / "published"), "--checked", "1"])
    assert (folder / "published/episodes.csv").read_bytes() == before
    return capsys.readouterr().err


def test_policies_are_added(folder):
    old = read_csv(folder / "published/episodes.csv")
    new = [row for row in read_csv(folder / "run/episodes.csv") if row.seed < 3_000_002]
    for _ in range(2):  # those that are there already are replaced
        merge.main([str(folder / "run"), str(folder / "published")])
        rows = read_csv(folder / "published/episodes.csv")
        assert len(rows) == 12
        assert all(row in rows for row in [*old, *new])
    summary = json.loads((folder / "published/summary.json").read_text())
    assert list(summary["policies"]) == ["idle", "random"]
    assert set(summary["conditions"]["noisy"]["policies"]) == {"idle", "random"}
    assert summary["added"]["random"]["suite"] == "plane-v1"
    assert "random" in (folder / "published/report.md").read_text()


def test_episodes_that_come_out_otherwise_are_not_kept(folder, capsys):
    file = folder / "published/episodes.csv"
    rows = file.read_text().splitlines(keepends=True)
    cells = rows[1].split(",")
    cells[12] = "0.25"  # position_error
    file.write_text("".join([rows[0], ",".join(cells), *rows[2:]]))
    said = "idle, nominal: 1 of 1 episodes come out otherwise than published, seed 3000000"
    assert said in refusal(folder, capsys)


def test_rounding_of_another_processor_does_not_count(folder):
    file = folder / "published/episodes.csv"
    error = str(read_csv(file)[0].position_error)
    file.write_text(file.read_text().replace(error, str(float(error) + 1e-9)))
    merge.main([str(folder / "run"), str(folder / "published"), "--checked", "1"])


def test_one_episode_in_which_rounding_has_grown_does_not_count(folder):
    file = folder / "published/episodes.csv"
    error = str(read_csv(file)[0].position_error)
    file.write_text(file.read_text().replace(error, str(float(error) + 1e-3)))
    merge.main([str(folder / "run"), str(folder / "published"), "--checked", "3"])


def test_one_episode_that_ends_otherwise_counts(folder, capsys):
    file = folder / "published/episodes.csv"
    rows = read_csv(file)
    rows[0] = replace(rows[0], cause="strayed", position_error=1.0)
    write_csv(file, of_rows(SUITES["plane-v1"].first(3), rows))
    with pytest.raises(SystemExit):
        merge.main([str(folder / "run"), str(folder / "published"), "--checked", "3"])
    assert "idle, nominal: 1 of 3 episodes come out otherwise" in capsys.readouterr().err


def test_what_the_reward_weighs_does_not_count(folder):
    file = folder / "published/episodes.csv"
    rows = read_csv(file)
    changed = file.read_text().replace(str(rows[0].episode_return), "0.125")
    file.write_text(changed)
    merge.main([str(folder / "run"), str(folder / "published"), "--checked", "1"])


def test_runs_that_cannot_be_compared_are_refused(folder, capsys):
    file = folder / "run/summary.json"
    summary = json.loads(file.read_text())
    file.write_text(json.dumps({**summary, "episodes": 1}))
    assert "run it with --episodes 3" in refusal(folder, capsys)
    summary["origin"]["set of libraries"]["pymunk"] = "0"
    file.write_text(json.dumps(summary))
    assert "set of libraries is" in refusal(folder, capsys)
    shutil.rmtree(folder / "run")
    assert "summary.json" in refusal(folder, capsys)
