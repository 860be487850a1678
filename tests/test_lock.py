"""One run at a time in a folder."""

import os
import signal
import subprocess
import sys
import threading

import pytest

from asv_env import files
from baselines.rollout import lock as locks
from baselines.rollout.lock import NAME, lock, locked

HOLD = """
import sys, time
from pathlib import Path
from baselines.rollout.lock import lock
taken = lock(Path(sys.argv[1]))
print("taken", flush=True)
time.sleep(60)
"""
IN_USE = "run is in use by another run: wait for it, or choose another folder with --out"


def test_the_second_is_refused_at_once_and_the_folder_is_given_back(tmp_path):
    folder = tmp_path / "deep/run"
    with locked(folder), pytest.raises(FileExistsError, match=IN_USE):
        lock(folder)
    with locked(folder):
        pass
    assert os.listdir(folder) == [NAME]


def test_what_killed_runs_have_left_half_written_is_removed(tmp_path):
    with subprocess.Popen(["true"]) as gone:
        pass
    for name in (f"{files.PREFIX}{files._machine()}-{gone.pid}-1234.npz", "kept.npz"):
        (tmp_path / name).write_text("half")
    with locked(tmp_path):
        assert sorted(os.listdir(tmp_path)) == [NAME, "kept.npz"]


def test_what_cannot_be_removed_leaves_the_folder_free(tmp_path, monkeypatch):
    def refuse(_):
        raise PermissionError("not yours")

    monkeypatch.setattr(locks, "remove_parts", refuse)
    with pytest.raises(PermissionError, match="not yours"):
        lock(tmp_path)
    monkeypatch.undo()
    lock(tmp_path).release()


def test_threads_of_one_process_are_two_runs(tmp_path):
    folder, said = tmp_path / "run", []

    def second():
        try:
            lock(folder)
        except FileExistsError as error:
            said.append(str(error))

    taken = lock(folder)
    thread = threading.Thread(target=second)
    thread.start()
    thread.join()
    assert said == [f"{tmp_path}/{IN_USE}"]
    thread = threading.Thread(target=taken.release)  # another thread may give it back
    thread.start()
    thread.join()
    lock(folder).release()


def test_other_names_of_a_folder_are_the_same_folder(tmp_path):
    folder = tmp_path / "run"
    with locked(folder):
        (tmp_path / "link").symlink_to("run")
        with pytest.raises(FileExistsError, match="in use"):
            lock(tmp_path / "link")
        with pytest.raises(FileExistsError, match="in use"):
            lock(folder / ".." / "run")


def test_a_process_that_is_killed_gives_it_back(tmp_path):
    command = [sys.executable, "-c", HOLD, str(tmp_path / "run")]
    process = subprocess.Popen(command, stdout=subprocess.PIPE)
    try:
        assert process.stdout.readline() == b"taken\n"
        with pytest.raises(FileExistsError, match=IN_USE):
            lock(tmp_path / "run")
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
        process.stdout.close()
    lock(tmp_path / "run").release()


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("file", "file cannot be used: .*; choose another place"),
        ("file/below", "file/below cannot be used: not a directory; choose another place"),
        ("taken", r"taken/\.lock cannot be locked: is a directory"),
        ("linked", r"linked/\.lock cannot be locked: too many .*; remove the link"),
    ],
)
def test_where_no_lock_can_be_is_named(name, words, tmp_path):
    (tmp_path / "file").write_text("precious")
    (tmp_path / "taken" / NAME).mkdir(parents=True)
    (tmp_path / "linked").mkdir()
    (tmp_path / "linked" / NAME).symlink_to(tmp_path / "file")
    with pytest.raises(OSError, match=words):
        lock(tmp_path / name)
    assert (tmp_path / "file").read_text() == "precious"


@pytest.mark.parametrize(
    ("failure", "words"),
    [
        (OSError(37, "No locks available"), "no locks available; choose another place"),
        (OSError(30, "Read-only file system"), "read-only file system; choose another place"),
        (NotImplementedError("flock"), "its file system knows no locks; choose another folder"),
    ],
)
def test_file_systems_without_locks_are_named(failure, words, tmp_path, monkeypatch):
    def fails(self):
        raise failure

    monkeypatch.setattr(locks.FileLock, "acquire", fails)
    with pytest.raises(OSError, match=rf"\.lock cannot be locked: {words}"):
        lock(tmp_path)
