"""``python -m asv_env``, and what the package imports."""

from __future__ import annotations

import importlib
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import imageio.v3 as imageio
import pettingzoo
import pytest
from helpers import no_larger_than

import asv_env
from asv_env.__main__ import LIBRARIES, main


def test_the_report_names_all_there_is(capsys: pytest.CaptureFixture[str]) -> None:
    main([])
    report = capsys.readouterr().out
    for name in ("pymunk", asv_env.__version__, "asv_env/Push-v0"):
        assert name in report
    for name in (*asv_env.SCENARIOS, *asv_env.PRESETS, *asv_env.DIFFICULTIES):
        assert name in report


def test_the_report_lists_all_that_the_extras_install() -> None:
    project = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text())["project"]
    extras = {"": project["dependencies"], **project["optional-dependencies"]}
    extras.pop("dev")
    installed = {re.match(r"[\w-]+", one)[0] for some in extras.values() for one in some}
    assert {name for some in LIBRARIES.values() for name in some} == {"asv-env", *installed}
    for requirement in (one for some in extras.values() for one in some):
        assert re.search(r">=\d", requirement), f"{requirement} states no lowest version"


def test_without_its_registry_pettingzoo_is_listed_as_too_old(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delattr(pettingzoo, "make", raising=False)
    monkeypatch.delattr(pettingzoo, "parallel_registry", raising=False)
    monkeypatch.delattr(pettingzoo, "register", raising=False)
    importlib.reload(asv_env)
    main([])
    assert "needs pettingzoo 1.27" in capsys.readouterr().out


def test_a_picture_in_the_home_folder_and_one_of_a_name_that_cannot_be(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    main(["--picture=~/start.png", "--task", "push"])
    assert (tmp_path / "start.png").is_file()
    with pytest.raises(SystemExit, match="cannot be written: file name too long; choose a shorter"):
        main(["--picture", f"{'y' * 300}.png"])


def test_a_picture_is_written_and_never_overwritten_unasked(tmp_path: Path) -> None:
    path = tmp_path / "start.png"
    main(["--picture", str(path), "--task", "push"])
    assert imageio.imread(path).shape[2] == 3
    written = path.read_bytes()
    with pytest.raises(SystemExit, match="--overwrite"):
        main(["--picture", str(path)])
    assert path.read_bytes() == written
    main(["--picture", str(path), "--overwrite", "--scenario", "gyre"])
    assert path.read_bytes() != written
    with pytest.raises(SystemExit, match="'push'"):
        main(["--picture", str(tmp_path / "other.png"), "--task", "puhs"])


def test_the_package_needs_no_extra() -> None:
    code = "import sys, asv_env; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    extras = {"torch", "stable_baselines3", "pygame", "imageio", "matplotlib"}
    assert not extras & set(done.stdout.split())


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("start.doc", "unknown kind of picture '.doc'"),
        ("start", "unknown kind of picture ''"),
        ("file/start.png", "file/start.png cannot be written: not a directory"),
        ("folder.png", "name a file, not a folder"),
    ],
)
def test_a_picture_that_cannot_be_is_refused_in_one_line(
    name: str, words: str, tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("precious")
    (tmp_path / "folder.png").mkdir()
    with pytest.raises(SystemExit, match=words) as stopped:
        main(["--picture", str(tmp_path / name), "--overwrite"])
    assert "\n" not in str(stopped.value)


def test_on_a_full_disk_the_old_picture_stays(tmp_path: Path) -> None:
    path = tmp_path / "start.png"
    path.write_text("old")
    with no_larger_than(1000), pytest.raises(SystemExit, match=r"start\.png cannot .*free space"):
        main(["--picture", str(path), "--overwrite"])
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]
