"""Machine code on disk: taken where it is right, made again where a source has changed."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[1] / "asv_env"
PROGRAM = """
import sys, time
sys.dont_write_bytecode = True
begun = time.perf_counter()
import asv_env
from asv_env.physics import hull
print(hull.munk_moment(2.0, 3.0, 1.0, 5.0), hull.__file__)
sim = asv_env.Simulation(asv_env.make_params("push"), 1)
sim.reset(seeds=[0])
for _ in range(50):
    sim.step([[[1.0, 0.6]] * 4])
print(sim.state.motion.tobytes().hex())
print(sum(each.stats.cache_hits.total() for each in vars(hull).values() if hasattr(each, "stats")))
"""


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
    moment, motion, hits = found.stdout.split("\n")[:3]
    moment, file = moment.split()
    assert Path(file).is_relative_to(folder)
    return float(moment), motion, int(hits)


def change(file, old, new):
    source = file.read_text()
    assert old in source
    file.write_text(source.replace(old, new))


def test_code_is_taken_from_the_cache_until_a_source_changes(installed):
    moment, motion, hits = run(installed)
    assert (moment, hits) == (-24.0, 0)
    again = run(installed)
    assert again[:2] == (moment, motion)
    assert again[2] > 0
    # ``kernel.py`` stays the same, and with it the file whose code calls this law.
    change(
        installed / "asv_env/physics/hull.py",
        "return (mass_u - mass_v) * u * v",
        "return (mass_v - mass_u) * u * v",
    )
    changed = run(installed)
    assert changed[0] == 24.0
    assert changed[1] != motion, "the loop calls the law as it is now"
    assert changed[2] == 0


def test_installation_that_cannot_be_written_to_works(installed, tmp_path):
    """Files stand where the folders of the cache would be: not even root can write there."""
    expected = run(installed)
    shutil.rmtree(installed / "asv_env/physics/__pycache__")
    for folder in (installed / "asv_env/physics/__pycache__", tmp_path / "home"):
        folder.write_text("")
    closed = {"HOME": str(tmp_path / "home"), "XDG_CACHE_HOME": str(tmp_path / "home/cache")}
    assert run(installed, **closed) == expected
    assert run(installed, **closed)[2] == 0


def test_code_is_kept_in_the_cache_of_the_user_where_the_installation_cannot_be_written_to(
    installed, tmp_path
):
    (installed / "asv_env/physics/__pycache__").write_text("")
    home = tmp_path / "home"
    home.mkdir()
    environment = {"HOME": str(home), "XDG_CACHE_HOME": str(home / "cache")}
    first = run(installed, **environment)
    second = run(installed, **environment)
    assert second[:2] == first[:2]
    assert second[2] > first[2] == 0
    assert list(home.rglob("*.nbc"))
