"""The evaluation, from the command line to its files."""

import json
import re
import sqlite3

import numpy as np
import pytest
from command_line import SHORT, TINY, WHOLE, refused, rows, run

from asv_env import PRESETS, SCENARIOS, TASKS
from baselines.evaluate.request import FILES
from baselines.evaluate.store import NAME as STORE
from baselines.evaluate.store import Store, _checksum
from baselines.evaluate.suites import SUITES
from baselines.policy import POLICIES
from baselines.rollout.episodes import COLUMNS

pytestmark = pytest.mark.usefixtures("no_report")


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    run(*WHOLE, "--policies", "scripted", "idle", "--seed", 7, "--out", folder)
    return folder


def test_every_policy_meets_the_same_seeds_in_order(results):
    assert [(row.policy, row.seed) for row in rows(results)] == [
        (policy, seed) for policy in ("scripted", "idle") for seed in (7, 8, 9)
    ]


def test_columns_are_empty_where_they_do_not_apply(results):
    assert (results / "episodes.csv").read_text().splitlines()[0] == ",".join(COLUMNS)
    idle = next(row for row in rows(results) if row.policy == "idle")
    assert not idle.success
    assert idle.cause == "never near"
    assert idle.time_to_goal is None
    assert idle.time_to_closure is None
    assert idle.training_seed is None
    assert idle.position_error == pytest.approx(np.hypot(0.55, 0.95))
    assert idle.heading_error == pytest.approx(-0.1)
    assert idle.path_length_ratio == 0.0
    assert idle.duration == 120.0
    assert (idle.goal_x, idle.goal_y, idle.goal_heading) == (0.55, -0.95, 0.1)


def test_summary_agrees_with_the_rows(results):
    (condition,) = json.loads((results / "summary.json").read_text())["conditions"].values()
    for name in ("scripted", "idle"):
        own = [row for row in rows(results) if row.policy == name]
        summary = condition["policies"][name]
        assert summary["success"]["value"] == np.mean([row.success for row in own])
        assert summary["causes"] == ({"never near": 3} if name == "idle" else {})
        mean = np.mean([row.effort for row in own])
        assert summary["effort"]["mean"]["value"] == pytest.approx(mean)
        errors = np.abs([row.heading_error for row in own])
        assert summary["heading_error"]["median"] == pytest.approx(np.median(errors))
    compared = condition["comparisons"]["idle"]
    assert compared["success"]["value"] == -1.0
    assert compared["improvement"]["value"] == 0.0
    assert compared["mcnemar"] == pytest.approx(0.25)  # three of three: 2 / 2^3


def test_files_are_left_as_the_command_says(results):
    assert all((results / name).exists() for name in FILES)


def test_what_is_there_is_kept_and_only_what_is_new_is_run(tmp_path, capsys):
    run(*SHORT, "--policies", "idle", "--out", tmp_path)
    before = rows(tmp_path)
    with sqlite3.connect(tmp_path / STORE) as base:  # as a mark that it is not run again
        base.create_function("checked", -1, _checksum)
        base.execute("UPDATE episode SET row = replace(row, '\"effort\": 0.0', '\"effort\": 7.0')")
        columns = "condition, policy, training, seed, row, log"
        base.execute(f"UPDATE episode SET checksum = checked({columns})")
    run(*SHORT, "--policies", "idle", "random", "--episodes", 4, "--out", tmp_path)
    after = rows(tmp_path)
    assert [row.effort for row in after if row.policy == "idle"] == [7.0, 7.0, 7.0, 0.0]
    assert [row.seed for row in after if row.policy == "idle"][:3] == [row.seed for row in before]
    assert sum(row.policy == "random" for row in after) == 4


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--task", "push", "--scenario", "noisy"], "another set of episodes"),
        (["--task", "approach"], "another task"),
        (["--suite", "quick-v2"], "another suite"),
    ],
)
def test_results_of_another_provenance_are_not_mixed_or_lost(results, arguments, message, capsys):
    before = (results / "episodes.csv").read_bytes()
    common = ["--policies", "idle", "--workers", "0", "--out", results]
    assert message in refused(capsys, *common, *arguments)
    assert (results / "episodes.csv").read_bytes() == before
    assert len(rows(results)) == 6


def test_other_code_is_noticed(tmp_path, capsys, monkeypatch):
    run(*SHORT, "--policies", "idle", "--out", tmp_path)
    monkeypatch.setattr("baselines.rollout.provenance.code", lambda: "other")
    assert "state of the code" in refused(capsys, *SHORT, "--policies", "idle", "--out", tmp_path)
    run(*SHORT, "--policies", "idle", "--out", tmp_path, "--overwrite")


def test_files_of_others_are_not_replaced_unless_asked(tmp_path, capsys):
    (tmp_path / "summary.json").write_text("mine")
    assert "--overwrite" in refused(capsys, *SHORT, "--policies", "idle", "--out", tmp_path)
    assert (tmp_path / "summary.json").read_text() == "mine"
    run(*SHORT, "--policies", "idle", "--out", tmp_path, "--overwrite")
    assert json.loads((tmp_path / "summary.json").read_text())["suite"] == "custom"


def test_two_runs_do_not_write_to_one_folder(tmp_path):
    first = Store(tmp_path, {"suite": "one"}, {}, False)
    with pytest.raises(FileExistsError, match="in use by another run"):
        Store(tmp_path, {"suite": "one"}, {}, False)
    first.close()
    Store(tmp_path, {"suite": "one"}, {}, False).close()


def test_a_folder_that_cannot_be_is_refused(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    message = refused(capsys, *SHORT, "--policies", "idle", "--out", tmp_path / "file" / "below")
    assert "file" in message


def test_a_file_that_is_no_database_is_refused(tmp_path, capsys):
    (tmp_path / STORE).write_text("something else, and long enough to be looked at" * 9)
    message = refused(capsys, *SHORT, "--policies", "idle", "--out", tmp_path)
    assert "file is not a database" in message


def test_a_suite_is_run_condition_by_condition(tmp_path):
    words = ["--suite", "command_line:TINY", "--task", "push", "--episodes", 2, "--workers", 0]
    run(*words, "--policies", "idle", "--out", tmp_path)
    assert [(row.condition, row.seed) for row in rows(tmp_path)] == [
        (condition.name, seed) for condition in TINY.conditions for seed in TINY.seeds[:2]
    ]


def test_a_sweep_is_a_suite_of_ones_own(tmp_path):
    sweep = [
        "--scenario",
        "command_line:brief",
        "command_line:blurred",
        "--num-boats",
        2,
        3,
        "--episodes",
        1,
    ]
    run(*SHORT, "--policies", "idle", *sweep, "--out", tmp_path)
    assert [(row.condition, row.num_boats, row.scenario) for row in rows(tmp_path)] == [
        (f"{boats} boats, {scenario}", boats, scenario)
        for scenario in ("brief", "blurred")
        for boats in (2, 3)
    ]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--task", "transprt"], "Did you mean 'transport'"),
        (["--scenario", "noissy"], "Did you mean 'noisy'"),
        (["--suite", "plane-v9"], "Did you mean 'plane-v2'"),
        (["--suite", "plane-v2", "--scenario", "noisy"], "--scenario cannot go with --suite"),
        (["--suite", "plane-v2", "--seed", "0"], "--seed cannot go with --suite"),
        (["--suite", "plane-v2", "--episodes", "2001"], "has 2000"),
        (["--policies", "idle", "idle"], "once"),
        (["--episodes", "0"], "--episodes 0"),
        (["--num-envs", "-1"], "--num-envs -1"),
        (["--workers", "-1"], "--workers -1"),
        (["--replays", "-1"], "--replays -1"),
        (["--seed", "-1"], "--seed -1"),
        (["--goal", "9", "0", "0"], "arena"),
        (["--goal", "nan", "0", "0"], "finite"),
        (["--num-boats", "1"], "2 to 100"),
        (["--seed", "9223372036854775808"], "must lie below"),
        (["--goal", "1", "0", "0", "--random-goals"], "not allowed with"),
        (["--video", "film.avi"], ".mp4"),
        (["--scenario", "noisy", "noisy"], "once"),
    ],
)
def test_bad_options_are_refused_before_anything_runs(arguments, message, tmp_path, capsys):
    assert message in refused(capsys, *arguments, "--out", tmp_path / "none")
    assert not (tmp_path / "none").exists()


def test_the_help_names_all_that_can_be_chosen(capsys):
    with pytest.raises(SystemExit):
        run("--help")
    words = set(re.findall(r"[\w-]+", capsys.readouterr().out))
    for registry in (POLICIES, SUITES, TASKS, SCENARIOS, PRESETS):
        assert set(registry) <= words
