"""Workflows, forms and scripts of the repository name what there is."""

import os
import re
import subprocess
import tomllib
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
SUPPORTED = sorted(re.findall(r":: (3\.\d+)", "\n".join(PROJECT["classifiers"])))
WORKFLOWS = sorted((ROOT / ".github/workflows").glob("*.yml"))
FORMS = [f for f in (ROOT / ".github/ISSUE_TEMPLATE").glob("*.yml") if f.stem != "config"]
SCRIPTS = sorted(file for file in (ROOT / ".ci").iterdir() if not file.suffix)


def jobs(file):
    """Jobs of a workflow by name, each with steps."""
    return yaml.safe_load(file.read_text())["jobs"]


def steps(file):
    return [step for job in jobs(file).values() for step in job["steps"]]


@pytest.mark.parametrize("file", WORKFLOWS, ids=lambda file: file.stem)
def test_workflows_run_scripts_that_exist_and_may_do_little(file):
    content = yaml.safe_load(file.read_text())
    assert content["permissions"] == {"contents": "read"}
    for job in content["jobs"].values():
        assert job["timeout-minutes"] <= 90
        assert all(("run" in step) != ("uses" in step) for step in job["steps"])
    for step in steps(file):
        for name in re.findall(r"(?:^|\s)(\.ci/\S+|docs/\S+|tests/\S+)", step.get("run", "")):
            assert (ROOT / name).exists(), name


def test_actions_are_given_with_their_versions():
    used = {step["uses"] for file in WORKFLOWS for step in steps(file) if "uses" in step}
    assert all(re.fullmatch(r"[\w-]+/[\w-]+@(v\d+|release/v\d+)", name) for name in used), used
    names = [name.partition("@")[0] for name in used]
    assert len(names) == len(set(names))


def test_every_supported_python_is_tested():
    tests = jobs(ROOT / ".github/workflows/tests.yml")
    assert tests["newest"]["strategy"]["matrix"]["python"] == SUPPORTED
    assert PROJECT["requires-python"] == f">={SUPPORTED[0]}"
    found = [step.get("with", {}).get("python-version", "") for step in tests["packages"]["steps"]]
    assert sorted("\n".join(found).split()) == SUPPORTED
    assert " ".join(SUPPORTED) in (ROOT / ".ci/packages").read_text()


def test_only_the_job_that_publishes_can_prove_who_it_is():
    release = jobs(ROOT / ".github/workflows/release.yml")
    may = {name: job.get("permissions", {}) for name, job in release.items()}
    assert may == {"build": {}, "publish": {"id-token": "write"}}
    assert release["publish"]["environment"]["url"].endswith(f"/{PROJECT['name']}/")


@pytest.mark.parametrize("file", FORMS, ids=lambda file: file.stem)
def test_forms_can_be_filled_in(file):
    form = yaml.safe_load(file.read_text())
    assert form["name"]
    assert form["description"]
    names = [part["id"] for part in form["body"]]
    assert len(names) == len(set(names))
    assert all(part["attributes"]["label"] for part in form["body"])
    assert any(part.get("validations", {}).get("required") for part in form["body"])


@pytest.mark.parametrize("file", SCRIPTS, ids=lambda file: file.name)
def test_scripts_are_programs_in_order(file):
    assert os.access(file, os.X_OK)
    done = subprocess.run(["bash", "-n", file], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_forms_name_commands_and_files_of_the_repository():
    text = "\n".join(file.read_text() for file in FORMS)
    for name in re.findall(r"(?:docs|benchmarks)/[\w/.]+\.\w+", text):
        assert (ROOT / name).exists(), name
    for module in re.findall(r"python -m ([\w.]+)", text):
        folder = ROOT / module.replace(".", "/")
        assert (folder / "__main__.py").exists() or folder.with_suffix(".py").exists(), module
