"""The evaluation as its tests run it: from its command line, with few episodes."""

import pytest

from baselines import evaluate
from baselines.evaluate.conditions import Condition, Suite
from baselines.evaluate.results import read_csv

brief = {"task": {"time_limit": 3.0}}
"""A scenario in which episodes last three seconds."""
blurred = {**brief, "sensors": {"position_noise": 0.01}}
TINY = Suite(
    "tiny-v1",
    "Two conditions, half a second each.",
    tuple(
        Condition(name, scenario=scenario, options={"time_limit": 0.5})
        for name, scenario in {"exact": "nominal", "noisy": "noisy"}.items()
    ),
    seed=50,
    episodes=4,
)
WHOLE = ["--task", "push", "--episodes", "3", "--num-envs", "2", "--workers", "0"]
SHORT = [*WHOLE, "--scenario", "command_line:brief"]


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
