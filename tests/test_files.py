"""Files are written all at once, and what cannot be written is named with a remedy."""

import errno
import os
import stat
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest
from helpers import no_larger_than

from asv_env import files


def names(folder):
    return [path.name for path in folder.iterdir()]


def test_a_file_is_replaced_all_at_once_or_not_at_all(tmp_path):
    path = tmp_path / "curve.csv"
    files.write_text(path, "old\r\n")

    def fail(part):
        part.write_text("half")
        assert path.read_bytes() == b"old\r\n"
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        files.write(path, fail)
    assert path.read_bytes() == b"old\r\n"
    assert names(tmp_path) == ["curve.csv"]


def test_the_suffix_is_kept_for_those_who_add_one(tmp_path):
    files.write(tmp_path / "7.npz", lambda part: np.savez(part, a=1))
    assert names(tmp_path) == ["7.npz"]


def test_on_a_full_disk_the_old_file_stays(tmp_path):
    path = tmp_path / "saved.npz"
    files.write_text(path, "old")
    for save in (
        lambda part: part.write_bytes(bytes(20_000)),
        lambda part: np.savez(part, a=np.zeros(5_000)),
    ):
        with (
            no_larger_than(10_000),
            pytest.raises(OSError, match=r"saved\.npz cannot be written: .*; free space") as e,
        ):
            files.write(path, save)
        assert ".part" not in str(e.value)
        assert e.value.errno == errno.EFBIG
    assert path.read_text() == "old"
    assert names(tmp_path) == ["saved.npz"]


def test_errors_of_libraries_that_follow_from_the_disk_count_as_such(tmp_path):
    def fail(part):
        try:
            raise OSError(errno.ENOSPC, "No space left on device", str(part))
        finally:
            raise RuntimeError("the writer is confused\nand says so at length")

    with pytest.raises(OSError, match=r"model\.zip cannot be written: no space left on device; "):
        files.write(tmp_path / "model.zip", fail)

    def mistaken(part):
        raise TypeError("a mistake of the program")

    with pytest.raises(TypeError, match="a mistake"):
        files.write(tmp_path / "model.zip", mistaken)
    assert names(tmp_path) == []


@pytest.mark.parametrize(
    ("name", "kind", "words"),
    [
        ("folder", IsADirectoryError, "name a file, not a folder"),
        ("file/below.txt", NotADirectoryError, "choose another place"),
        ("file/far/below.txt", NotADirectoryError, "choose another place"),
        ("x" * 300, OSError, "choose a shorter name"),
        ("loop", OSError, "remove the link"),
        ("pipe", OSError, "not a regular file"),
    ],
)
def test_what_cannot_be_a_file_is_named(name, kind, words, tmp_path):
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("precious")
    (tmp_path / "loop").symlink_to("loop")
    os.mkfifo(tmp_path / "pipe")
    before = sorted(names(tmp_path))
    with pytest.raises(kind) as error:
        files.write_text(tmp_path / name, "new")
    assert str(error.value).startswith(f"{tmp_path / name} cannot be written: ")
    assert words in str(error.value)
    assert sorted(names(tmp_path)) == before
    assert (tmp_path / "file").read_text() == "precious"


def test_a_device_is_not_replaced():
    with pytest.raises(OSError, match="/dev/null cannot be written: it is not a regular file"):
        files.write_text("/dev/null", "new")
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)


def test_permissions_are_those_of_an_ordinary_file(tmp_path):
    path, other = tmp_path / "file", tmp_path / "ordinary"
    before = os.umask(0o027)
    try:
        files.write_text(path, "new")
        other.write_text("new")
        assert path.stat().st_mode == other.stat().st_mode
        path.chmod(0o604)
        files.write_text(path, "newer")
        assert stat.S_IMODE(path.stat().st_mode) == 0o604
    finally:
        os.umask(before)


def test_file_systems_that_refuse_to_set_permissions_are_written_to(tmp_path, monkeypatch):
    def refuse(*_):
        raise PermissionError(errno.EPERM, os.strerror(errno.EPERM))

    path = tmp_path / "file"
    path.write_text("old")
    monkeypatch.setattr("pathlib.Path.chmod", refuse)
    files.write_text(path, "new")
    assert path.read_text() == "new"


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_files_and_folders_that_are_read_only_stay_as_they_are(tmp_path):
    path = tmp_path / "file"
    path.write_text("old")
    path.chmod(0o400)
    with pytest.raises(PermissionError, match=r"file cannot be written.*change its permissions"):
        files.write_text(path, "new")
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(PermissionError, match="other cannot be written"):
            files.write_text(tmp_path / "other", "new")
    finally:
        tmp_path.chmod(0o700)
    assert path.read_text() == "old"


@pytest.mark.parametrize("there", [True, False])
def test_a_link_stays_and_its_target_is_replaced(there, tmp_path):
    target, link = tmp_path / "deep/target.txt", tmp_path / "link.txt"
    if there:
        files.write_text(target, "old")
    link.symlink_to(target)
    files.write_text(link, "new")
    assert link.is_symlink()
    assert target.read_text() == "new"


def test_of_several_writers_at_once_one_wins_whole(tmp_path):
    path = tmp_path / "file"
    texts = [str(number) * 50_000 for number in range(4)]

    def often(text):
        for _ in range(20):
            files.write_text(path, text)

    threads = [threading.Thread(target=often, args=(text,)) for text in texts]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert path.read_text() in texts
    assert names(tmp_path) == ["file"]


def test_long_names_and_strange_ones_are_taken(tmp_path):
    for name in ("x" * 251 + ".npz", "." + "y" * 250, "a\nb.txt", os.fsdecode(b"\xff.txt")):
        files.write_text(tmp_path / name, f"of {name}")
        assert (tmp_path / name).read_bytes().startswith(b"of ")


def test_what_killed_runs_have_left_is_removed_and_nothing_else(tmp_path):
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait()
    own, stale = files._part_name(".npz"), f"{files.PREFIX}{files._machine()}-{dead.pid}-ab.npz"
    alive = f"{files.PREFIX}{files._machine()}-{os.getppid()}-ab.npz"
    elsewhere, forgotten = f"{files.PREFIX}ffff-1-ab.zip", f"{files.PREFIX}ffff-2-ab.zip"
    for name in (own, stale, alive, elsewhere, forgotten, "7.npz", "7.part.npz"):
        (tmp_path / name).write_text("")
    os.utime(tmp_path / forgotten, (0, 0))

    def meanwhile(part):
        part.write_text("")
        files.remove_parts(tmp_path)
        assert part.exists()

    files.write(tmp_path / "8.npz", meanwhile)
    assert set(names(tmp_path)) == {alive, elsewhere, "7.npz", "7.part.npz", "8.npz"}
    files.remove_parts(Path(tmp_path / "nowhere"))
