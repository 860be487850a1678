"""The database of episodes: what is damaged is named and can be replaced."""

import json
import shutil
import sqlite3
from dataclasses import replace

import numpy as np
import pytest
from helpers import no_larger_than
from hypothesis import given, settings
from hypothesis import strategies as st

from asv_env import make_params
from baselines.evaluate.store import NAME, DamagedError, RunKey, Store
from baselines.rollout import runner
from baselines.rollout.episodes import Label
from baselines.scripted.scripted_policy import ScriptedPolicy

KEY = RunKey("brief", "mine", 0)
PROVENANCE = {"suite": "one", "state of the code": "this"}
SEEDS = range(8)


def opened(folder, overwrite=False):
    return Store(folder, PROVENANCE, {"mine": ["scripted"]}, overwrite)


@pytest.fixture(scope="module")
def logs():
    params = make_params("push", time_limit=2.0)
    return list(runner.run(ScriptedPolicy, params, SEEDS, 8, Label("mine", None, "brief")))


@pytest.fixture(scope="module")
def good(tmp_path_factory, logs):
    folder = tmp_path_factory.mktemp("store")
    store = opened(folder)
    for log in logs:
        store.add(KEY, log)
    store.close()
    return folder / NAME


def content(store):
    """All that a database gives: rows, and bytes of poses."""
    rows = list(store.rows(KEY, SEEDS))
    assert [row.seed for row in rows] == sorted(store.seeds(KEY))
    return [(row, store.log(KEY, row.seed).poses.tobytes()) for row in rows]


@pytest.fixture(scope="module")
def wanted(good, tmp_path_factory):
    folder = tmp_path_factory.mktemp("copy")
    shutil.copy(good, folder)
    store = opened(folder)
    found = content(store)
    store.close()
    assert len(found) == len(SEEDS)
    return found


@settings(max_examples=30)
@given(data=st.data())
def test_a_damaged_database_gives_what_was_stored_or_is_refused(
    data, good, wanted, tmp_path_factory
):
    """Cut, zeroed or changed anywhere; what is missing is run again, what is there is right."""
    old = good.read_bytes()
    at = data.draw(st.integers(0, len(old) - 1))
    kind = data.draw(st.sampled_from(["cut", "zero", "flip"]))
    length = data.draw(st.integers(1, len(old) - at))
    changed = {
        "cut": old[:at],
        "zero": old[:at] + bytes(length) + old[at + length :],
        "flip": old[:at] + bytes([old[at] ^ data.draw(st.integers(1, 255))]) + old[at + 1 :],
    }[kind]
    folder = tmp_path_factory.mktemp("damaged")
    (folder / NAME).write_bytes(changed)
    try:
        store = opened(folder)
    except (DamagedError, FileExistsError) as error:
        said = str(error)
        assert NAME in said or "holds episodes of another" in said
        assert "--overwrite" in said
    else:
        found = content(store)
        store.close()
        assert all(one in wanted for one in found)
    store = opened(folder, overwrite=True)  # which always works
    store.close()
    opened(folder).close()
    shutil.rmtree(folder)


def changes(*statements):
    def change(file):
        with sqlite3.connect(file) as base:
            for statement in statements:
                base.execute(statement)

    return change


@pytest.mark.parametrize(
    "damage",
    [
        lambda file: file.write_bytes(b"SQLite format 3\0" + bytes(4080)),
        lambda file: file.write_bytes(b"precious notes, no database at all\n" * 200),
        lambda file: (file.unlink(), file.mkdir()),
        lambda file: (file.unlink(), file.symlink_to("nowhere")),
        changes("UPDATE episode SET row = '{'"),
        changes("UPDATE episode SET log = x'00'"),
        changes("UPDATE episode SET log = ''"),
        changes("UPDATE episode SET log = 7"),
        changes("UPDATE episode SET seed = 'five' WHERE seed = 5"),
        changes("DROP TABLE episode", "CREATE TABLE episode (a)", "INSERT INTO episode VALUES (1)"),
        changes("DROP TABLE provenance", "CREATE TABLE provenance (name)"),
    ],
)
def test_what_is_no_database_is_named_and_replaced_when_asked(damage, good, tmp_path):
    shutil.copy(good, tmp_path)
    damage(tmp_path / NAME)
    with pytest.raises(DamagedError, match=rf"{NAME}.*remove it, or begin again with --overwrite"):
        opened(tmp_path)
    store = opened(tmp_path, overwrite=True)
    assert store.seeds(KEY) == set()
    store.close()


@pytest.mark.parametrize("layout", [None, "3"])
def test_a_database_of_another_layout_is_refused(layout, good, tmp_path):
    shutil.copy(good, tmp_path)
    value = (
        "DELETE FROM provenance" if layout is None else f"UPDATE provenance SET value='{layout}'"
    )
    changes(f"{value} WHERE name = 'layout'")(tmp_path / NAME)
    with pytest.raises(FileExistsError, match=r"another layout .*--overwrite"):
        opened(tmp_path)
    opened(tmp_path, overwrite=True).close()


@pytest.mark.parametrize("suffix", ["-journal", "-wal", "-shm"])
def test_what_others_have_left_beside_it_changes_nothing(suffix, good, wanted, tmp_path):
    shutil.copy(good, tmp_path)
    (tmp_path / f"{NAME}{suffix}").write_bytes(b"\xd9\xd5\x05\xf9\x20\xa1\x63\xd7" + bytes(1000))
    store = opened(tmp_path)
    assert content(store) == wanted
    store.close()


def test_replacing_a_damaged_database_removes_its_trajectories(good, tmp_path):
    (tmp_path / NAME).write_bytes(good.read_bytes()[:5000])
    old = tmp_path / "trajectories/brief/other[1]"
    old.mkdir(parents=True)
    store = opened(tmp_path, overwrite=True)
    assert store.dropped == ("other[1]",)
    store.close()


def test_a_full_disk_is_named_and_what_is_finished_is_kept(logs, tmp_path):
    store = opened(tmp_path)
    store.add(KEY, logs[0])
    size = (tmp_path / NAME).stat().st_size
    big = replace(logs[1], poses=np.random.default_rng(0).uniform(-1, 1, (9000, 5, 3)))
    with (
        no_larger_than(size),
        pytest.raises(OSError, match=rf"{NAME} cannot be written: .*give the same command"),
    ):
        store.add(KEY, big)
    store.close()
    store = opened(tmp_path)
    assert store.seeds(KEY) == {logs[0].episode.seed}
    store.close()


def test_the_provenance_is_text(good):
    with sqlite3.connect(good) as base:
        found = dict(base.execute("SELECT * FROM provenance"))
    assert {name: json.loads(value) for name, value in found.items()} == {
        **PROVENANCE,
        "layout": 5,
        "policy mine": ["scripted"],
    }
