"""``python -m train.curves``: what it draws of runs."""

import csv
import shutil

import matplotlib
import numpy as np
import pytest
from helpers import no_larger_than

from train import curves

COLUMNS = ("timesteps", "seconds", "num_boats", "scenario", "episodes", "success", "median_time")
ERRORS = ("position_error", "heading_error", "penalised_time")


@pytest.fixture
def runs(tmp_path):
    """Two runs that were evaluated at 0, 2 and 4, one of them at 1 and 3 too."""
    folders = []
    for name, times in (("one", (0, 1, 2, 3, 4)), ("two", (0, 2, 4))):
        folders.append(tmp_path / name)
        folders[-1].mkdir()
        with (folders[-1] / "curve.csv").open("w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow((*COLUMNS, *ERRORS))
            for at in times:
                writer.writerow((at, 60 * at, 4, "noisy", 10, 0.2 * at, 50 - at, 0.01, 0.1, 60))
                writer.writerow((at, 60 * at, 4, "nominal", 10, 0.0, "nan", "nan", "nan", 120))
    return folders


def test_runs_are_put_together_where_all_were_evaluated(runs):
    curve = curves.read(runs, 4, "noisy")
    assert curve.minutes.tolist() == [0, 2, 4]
    np.testing.assert_allclose(curve.success, [[0, 0.4, 0.8]] * 2)
    assert curve.time.tolist() == [[50, 48, 46]] * 2
    assert curve.episodes == 10


def test_the_band_is_students_interval_of_the_mean():
    low, high = curves.band(np.array([[1.0], [2.0], [3.0]]))
    half = 4.302653 / np.sqrt(3)  # a table's quantile at two degrees of freedom
    np.testing.assert_allclose([low, high], [[2 - half], [2 + half]], rtol=1e-6)


def test_a_picture_is_drawn(runs, tmp_path):
    file = tmp_path / "curves.svg"
    curves.main([f"both={runs[0]},{runs[1]}", f"first={runs[0]}", "--out", str(file)])
    assert file.read_text().count('<g id="axes_') == 2


@pytest.mark.parametrize("words", ["\udcff", "a\nb", "$x^{", "\x1b[1m", "船 🚤", "x" * 5000])
@pytest.mark.filterwarnings("ignore:Glyph")
def test_names_and_titles_may_hold_anything(words, runs, tmp_path):
    file = str(tmp_path / "curves.svg")
    curves.main([f"{words}={runs[0]},{runs[1]}", "--out", file, "--title", words])


def test_a_home_folder_is_expanded_where_shells_leave_it(runs, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    curves.main(["both=~/one,~/two", "--out=~/curves.svg"])
    assert (tmp_path / "curves.svg").exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["a=nowhere", "--out", "x.png"], "nowhere/curve.csv does not exist"),
        (["a=one", "--out", "x.png", "--num-boats", "6"], "no evaluations with 6 boats"),
        (["a=one", "--out", "x.doc"], "unknown kind of picture '.doc'"),
        (["a=one", "--out", "x"], "unknown kind of picture"),
        (["a=one", "a=two", "--out", "x.png"], "name each curve once"),
        (["one"] * 7 + ["--out", "x.png"], "7 curves: 1 to 6"),
    ],
)
def test_what_cannot_be_drawn_is_named(words, message, runs, monkeypatch):
    monkeypatch.chdir(runs[0].parent)
    with pytest.raises(SystemExit, match=message):
        curves.main(words)


@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_a_picture_follows_from_its_runs_alone(suffix, runs, tmp_path):
    """Not from settings of the user, nor from the time."""
    words = [f"$both={runs[0]},{runs[1]}", "--title", "a $ sign", "--out"]
    curves.main([*words, str(tmp_path / f"plain.{suffix}")])
    with matplotlib.rc_context({"font.size": 30, "figure.facecolor": "red", "savefig.dpi": 10}):
        curves.main([*words, str(tmp_path / f"other.{suffix}")])
    pictures = [(tmp_path / f"{name}.{suffix}").read_bytes() for name in ("plain", "other")]
    assert pictures[0] == pictures[1]


def test_a_folder_with_an_equals_sign_is_a_run(runs, tmp_path):
    shutil.copytree(runs[0], tmp_path / "lr=0.1,b")
    file = tmp_path / "deep/curves.svg"
    curves.main([str(tmp_path / "lr=0.1,b"), f"x={tmp_path / 'lr=0.1,b'}", "--out", str(file)])
    assert file.exists()


def test_on_a_full_disk_the_old_picture_stays(runs, tmp_path):
    file = tmp_path / "curves.png"
    file.write_text("old")
    with no_larger_than(1000), pytest.raises(SystemExit, match=r"curves\.png cannot be .*free sp"):
        curves.main([str(runs[0]), "--out", str(file)])
    assert file.read_text() == "old"
