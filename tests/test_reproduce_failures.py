"""Reproduction: full disks, damaged files, a second run, and settings of the user."""

import inspect
import json
import shutil

import matplotlib
import numpy as np
import pytest
from helpers import no_larger_than
from test_reproduce import JOB, ONLY, contents_of, refusal, run

from baselines.evaluate.publish import marks
from baselines.reproduce import contents, paper_page
from baselines.reproduce.artefact import OutputFolder
from baselines.rollout import provenance
from baselines.rollout.lock import locked


@pytest.fixture(scope="module", autouse=True)
def steady_code():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(provenance, "code", lambda *modules: "this")
        yield


@pytest.fixture(scope="module")
def made(tmp_path_factory, steady_code):
    folder = tmp_path_factory.mktemp("reproduce")
    run(*ONLY, "--out", folder)
    return folder


@pytest.fixture
def folder(made, tmp_path):
    shutil.copytree(made, tmp_path / "here")
    return tmp_path / "here"


def test_pictures_do_not_depend_on_the_users_settings(made, tmp_path):
    """Not on matplotlibrc, styles, NumPy's error state or its print options."""
    settings = {
        "font.size": 30.0,
        "figure.facecolor": "red",
        "lines.linewidth": 9.0,
        "axes.grid": True,
        "savefig.transparent": True,
        "savefig.facecolor": "blue",
        "image.cmap": "jet",
        "axes.prop_cycle": matplotlib.cycler(color=["pink"]),
        "text.usetex": True,
        "path.sketch": (1, 100, 2),
    }
    with matplotlib.rc_context(settings), np.errstate(all="raise"):
        run(*ONLY, "--out", tmp_path)
        assert matplotlib.rcParams["font.size"] == 30.0
        assert np.geterr()["over"] == "raise"
    for name, content in contents_of(made).items():
        assert content == (tmp_path / name).read_bytes(), name


def test_a_folder_in_use_is_refused(folder, capsys):
    before = contents_of(folder)
    with locked(folder):
        message = refusal(capsys, *ONLY, "--seed", 1, "--overwrite", "--out", folder)
    assert "here is in use by another run" in message
    assert contents_of(folder) == before


def test_a_folder_that_is_refused_gets_no_lock(tmp_path, capsys):
    (tmp_path / "fig3.png").write_text("mine")
    assert "--overwrite" in refusal(capsys, *ONLY, "--out", tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["fig3.png"]


def test_on_a_full_disk_the_old_files_stay_and_the_command_continues(folder, capsys):
    before = contents_of(folder)
    with no_larger_than(5_000):
        message = refusal(capsys, *ONLY, "--seed", 1, "--overwrite", "--out", folder)
    assert "fig3.png cannot be written: file too large; free space and give the same" in message
    after = contents_of(folder)
    assert {name: after[name] for name in before if name != "record.json"} == {
        name: before[name] for name in before if name != "record.json"
    }
    run(*ONLY, "--seed", 1, "--overwrite", "--out", folder)
    assert json.loads((folder / "record.json").read_text())["fig3"]["complete"]


@pytest.mark.parametrize(
    "text", ["", "{", "[]", '{"fig3": 1}', '{"fig3": {"complete": true}}', "[" * 100_000, "\xff"]
)
def test_a_damaged_record_is_named_and_replaced_when_asked(text, folder, capsys):
    (folder / "record.json").write_bytes(text.encode("latin-1"))
    message = refusal(capsys, "--only", "fig3", "--out", folder)
    assert "record.json is" in message
    assert "remove it, or begin again with --overwrite" in message
    if text in ("{", "[]"):
        run("--only", "fig3", "--overwrite", "--out", folder)
        assert json.loads((folder / "record.json").read_text())["fig3"]["complete"]


@pytest.mark.parametrize("text", ["", "{", "null"])
def test_a_damaged_study_counts_as_none_and_is_named_where_it_is_needed(text, tmp_path):
    folder = OutputFolder(tmp_path, JOB)
    study, table = (contents.ARTEFACTS[name] for name in ("trials", "table"))
    (tmp_path / "trials.json").write_text('{"paper": {}}')
    folder.record("trials", complete=True)
    assert folder.holds("trials", study)
    (tmp_path / "trials.json").write_text(text)
    assert not folder.holds("trials", study)
    if text != "null":
        with pytest.raises(ValueError, match=r"trials\.json is damaged .*: remove it, or begin"):
            table.build("table", JOB, tmp_path)


@pytest.mark.parametrize("content", [b"\xff", b"no marks"])
def test_a_page_that_cannot_be_used_is_refused_before_anything_is_made(content, tmp_path, capsys):
    (tmp_path / "page.md").write_bytes(content)
    message = refusal(capsys, "--page", tmp_path / "page.md", "--out", tmp_path / "out")
    assert "page" in message
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", ["", "/dev/null", "file", "file/below"])
def test_folders_that_cannot_be_are_refused_in_one_line(name, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("precious")
    (tmp_path / "README.md").write_text("precious")
    with pytest.raises(SystemExit) as stopped:
        run("--only", "fig3", "--out", name)
    assert stopped.value.code == 2 or "\n" not in str(stopped.value)
    assert (tmp_path / "file").read_text() == "precious"


def test_a_home_folder_is_expanded_and_nothing_is_made_of_nothing(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("HOME", str(tmp_path))
    assert "name one at least" in refusal(capsys, "--only", "--out", "~/none")
    run("--only", "fig3", "--out", "~/runs")
    assert (tmp_path / "runs/fig3.png").exists()
    assert not (tmp_path / "none").exists()


def test_captions_do_not_depend_on_docstrings_that_are_kept(monkeypatch):
    """``python -OO`` drops them."""
    figure = contents.ARTEFACTS["fig3"]
    caption = figure.caption
    assert caption == inspect.getdoc(figure.make)
    monkeypatch.setattr(figure.make, "__doc__", None)
    assert figure.caption == caption


def test_the_marks_name_what_they_need():
    with pytest.raises(ValueError, match="once each"):
        marks.check("", *paper_page.borders("trials"))
