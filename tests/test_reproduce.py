"""The paper's figures and table: files, statistics, and that drawings show the code's geometry."""

import json
from pathlib import Path

import numpy as np
import pytest

from baselines.evaluate import statistics
from baselines.paper.paper_numbers import ARRIVAL_TIME, GAINS, IN_RANGE
from baselines.reproduce import __main__ as command
from baselines.reproduce import (
    artefact,
    comparison_rows,
    contents,
    fig1_2_definitions,
    fig3_4_approach,
    fig5_paths,
    fig10_trials,
    paper_page,
    planner_comparison,
    single_runs,
)
from baselines.reproduce.artefact import Job
from baselines.rollout import provenance

JOB = Job(seed=0, trials=3, episodes=4)
ONLY = ["--only", "fig3", "fig5"]
FILES = ["fig3.pdf", "fig3.png", "fig5.pdf", "fig5.png"]


def run(*arguments):
    command.main([str(argument) for argument in arguments])


def refusal(capsys, *arguments):
    """What the command says where it refuses its arguments, in one line."""
    with pytest.raises(SystemExit) as stopped:
        run(*arguments)
    return " ".join(f"{stopped.value} {capsys.readouterr().err}".replace("│", " ").split())


def contents_of(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.name != ".lock"}


@pytest.fixture(scope="module", autouse=True)
def steady_code():
    """The source may be edited while the tests run."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(provenance, "code", lambda *modules: "this")
        yield


@pytest.fixture(scope="module")
def made(tmp_path_factory, steady_code):
    folder = tmp_path_factory.mktemp("reproduce")
    run(*ONLY, "--out", folder)
    return folder


def test_figures_are_written_as_picture_and_as_drawing(made):
    assert sorted(contents_of(made)) == ["README.md", *FILES, "record.json"]
    png, pdf = (made / "fig3.png").read_bytes(), (made / "fig3.pdf").read_bytes()
    assert png.startswith(b"\x89PNG")
    per_metre = int.from_bytes(png[png.index(b"pHYs") + 4 :][:4], "big")
    assert per_metre == pytest.approx(200 / 0.0254, abs=1)
    assert int.from_bytes(png[16:20], "big") <= 180 / 25.4 * 200
    assert b"/CIDFontType2" in pdf  # TrueType: text stays text


def test_what_is_there_is_kept(made, capsys):
    before = {name: (made / name).stat().st_mtime_ns for name in FILES}
    run(*ONLY, "--out", made)
    assert "0 made, 2 kept" in capsys.readouterr().out
    assert before == {name: (made / name).stat().st_mtime_ns for name in FILES}


def test_other_options_overwrite_only_when_asked(made, tmp_path, capsys):
    folder = tmp_path / "copy"
    folder.mkdir()
    for name, content in contents_of(made).items():
        (folder / name).write_bytes(content)
    assert "--overwrite" in refusal(capsys, "--only", "fig3", "--seed", 5, "--out", folder)
    assert contents_of(folder) == contents_of(made)
    run("--only", "fig3", "--seed", 5, "--out", folder, "--overwrite")
    entries = json.loads((folder / "record.json").read_text())
    assert [entries[name]["options"]["seed"] for name in ("fig3", "fig5")] == [5, 0]


def test_results_of_other_code_are_not_taken_for_those_of_this(made, monkeypatch, capsys):
    monkeypatch.setattr(provenance, "code", lambda *modules: "other")
    assert "other code" in refusal(capsys, "--only", "fig3", "--out", made)


@pytest.mark.parametrize("name", ["fig3.png", "README.md"])
def test_a_file_that_was_there_before_is_not_replaced(name, tmp_path, capsys):
    (tmp_path / name).write_text("mine")
    assert name in refusal(capsys, "--only", "fig3", "--out", tmp_path)
    assert contents_of(tmp_path) == {name: b"mine"}


def test_a_run_that_was_stopped_continues(tmp_path, monkeypatch, capsys):
    def stopped(self, product, stem):
        stem.with_suffix(".png").write_text("half")
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setitem(
            contents.ARTEFACTS, "fig5", type("Stopped", (artefact.Figure,), {"save": stopped})(
                fig5_paths.correction, contents.GEOMETRY
            )
        )  # fmt: skip
        with pytest.raises(SystemExit, match="give the same command to continue"):
            run(*ONLY, "--out", tmp_path)
    first = (tmp_path / "fig3.png").stat().st_mtime_ns
    run(*ONLY, "--out", tmp_path)
    assert "1 made, 1 kept" in capsys.readouterr().out
    assert (tmp_path / "fig3.png").stat().st_mtime_ns == first
    assert (tmp_path / "fig5.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--only", "fig33"], "Did you mean 'fig3'"),
        (["--seed", "-1"], "seed = -1"),
        (["--trials", "0"], "trials = 0"),
        (["--episodes", "0"], "episodes = 0"),
    ],
)
def test_bad_options_are_refused_before_anything_is_made(arguments, message, tmp_path, capsys):
    assert message in refusal(capsys, *arguments, "--out", tmp_path / "none")
    assert not (tmp_path / "none").exists()


START, END = paper_page.borders("table")
PAGE = f"Before.\n{START}\nold\n{END}\nAfter.\n"


@pytest.mark.parametrize(
    ("text", "only", "message"),
    [
        (None, "table", "No such file"),
        ("", "table", "once each"),
        (PAGE + PAGE, "table", "once each"),
        (f"{END}{START}", "table", "once each"),
        (PAGE, "fig3", "add one of turns, reach, plane, table to --only"),
    ],
)
def test_a_page_that_cannot_take_the_table_is_refused(text, only, message, tmp_path, capsys):
    path = tmp_path / "page.md"
    if text is not None:
        path.write_text(text)
    assert message in refusal(capsys, "--only", only, "--page", path, "--out", tmp_path / "none")
    assert not (tmp_path / "none").exists()


def test_the_table_is_put_between_the_marks(tmp_path):
    (tmp_path / "table.json").write_text(json.dumps(fig10_trials.table(JOB, STUDY)))
    once = paper_page.updated(PAGE, tmp_path, ["table"])
    assert once == paper_page.updated(once, tmp_path, ["table"])
    assert once.startswith("Before.\n")
    assert once.endswith(f"{END}\nAfter.\n")
    assert "old" not in once
    assert "| tank experiment (paper) | 12 | – | – | 8% | 66% | 4.88 ± 1.8 | -0.26 ± 0.44 |" in once
    assert (
        "| simulation, paper, nominal | 4 | 75% | 25% | 25% | 75% | 4 ± 3.61 | 0 ± 0.26 |" in once
    )
    assert "53% would be within 5 cm, 15% within 0.1 rad and 8% within both" in once


def test_out_that_is_a_file_is_refused(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert "is a file" in refusal(capsys, "--out", tmp_path / "file")


def test_studies_come_before_what_needs_them():
    assert list(contents.selection(["fig9", "fig10"])) == ["run8", "fig9", "trials", "fig10"]
    names = list(contents.ARTEFACTS)
    for name, thing in contents.ARTEFACTS.items():
        assert all(names.index(need) < names.index(name) for need in thing.needs)


def test_every_figure_and_table_says_what_it_shows_and_where_its_numbers_come_from(
    tmp_path, monkeypatch
):
    monkeypatch.setattr(artefact.Artefact, "full_caption", lambda self, folder: self.caption)
    text = contents.captions(contents.ARTEFACTS, tmp_path)
    for name, thing in contents.ARTEFACTS.items():
        assert thing.caption
        assert (f"## {name}\n" in text) != isinstance(thing, artefact.Study)
    assert "fig3" not in contents.captions(["fig4"], tmp_path)
    assert "the paper's own numbers from its tank experiment" in text


PUBLISHED = Path(__file__).parents[1] / "docs" / "reproduction"


RECORD = json.loads((PUBLISHED / "record.json").read_text())


def test_everything_is_published_made_in_one_way_and_shown():
    assert set(RECORD) == set(contents.ARTEFACTS)
    assert all(entry["complete"] for entry in RECORD.values())
    assert len({json.dumps(entry["options"]) for entry in RECORD.values()}) == 1
    page = (PUBLISHED / "README.md").read_text()
    for name, thing in contents.ARTEFACTS.items():
        shown = [file for file in thing.files(name) if not file.endswith(".pdf")]
        assert all((PUBLISHED / file).stat().st_size > 0 for file in shown)
        if not isinstance(thing, artefact.Study):
            assert all(f"({file})" in page for file in shown)


@pytest.mark.parametrize("name", ["table", "plane", "planners-table", "claims"])
def test_published_tables_follow_from_the_published_studies(name):
    table = contents.ARTEFACTS[name]
    studies = [json.loads((PUBLISHED / f"{need}.json").read_text()) for need in table.needs]
    product = table.make(Job(seed=0, trials=12, episodes=96), *studies)
    assert (PUBLISHED / f"{name}.md").read_text() == artefact.markdown(product)


def test_published_captions_are_those_of_the_code():
    assert (PUBLISHED / "README.md").read_text() == contents.captions(contents.ARTEFACTS, PUBLISHED)


def test_captions_say_the_numbers_of_the_code():
    def written(pose):
        x, y, heading = pose
        return f"{{{x:g} m, {y:g} m, {heading:g} rad}}"

    said = {
        "fig4": [
            *(f"N = {fig3_4_approach.SWARM}", f"T = {fig3_4_approach.DURATION:g} s"),
            *(f"{fig3_4_approach.ENSEMBLE} swarms", f"{100 * fig3_4_approach.NOISE_R:g} cm"),
            f"{fig3_4_approach.NOISE_ALPHA:g} rad",
        ],
        "fig5": [written(fig5_paths.CORRECTED_GOAL), f"alpha_1 = {fig1_2_definitions.ALPHA1:g}"],
        "fig6": [
            *(f"variance {single_runs.VARIANCE:g}", written(single_runs.GOALS[0])),
            *(f"T_goal = {ARRIVAL_TIME['thrusters']:g} s", f"{100 * GAINS.max_speed:g} cm/s"),
        ],
        "fig7": [written(goal) for goal in single_runs.GOALS],
        "fig8": [written(single_runs.GOALS[0]), f"{100 * IN_RANGE:g} cm from the goal"],
    }
    for name, phrases in said.items():
        caption = " ".join(contents.ARTEFACTS[name].caption.split())
        assert [phrase for phrase in phrases if phrase not in caption] == []


def test_description_of_a_sample():
    assert comparison_rows.describe([1.0, 2.0, 3.0, 6.0]) == pytest.approx(
        {"mean": 3.0, "sd": np.sqrt(14 / 3), "median": 2.5}
    )
    assert comparison_rows.describe([4.0]) == {"mean": 4.0, "sd": None, "median": 4.0}
    assert comparison_rows.describe([]) == {"mean": None, "sd": None, "median": None}


def test_rows_without_enough_values():
    nothing, single = comparison_rows.rows_of({"a": {"m": [None, 1.0]}, "b": {"m": [None, None]}})
    assert (nothing["episodes"], nothing["sd"], nothing["difference"]) == (1, None, None)
    assert (single["episodes"], single["mean"], single["difference"]) == (0, None, None)


def test_differences_have_the_intervals_of_the_evaluation():
    rng = np.random.default_rng(1)
    first, second = rng.normal(1.0, 0.5, (2, 40))
    applies = [*second[:-1].tolist(), None]
    _, row = comparison_rows.rows_of({"a": {"m": first.tolist()}, "b": {"m": applies}})
    found = statistics.difference(second[None, :-1], first[None, :-1])
    assert row["difference"] == f"{found.value:+.3g} [{found.low:+.3g}, {found.high:+.3g}]"
    assert row["its median"] == pytest.approx(np.median((second - first)[:-1]))


def test_differences_of_rates_have_an_interval_where_all_are_alike():
    values = {name: {"delivered": [1.0] * 9} for name in ("a", "b")}
    found = statistics.difference_in_success(np.ones((1, 9)), np.ones((1, 9)))
    assert (
        comparison_rows.rows_of(values)[1]["difference"]
        == f"+0 [{found.low:+.3g}, {found.high:+.3g}]"
    )


def row(distance, heading, closure=80.0, success=False):
    return {
        "min_position_error": distance,
        "heading_error_at_min": heading,
        "time_to_closure": closure,
        "success": success,
    }


ROWS = [
    row(0.01, 0.1, success=True),
    row(9.0, 3.0, closure=None),
    row(0.03, -0.3),
    row(0.08, 0.2),
    row(5.0, 1.0),
]
STUDY = {policy: dict.fromkeys(fig10_trials.WORLDS, ROWS) for policy in fig10_trials.COMPARED}


def test_table_against_a_case_worked_by_hand():
    paper, ours, *_ = fig10_trials.table(JOB, STUDY)["rows"]
    assert paper["source"] == "tank experiment (paper)"
    assert [paper["distance mean (cm)"], paper["distance sd (cm)"]] == [4.88, 1.8]
    assert [paper["heading mean (rad)"], paper["heading sd (rad)"]] == [-0.26, 0.44]
    assert paper["distance median (cm)"] is None
    assert ours == pytest.approx(
        {
            "source": "simulation",
            "policy": "paper",
            "world": "nominal",
            "trials": 4,
            "closed": 0.75,
            "delivered": 0.25,
            "distance mean (cm)": 4.0,
            "distance sd (cm)": np.sqrt((9 + 1 + 16) / 2),
            "distance median (cm)": 3.0,
            "heading mean (rad)": 0.0,
            "heading sd (rad)": np.sqrt((0.01 + 0.09 + 0.04) / 2),
            "heading median (rad)": 0.1,
            "within 5 cm, 0.1 rad": 0.25,
            "within 10 cm, 0.5 rad": 0.75,
        }
    )


def test_tolerances_accept_as_many_of_the_tanks_trials_as_a_sample_has():
    rng = np.random.default_rng(2)
    distance, heading = rng.normal([4.88, -0.26], [1.8, 0.44], (400_000, 2)).T
    near, turned = distance <= 7.0, np.abs(heading) <= 0.3
    shares = [near.mean(), turned.mean(), (near & turned).mean()]
    np.testing.assert_allclose(fig10_trials.accepted_in_tank(7.0, 0.3), shares, atol=0.004)


def test_figure_10_marks_the_trials_with_closure_and_their_means():
    for column, values in ((0, [1.0, 3.0]), (1, [0.1, -0.3])):
        panel = fig10_trials.error_figure(JOB, STUDY).axes[column]
        paper, nominal, mean, *_ = panel.lines
        np.testing.assert_array_equal(nominal.get_xdata(), [1, 3])
        np.testing.assert_allclose(nominal.get_ydata(), values)
        assert mean.get_ydata()[0] == pytest.approx(np.mean(values))
        assert paper.get_ydata()[0] == (4.88, -0.26)[column]


def test_table_as_text():
    product = {"rows": [{"a": "x", "b": 0.12345, "c": None}, {"a": "y", "b": 7, "c": 2.0}]}
    text = artefact.markdown({**product, "notes": ["Note."]})
    assert text == "| a | b | c |\n| :-- | --: | --: |\n| x | 0.123 | – |\n| y | 7 | 2 |\n\nNote.\n"


def test_differences_are_paired():
    first, second = comparison_rows.rows_of({"a": {"m": [1.0, 5.0]}, "b": {"m": [2.0, 6.0]}})
    assert (first["condition"], first["mean"], first["difference"]) == ("a", 3.0, None)
    assert (second["condition"], second["mean"], second["its median"]) == ("b", 4.0, 1.0)
    assert second["difference"] == "+1"


def test_planners_are_compared_where_both_arrive():
    def episode(time, distance):
        columns = {"closure_lost": 0, "heading_error_at_min": -0.2, "path_length_ratio": 1.5}
        return {
            **columns,
            "success": time is not None,
            "time_to_goal": time,
            "min_position_error": distance,
        }

    two = [episode(50.0, 0.01), episode(None, 0.5), episode(60.0, 0.02)]
    one = [episode(40.0, 0.03), episode(70.0, 0.02), episode(None, 0.04)]
    shown = {"lengths": {"0.2": {"alpha1 = 1": [1.0, None]}}, "episodes": {}}
    for scenario in planner_comparison.SCENARIOS:
        shown["episodes"][scenario] = {"two arcs": two, "Dubins": one}
    table = planner_comparison.table(JOB, shown)
    nominal = [row for row in table["rows"] if row["scenario"] == "nominal"]
    rows = {(row["condition"], row["measure"]): row for row in nominal}
    assert not any("|" in str(cell) for row in nominal for cell in row.values())
    time, distance = (rows["Dubins", m] for m in ("time to delivery (s)", "smallest distance (cm)"))
    assert (time["episodes"], time["mean"], time["its median"]) == (1, 40.0, -10.0)
    assert (distance["episodes"], distance["median"]) == (3, 3.0)
    assert distance["its median"] == pytest.approx(2.0)
    assert rows["two arcs", "delivered"]["mean"] == pytest.approx(2 / 3)
    assert rows["two arcs", "size of the heading error then (rad)"]["mean"] == pytest.approx(0.2)
