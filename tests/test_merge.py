"""Policies are added to published results only where the episodes are the same."""

import json
import shutil
from dataclasses import replace

import pytest

from asv_env import files
from baselines.evaluate.conditions import Condition, Suite
from baselines.evaluate.publish import merge
from baselines.evaluate.results import of_rows, read_csv, write_csv
from baselines.evaluate.summary import summarise
from baselines.policy import POLICIES
from baselines.rollout import runner
from baselines.rollout.episodes import Label

SHORT = {"time_limit": 3.0}
SUITE = Suite(
    "short-v1",
    "Episodes of a few seconds.",
    (Condition("nominal", options=SHORT), Condition("noisy", scenario="noisy", options=SHORT)),
    seed=3_000_000,
)


def write_run(folder, policy, episodes):
    """Runs a policy, and writes what the evaluation leaves of it."""
    suite = SUITE.first(episodes)
    rows = [
        log.episode
        for condition in suite.conditions
        for log in runner.run(
            POLICIES[policy], condition.params, suite.seeds, episodes,
            Label(policy, None, condition.name, condition.scenario),
        )
    ]  # fmt: skip
    results = of_rows(suite, rows)
    provenance = {"suite": suite.name, "task": "transport", "set of episodes": suite.digest()}
    summary = {
        "suite": suite.name,
        "about": suite.about,
        "episodes": episodes,
        "seeds": [suite.seeds[0], suite.seeds[-1]],
        "provenance": {
            **provenance,
            "state of the code": "c0de",
            "set of libraries": {"pymunk": "7"},
        },
        "policies": {policy: [policy]},
        **summarise(results),
    }
    folder.mkdir()
    write_csv(folder / "episodes.csv", results)
    (folder / "summary.json").write_text(json.dumps(summary))


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Results of one policy, and a run of another with more episodes."""
    folder = tmp_path_factory.mktemp("merge")
    write_run(folder / "published", "idle", 3)
    write_run(folder / "run", "random", 4)
    return folder


@pytest.fixture
def folder(made, tmp_path, monkeypatch):
    monkeypatch.setattr(merge, "SUITES", {SUITE.name: SUITE})
    shutil.copytree(made, tmp_path / "here")
    return tmp_path / "here"


def merged(folder, checked):
    arguments = [str(folder / "run"), str(folder / "published"), "--checked", str(checked)]
    merge.main(arguments)


def refusal(folder, checked=1):
    before = (folder / "published/episodes.csv").read_bytes()
    with pytest.raises(SystemExit) as refused:
        merged(folder, checked)
    assert (folder / "published/episodes.csv").read_bytes() == before
    return str(refused.value)


def change_first_error(folder, difference):
    file = folder / "published/episodes.csv"
    error = str(read_csv(file)[0].position_error)
    file.write_text(file.read_text().replace(error, str(float(error) + difference)))


def test_policies_are_added(folder):
    old = read_csv(folder / "published/episodes.csv")
    new = [row for row in read_csv(folder / "run/episodes.csv") if row.seed <= 3_000_002]
    for _ in range(2):  # policies that are there already are replaced
        merged(folder, 5)
        rows = read_csv(folder / "published/episodes.csv")
        assert len(rows) == 12
        assert all(row in rows for row in [*old, *new])
    summary = json.loads((folder / "published/summary.json").read_text())
    assert list(summary["policies"]) == ["idle", "random"]
    assert set(summary["conditions"]["noisy"]["policies"]) == {"idle", "random"}
    assert summary["added"]["random"]["suite"] == "short-v1"
    assert "random" in (folder / "published/report.md").read_text()


def test_a_replaced_policy_comes_last_and_is_compared_with_the_first(folder, made):
    merged(folder, 1)
    shutil.rmtree(folder / "run")
    write_run(folder / "run", "idle", 3)
    merged(folder, 1)
    summary = json.loads((folder / "published/summary.json").read_text())
    assert list(summary["policies"]) == ["random", "idle"]
    assert "Compared with random" in (folder / "published/report.md").read_text()


def test_episodes_that_differ_are_not_kept(folder):
    change_first_error(folder, 0.25)
    words = "idle, nominal: 1 of 1 episodes differ from the published ones, seed 3000000"
    assert words in refusal(folder)


def test_rounding_of_another_processor_does_not_count(folder):
    change_first_error(folder, 1e-9)
    merged(folder, 1)


def test_one_episode_in_which_rounding_has_grown_does_not_count(folder):
    change_first_error(folder, 1e-3)
    merged(folder, 3)


def test_one_episode_that_ends_differently_counts(folder):
    file = folder / "published/episodes.csv"
    rows = read_csv(file)
    rows[0] = replace(rows[0], cause="strayed", position_error=1.0)
    write_csv(file, of_rows(SUITE.first(3), rows))
    assert "idle, nominal: 1 of 3 episodes differ" in refusal(folder, 3)


def test_weights_of_the_reward_do_not_count(folder):
    file = folder / "published/episodes.csv"
    episode_return = str(read_csv(file)[0].episode_return)
    file.write_text(file.read_text().replace(episode_return, "0.125"))
    merged(folder, 1)


def test_runs_that_cannot_be_compared_are_refused(folder):
    file = folder / "run/summary.json"
    summary = json.loads(file.read_text())
    file.write_text(json.dumps({**summary, "episodes": 1}))
    assert "run it with --episodes 3" in refusal(folder)
    summary["provenance"]["set of libraries"]["pymunk"] = "0"
    file.write_text(json.dumps(summary))
    assert "set of libraries is" in refusal(folder)
    shutil.rmtree(folder / "run")
    assert "summary.json" in refusal(folder)


@pytest.mark.parametrize("name", ["episodes.csv", "summary.json", "report.md"])
def test_a_merge_that_could_not_write_a_file_is_finished_by_the_same_command(name, folder):
    def written():
        return {path.name: path.read_bytes() for path in (folder / "published").glob("*.*")}

    (folder / "published/report.md").unlink(missing_ok=True)
    shutil.copytree(folder / "published", folder / "before")
    merged(folder, 1)
    expected = written()
    shutil.rmtree(folder / "published")
    shutil.copytree(folder / "before", folder / "published")
    write = files.write

    def full(path, save):
        if path.name == name:
            raise OSError(f"{path} cannot be written: no space left on device")
        write(path, save)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(files, "write", full)
        with pytest.raises(SystemExit, match="no space left"):
            merged(folder, 1)
    merged(folder, 1)
    assert written() == expected
