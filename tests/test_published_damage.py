"""Published files that are damaged are named, and nothing is written then."""

import json
import shutil

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_merge import SUITE, write_run

from baselines.evaluate.publish import merge, pages, summaries
from baselines.evaluate.results import read_csv
from baselines.rollout.lock import locked


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Two runs of a suite of this name, of policies that cost nothing."""
    folder = tmp_path_factory.mktemp("made")
    write_run(folder / "published", "idle", 2)
    write_run(folder / "run", "random", 2)
    return folder


@pytest.fixture
def folder(made, tmp_path, monkeypatch):
    for module in (merge, pages):
        monkeypatch.setattr(module, "SUITES", {SUITE.name: SUITE})
    shutil.copytree(made, tmp_path / "here")
    return tmp_path / "here"


def merged(folder, *more):
    merge.main([str(folder / "run"), str(folder / "published"), *map(str, more)])


def refused(folder, *more):
    """The line with which merging is refused; what is published stays as it is."""
    before = {path: path.read_bytes() for path in (folder / "published").iterdir()}
    with pytest.raises(SystemExit) as stopped:
        merged(folder, *more)
    after = {path: path.read_bytes() for path in (folder / "published").iterdir()}
    after.pop(folder / "published/.lock", None)
    before.pop(folder / "published/.lock", None)
    assert after == before
    assert "\n" not in str(stopped.value)
    return str(stopped.value)


@settings(max_examples=40)
@given(data=st.data())
def test_rows_are_read_or_their_file_is_named(data, made, tmp_path_factory):
    old = (made / "published/episodes.csv").read_bytes()
    at = data.draw(st.integers(0, len(old) - 1))
    new = data.draw(
        st.sampled_from(
            [b"", b"\0", b"\xff", b'"', b",", b"\n", b"\r", b"nan", b"1e999", b"9" * 30]
        )
    )
    rest = old[at + 1 :] if data.draw(st.booleans()) else b""
    file = tmp_path_factory.mktemp("rows") / "episodes.csv"
    file.write_bytes(old[:at] + new + rest)
    try:
        rows = read_csv(file)
    except ValueError as error:
        said = str(error)
        assert said.startswith(f"{file} is damaged, or holds no episodes: ")
    else:
        assert all(isinstance(row.seed, int) and isinstance(row.success, bool) for row in rows)


@pytest.mark.parametrize("where", ["run", "published"])
@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        "[1]",
        "null",
        "\xff",
        '{"suite": 1}',
        "[" * 100_000,
        '{"suite": "x", "episodes": 2}',
    ],
)
def test_a_damaged_summary_is_named(where, text, folder):
    (folder / where / "summary.json").write_bytes(text.encode("latin-1"))
    assert f"{where}/summary.json is " in refused(folder)


@pytest.mark.parametrize("name", ["policies", "conditions", "provenance"])
def test_a_summary_whose_fields_are_of_other_types_is_named(name, folder):
    file = folder / "published/summary.json"
    summary = json.loads(file.read_text())
    file.write_text(json.dumps({**summary, name: []}))
    assert f"summary.json is no summary of a run, its {name!r} is not one" in refused(folder)


def test_a_summary_does_not_name_a_module_to_be_imported(folder):
    file = folder / "published/summary.json"
    for where in ("run", "published"):
        file = folder / where / "summary.json"
        summary = json.loads(file.read_text())
        summary["suite"] = summary["provenance"]["suite"] = "os:environ"
        file.write_text(json.dumps(summary))
    assert "unknown suite 'os:environ'" in refused(folder)


def test_numbers_that_make_no_sense_are_refused(folder):
    for number in (0, -1):
        assert f"--checked {number}: must be at least 1" in refused(folder, "--checked", number)


def test_a_folder_in_use_is_refused_and_one_without_results_is_left_alone(folder):
    with locked(folder / "published"):
        assert "published is in use by another run" in refused(folder)
    shutil.rmtree(folder / "run")
    assert "run/summary.json" in refused(folder)
    assert not (folder / "run").exists()


def publish(folder):
    """Makes one of the runs the published results of its suite."""
    shutil.rmtree(folder / "run")
    (folder / "published").rename(folder / SUITE.name)


def test_a_report_that_a_summary_does_not_fit_names_it(folder):
    page = folder / "page.md"
    page.write_text(f"{pages.START}\n{pages.END}\n")
    publish(folder)
    file = folder / SUITE.name / "summary.json"
    summary = json.loads(file.read_text())
    file.write_text(json.dumps({**summary, "conditions": {"nominal": {}}}))
    with pytest.raises(SystemExit, match=r"summary\.json does not fit its episodes"):
        pages.main(["--results", str(folder), "--page", str(page)])
    assert page.read_text() == f"{pages.START}\n{pages.END}\n"
    with pytest.raises(ValueError, match="does not fit"):
        summaries.markdown(file, None, {})


@pytest.mark.parametrize("content", [b"\xff\xfe", b"no marks"])
def test_a_page_that_cannot_be_used_is_named(content, folder):
    publish(folder)
    page = folder / "page.md"
    page.write_bytes(content)
    with pytest.raises(SystemExit, match=r"page\.md"):
        pages.main(["--results", str(folder), "--page", str(page)])
    assert page.read_bytes() == content
