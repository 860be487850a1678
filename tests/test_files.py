"""Files are written all at once."""

import numpy as np
import pytest

from baselines.rollout import files


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
    assert list(tmp_path.iterdir()) == [path]


def test_the_suffix_is_kept_for_those_who_add_one(tmp_path):
    files.write(tmp_path / "7.npz", lambda part: np.savez(part, a=1))
    assert [path.name for path in tmp_path.iterdir()] == ["7.npz"]


def test_what_killed_runs_have_left_is_removed(tmp_path):
    for name in ("7.1234.part.npz", "7.npz"):
        (tmp_path / name).write_text("")
    files.remove_parts(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["7.npz"]
