"""The evaluation as its tests run it: from its command line, with few episodes."""

import pytest

from baselines import evaluate
from baselines.evaluate.results import read_csv

SHORT = ["--task", "push", "--episodes", "3", "--num-envs", "2", "--workers", "0"]


def run(*arguments):
    evaluate.main([str(argument) for argument in arguments])


def rows(folder):
    return read_csv(folder / "episodes.csv")


def refused(capsys, *arguments):
    """What the command line prints when it refuses."""
    with pytest.raises(SystemExit) as stopped:
        run(*arguments)
    assert stopped.value.code == 2
    return capsys.readouterr().err
