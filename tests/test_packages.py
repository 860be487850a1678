"""What is published has all that the packages read, and says which libraries it needs."""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
PACKAGES = ("asv_env", "baselines", "train")


def test_every_data_file_is_in_the_wheel():
    listed = {
        file
        for package, patterns in PYPROJECT["tool"]["setuptools"]["package-data"].items()
        for pattern in patterns
        for file in (ROOT / package.replace(".", "/")).glob(pattern)
    }
    there = {
        file
        for package in PACKAGES
        for file in (ROOT / package).rglob("*")
        if file.is_file() and file.suffix != ".py" and "__pycache__" not in file.parts
    }
    assert there - listed == set(), "add them to tool.setuptools.package-data"


def test_every_folder_with_modules_is_a_package():
    for package in PACKAGES:
        folders = {file.parent for file in (ROOT / package).rglob("*.py")}
        assert all((folder / "__init__.py").exists() for folder in folders)


def test_console_scripts_are_functions_of_the_packages():
    for target in PYPROJECT["project"]["scripts"].values():
        module, function = target.split(":")
        path = ROOT / module.replace(".", "/")
        source = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
        assert re.search(rf"\b{function}\b", source.read_text()), target


def test_every_library_has_a_lowest_version():
    project = PYPROJECT["project"]
    extras = [entry for entries in project["optional-dependencies"].values() for entry in entries]
    own = [e for e in (*project["dependencies"], *extras) if not e.startswith(project["name"])]
    assert all(">=" in entry for entry in own)
