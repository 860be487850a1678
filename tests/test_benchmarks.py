"""Command lines of the benchmarks: what makes no sense is refused in one line."""

import csv
import json
import runpy
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[1] / "benchmarks"


@pytest.fixture
def run(monkeypatch, capsys):
    monkeypatch.syspath_prepend(str(FOLDER))

    def run(name, *words):
        """The message with which a benchmark exits; empty where it comes to its end."""
        main = runpy.run_path(str(FOLDER / f"{name}.py"))["main"]
        try:
            main([str(word) for word in words])
        except SystemExit as stopped:
            text = f"{stopped.code} {capsys.readouterr().err}"
            return " ".join(text.replace("│", " ").split())
        return ""

    yield run
    for name in ("subjects", "stopwatch", "turns"):
        sys.modules.pop(name, None)


@pytest.mark.parametrize(
    ("name", "words", "message"),
    [
        ("throughput", ["--worlds", -1], "--worlds (-1,): must be from 0"),
        ("throughput", ["--worlds", 10**10], "must be from 0 to 1,000,000"),
        ("throughput", ["--seconds", "nan"], "seconds = nan"),
        ("throughput", ["--torchrl", "--worlds", 0], "--torchrl: give --worlds above 0"),
        ("throughput", ["--rounds", 10**20], "rounds = 1"),
        ("throughput", ["--out", "."], "--out . exists"),
        ("throughput", ["--page", FOLDER / "turns.py"], "has no line <!-- throughput -->"),
        ("memory", ["--worlds", -3], "worlds = -3"),
        ("memory", ["--steps", 0], "steps = 0"),
        ("coefficients", ["--page", FOLDER / "turns.py"], "needs a line '<!-- coefficients -->'"),
        ("convergence", ["--page", FOLDER / "turns.py"], "needs a line '<!-- convergence -->'"),
        ("development", ["--seed", 0], "seed 0 is not for development"),
        ("development", ["--page", FOLDER / "turns.py"], "a line '<!-- development robust-v2 -->'"),
        ("discrete_actions", ["--seed", 7], "seed 7 is not for development"),
        ("option_cost", ["--worlds", 0], "worlds = 0"),
        ("policy_cost", ["--policies", "scriptd"], "Did you mean 'scripted'"),
        ("policy_cost", ["--ticks", 0], "ticks = 0"),
        ("soak", ["--ticks", 0], "ticks = 0"),
        ("own_sensing", ["--seed", 0], "seed 0 is not for development"),
        ("own_sensing", ["--task", "psuh"], "Did you mean 'push'"),
        ("own_sensing", ["--page", FOLDER / "turns.py"], "needs a line '<!-- own sensing -->'"),
        ("development", ["--conditions", "contrl"], "condition 'contrl': there are actuation"),
        ("development", ["--suites", "robst-v2"], "Did you mean 'robust-v2'"),
        ("first_success", ["--rows", 0], "rows = 0"),
        ("open_loop", ["--seed", 0], "seed 0 is not for development"),
        ("open_loop", ["--elite", 12], "elite = 12"),
        ("open_loop", ["--suites", "plane-v1"], "Did you mean 'plane-v2'"),
        ("training", ["--updates", 0], "updates = 0"),
        ("training", ["--torch-threads", 0], "torch_threads = 0"),
        ("training", ["--task", "puhs"], "Did you mean 'push'"),
        ("training", ["--num-envs", 10**12], "num_envs = 1000000000000"),
    ],
)
def test_options_that_make_no_sense_are_refused(name, words, message, run):
    assert message in run(name, *words)


def test_conditions_of_suites_are_run_on_seeds_for_development(run, tmp_path):
    page, out = tmp_path / "page.md", tmp_path / "out"
    mark = "<!-- development easy-v1{} -->\n"
    page.write_text(f"above\n{mark.format('')}{mark.format(': up to here')}below\n")
    words = ("--policies", "idle", "random", "--episodes", 2, "--workers", 0, "--page", page)
    names = ("--suites", "easy-v1", "quick-v2", "--conditions", "push")
    assert run("development", *words, *names, "--out", out) == ""
    assert sorted(folder.name for folder in out.iterdir()) == ["easy-v1"]
    text = page.read_text()
    assert "| push | 0 [0, 65.8] % |" in text
    assert "2 episodes each, seeds from 100000000 on." in text
    rows = csv.DictReader((out / "easy-v1/episodes.csv").open())
    assert {row["seed"] for row in rows} == {"100000000", "100000001"}


def test_random_worlds_are_soaked(run):
    assert run("soak", "--steps", 40, "--worlds", 2, "--ticks", 10, "--seed", 1) == ""


def test_samples_and_table_are_saved(run, tmp_path):
    page = tmp_path / "page.md"
    page.write_text("above\n<!-- throughput -->\nold\n<!-- end of throughput -->\nbelow\n")
    quick = ("--worlds", 0, "--seconds", 0.01, "--rounds", 1, "--page", page, "--out")
    assert run("throughput", *quick, tmp_path / "deep/samples.json") == ""
    samples = json.loads((tmp_path / "deep/samples.json").read_text())["samples"]
    assert [each["situation"] for each in samples] == ["unconstrained", "pushing"]
    assert all(0 < each["bare"] < each["wall"] / each["steps"] for each in samples)
    above, *table, below = page.read_text().splitlines()
    assert (above, below) == ("above", "below")
    assert "old" not in table
    assert sum(line.startswith("| gym.make | 1 |") for line in table) == 2
