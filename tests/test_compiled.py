"""Machine code on disk: taken where it is right, made again where a source has changed."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[1] / "asv_env"
PROGRAM = """
import sys
sys.dont_write_bytecode = True
from asv_env.physics import hull
hulls = hull.hulls(1, 1)
moved = hull.resisted(0.1, 0.2, 0.3, (0.0, 0.5, 1.0), hulls, 0, 0, (1.0, 1.0))
print(hull.__file__)
print(*moved)
print(hull.resisted.stats.cache_hits.total())
"""
"""One law, which calls another of ``water.py``: to compile a whole step takes half a minute."""


@pytest.fixture
def installed(tmp_path):
    """A folder with a copy of the package that has not been compiled."""
    ignored = shutil.ignore_patterns("__pycache__", "*.nbi", "*.nbc")
    shutil.copytree(PACKAGE, tmp_path / "site" / "asv_env", ignore=ignored)
    return tmp_path / "site"


def run(folder, **environment):
    """Lines that the program prints with the package in a folder."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
    found = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        env={**kept, "PYTHONPATH": str(folder), **environment},
        capture_output=True,
        text=True,
        cwd=folder,
    )
    assert not found.returncode, found.stderr
    file, moved, hits = found.stdout.split("\n")[:3]
    assert Path(file).is_relative_to(folder)
    return moved, int(hits)


def change(file, old, new):
    source = file.read_text()
    assert old in source
    file.write_text(source.replace(old, new))


def test_code_is_taken_from_the_cache_until_a_source_changes(installed):
    moved, hits = run(installed)
    assert hits == 0
    assert run(installed) == (moved, 1)
    # ``hull.py`` stays the same, and with it the file whose code calls this law.
    change(installed / "asv_env/physics/water.py", "soft * speed +", "2 * soft * speed +")
    changed = run(installed)
    assert changed[0] != moved, "the law is called as it is now"
    assert changed[1] == 0


def test_installation_that_cannot_be_written_to_works(installed, tmp_path):
    """Files stand where the folders of the cache would be: not even root can write there."""
    expected = run(installed)
    shutil.rmtree(installed / "asv_env/physics/__pycache__")
    for folder in (installed / "asv_env/physics/__pycache__", tmp_path / "home"):
        folder.write_text("")
    closed = {"HOME": str(tmp_path / "home"), "XDG_CACHE_HOME": str(tmp_path / "home/cache")}
    assert run(installed, **closed) == expected


def test_code_is_kept_in_the_cache_of_the_user_where_the_installation_cannot_be_written_to(
    installed, tmp_path
):
    (installed / "asv_env/physics/__pycache__").write_text("")
    home = tmp_path / "home"
    home.mkdir()
    environment = {"HOME": str(home), "XDG_CACHE_HOME": str(home / "cache")}
    first = run(installed, **environment)
    second = run(installed, **environment)
    assert (first[1], second) == (0, (first[0], 1))
    assert list(home.rglob("*.nbc"))
