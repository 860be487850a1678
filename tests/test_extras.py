"""Commands where the libraries of an extra are missing, and the extras that are named then."""

import re
import subprocess
import sys
import tomllib
from importlib import metadata
from pathlib import Path

import pytest

from baselines.rollout.extras import EXTRAS, needed, remedy

ROOT = Path(__file__).parents[1]
WITHOUT = """
import runpy, sys
sys.modules.update(dict.fromkeys(sys.argv[1].split()))
sys.argv = sys.argv[2:]
runpy.run_module(sys.argv[0], run_name="__main__")
"""


@pytest.mark.parametrize(
    ("words", "extra", "missing"),
    [
        (["baselines.evaluate", "--task", "push"], "eval", "joblib matplotlib"),
        (["baselines.reproduce"], "eval", "tqdm matplotlib"),
        (["train", "--task", "push", "--torch-threads", "1"], "train", "torch"),
        (["train.recipe"], "train", "torch"),
    ],
)
def test_a_command_names_the_extra_that_it_needs(words, extra, missing, tmp_path):
    command = [sys.executable, "-c", WITHOUT, missing, *words, "--out", str(tmp_path / "none")]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 1
    assert len(done.stderr.splitlines()) == 1
    assert done.stderr.startswith(f"python -m {words[0]}: ")
    assert f"pip install 'asv-env[{extra}]'" in done.stderr
    assert not (tmp_path / "none").exists()


@pytest.mark.parametrize("extra", EXTRAS)
def test_an_extra_installs_the_libraries_that_it_is_named_for(extra):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    listed = project["optional-dependencies"][extra]
    names = {re.split(r"[\[<>=!~;]", entry)[0].strip() for entry in listed}
    installed = metadata.packages_distributions()
    for module in EXTRAS[extra]:
        found = {name.lower().replace("_", "-") for name in installed.get(module, names)}
        assert names & found, f"{module} is of {found}"


def test_other_errors_are_those_of_the_caller():
    error = ModuleNotFoundError("No module named 'mine'", name="mine")
    assert remedy(error) == ""
    with pytest.raises(ModuleNotFoundError), needed("command"):
        raise error
