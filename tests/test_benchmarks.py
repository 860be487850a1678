"""Command lines of the benchmarks: what makes no sense is refused in one line."""

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
    for name in ("subjects", "stopwatch"):
        sys.modules.pop(name, None)


@pytest.mark.parametrize(
    ("name", "words", "message"),
    [
        ("throughput", ["--worlds", 0], "--worlds (0,): must be from 1"),
        ("throughput", ["--worlds", 10**10], "must be from 1 to 1,000,000"),
        ("throughput", ["--seconds", "nan"], "seconds = nan"),
        ("throughput", ["--rounds", 10**20], "rounds = 1"),
        ("throughput", ["--out", "."], "--out . exists"),
        ("memory", ["--worlds", -3], "worlds = -3"),
        ("memory", ["--steps", 0], "steps = 0"),
        ("training", ["--updates", 0], "updates = 0"),
        ("training", ["--torch-threads", 0], "torch_threads = 0"),
        ("training", ["--task", "puhs"], "Did you mean 'push'"),
        ("training", ["--num-envs", 10**12], "num_envs = 1000000000000"),
    ],
)
def test_options_that_make_no_sense_are_refused(name, words, message, run):
    assert message in run(name, *words)


def test_samples_are_saved_or_the_file_is_named(run, tmp_path):
    quick = ("--worlds", 1, "--seconds", 0.01, "--rounds", 1, "--no-vmas", "--out")
    assert run("throughput", *quick, tmp_path / "deep/samples.json") == ""
    assert json.loads((tmp_path / "deep/samples.json").read_text())["samples"]
    message = run("throughput", *quick, tmp_path / "deep/samples.json/x")
    assert "samples.json/x cannot be written: not a directory" in message
