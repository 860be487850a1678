"""What all commands do with their paths and with a reader who is gone."""

import signal
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

from baselines.evaluate import command as evaluate
from baselines.rollout.commands import FilePath, command, steady, unbroken
from baselines.rollout.process_state import Terminated

PRINTS = """
from baselines.rollout.commands import command

def much() -> None:
    for _ in range(100_000):
        print("x" * 80)

command(much, "much")()
"""


def test_a_command_whose_reader_is_gone_ends_without_a_word():
    with subprocess.Popen(
        [sys.executable, "-c", PRINTS], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout.readline().startswith("x")
        process.stdout.close()
        assert process.stderr.read() == ""
        assert process.wait(60) == 1


@pytest.mark.filterwarnings("error")
def test_warnings_that_are_errors_do_not_end_a_command():
    done = []

    def warn() -> None:
        warnings.warn("Glyph missing", stacklevel=1)
        done.append(True)

    with pytest.warns(UserWarning, match="Glyph"):
        command(warn, "warn")([])
    assert done


@pytest.mark.parametrize(
    ("given", "wanted"),
    [("~", ""), ("~/a b", "a b"), ("~/ü/x", "ü/x"), ("a~", "a~"), ("~nobody-here/x", None)],
)
def test_paths_begin_in_the_home_folder_where_shells_leave_it(given, wanted, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    found = []

    def keep(out: FilePath, page: FilePath | None = None) -> None:
        found.extend([out, page])

    command(keep, "keep")([f"--out={given}", f"--page={given}"])
    expected = tmp_path / wanted if given.startswith("~/") or given == "~" else Path(given)
    assert found == [expected, expected]


def test_a_film_in_the_home_folder_is_not_replaced_unasked(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("HOME", str(tmp_path))
    (tmp_path / "film.gif").write_text("precious")
    with pytest.raises(SystemExit):
        evaluate.main(["--video=~/film.gif", "--out", str(tmp_path / "run"), "--episodes", "1"])
    assert "film.gif exists" in capsys.readouterr().err
    assert (tmp_path / "film.gif").read_text() == "precious"


@pytest.mark.parametrize(
    ("number", "error"), [(signal.SIGTERM, Terminated), (signal.SIGINT, KeyboardInterrupt)]
)
def test_a_signal_ends_a_command_after_a_block_that_is_not_to_be_broken(number, error):
    reached = []

    def work() -> None:
        with steady(), unbroken():
            signal.raise_signal(number)
            reached.append("the end of the block")

    with pytest.raises(error):
        work()
    assert reached
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
