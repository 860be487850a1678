"""The report of an evaluation: its page, its tables and its figures."""

import re
from dataclasses import replace

import invented
import numpy as np
import pytest
from invented import ODD, SUITE, Page

from baselines.evaluate.conditions import Condition, Suite
from baselines.evaluate.report import charts, policy_panels, single_panel, svg
from baselines.evaluate.results import Results
from baselines.evaluate.tables import descriptions, formats
from baselines.evaluate.tables.markdown import escaped


@pytest.fixture(scope="module")
def page(report):
    return Page(report.html)


def tables(summary):
    yield from (
        descriptions.results(summary),
        descriptions.measures(summary),
        descriptions.comparisons(summary),
    )
    yield descriptions.controls(summary)
    yield from (
        descriptions.of_condition(summary, condition) for condition in summary["conditions"]
    )


# What the page is report of


def test_page_loads_no_other_file(report, page):
    assert not re.search(r"https?:|@import|url\((?!#|\"data:)", report.html)
    assert [link for link in page.links if not link.startswith(("#", "data:"))] == []


def test_names_in_the_page_are_unique_and_all_links_lead_somewhere(page):
    assert len(set(page.ids)) == len(page.ids)
    targets = {link[1:] for link in page.links if link.startswith("#") and "=" not in link}
    assert targets <= set(page.ids)


def test_every_figure_is_described(page):
    drawings = [found for tag, found in page.tags if tag == "svg" and found.get("role") == "img"]
    assert len(drawings) == 1 + 2 * 6  # the overview, and six of each condition
    assert all(found["aria-label"] for found in drawings)


def test_page_and_markdown_hold_all_cells_of_all_tables(report, page):
    shown = iter(page.cells)
    for one in tables(report.summary):
        for row in one.rows:
            for column, cell in zip(one.columns, row, strict=True):
                if column.kind != "shared":  # those stand once for several lines
                    assert cell in shown, cell
            line = " | ".join(
                cell.replace("|", "\\|") if column.kind in ("number", "measure") else escaped(cell)
                for column, cell in zip(one.columns, row, strict=True)
            )
            assert f"| {line} |\n" in report.markdown


def test_numbers_are_those_of_the_rows(report):
    shown = descriptions.results(report.summary)
    line = dict(zip(shown.titles, shown.rows[0], strict=True))
    success = report.results.success("calm", "scripted")
    assert line["success"] == f"{success.mean():.1%}"
    assert sum(map(int, re.findall(r"\d+", line["failures"]))) == (~success).sum()
    distance = 100 * np.median(report.results.column("calm", "scripted", "min_position_error"))
    assert descriptions.measures(report.summary).rows[0][2] == f"{distance:.2f}"


def test_table_of_the_terminal_has_a_line_a_policy_and_condition(report):
    lines = descriptions.text_table(report.summary).splitlines()
    assert len(lines) == 1 + 2 * 3
    assert lines[1].startswith("calm             scripted")
    assert "95 % interval" in lines[0]
    assert lines[0].encode("ascii")


def test_report_names_what_was_run(report):
    for text in (report.html, report.markdown):
        for words in ("tried-v1", "seeds 10 to 17", "00112233445566bb", "c0dec0de", "numpy"):
            assert words in text


def test_broken_episodes_are_named(report, page):
    broken = [row for row in report.results if row.error]
    assert {row.policy for row in broken} == {ODD, "random"}
    for row in broken:
        number = "" if row.training_seed is None else f", training {row.training_seed}"
        line = f"{row.policy}{number}, {row.condition}, seed {row.seed}: ValueError: <no> | use"
        assert line in page.text
        assert escaped(line) in report.markdown


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        (formats.share(0.983), "98.3%"),
        (formats.quantity(-0.0004, "cm"), "0.00"),
        (formats.quantity(-0.0123, "rad"), "−0.012"),
        (formats.quantity(0.012, "cm", 100.0), "1.20"),
        (formats.quantity(None, "s"), "–"),
        (formats.estimate({"value": 2.0, "low": None, "high": None}, "s"), "2.0"),
        (formats.points({"value": -0.05, "low": -0.1, "high": 0.02}), "−5.0 [−10.0, +2.0]"),
        (formats.share_estimate({"value": 0.5, "low": 0.25, "high": 0.75}), "50.0% [25.0, 75.0]"),
        (formats.p_value(0.00002), "< 0.001"),
        (formats.p_value(0.25), "0.250"),
        (formats.p_value(None), "–"),
    ],
)
def test_numbers_are_written_alike_everywhere(text, wanted):
    assert text == wanted


# Any evaluation has a report


@pytest.mark.parametrize(
    ("task", "share"), [("approach", 1.0), ("push", 0.0), ("transport", 0.0), ("transport", 1.0)]
)
def test_one_episode_of_one_policy_is_enough(task, share, tmp_path):
    suite = Suite(
        "one-v1", "A single episode.", (Condition("only", task=task),), seed=3, episodes=1
    )
    report = invented.report(tmp_path, suite, {"own": (["aabbccddeeff0011"], share)})
    found = Page(report.html)
    assert found.data["only"]["seeds"] == [3]
    assert ("smallest distance" in report.markdown) == (task != "approach")
    assert "Comparison" not in report.html
    assert "nan" not in " ".join(found.cells)


def test_report_stands_without_a_replay(tmp_path):
    suite = replace(SUITE, conditions=SUITE.conditions[:1])
    report = invented.report(tmp_path, suite, {"own": (["aabbccddeeff0011"], 0.5)}, replays=0)
    assert "0 of 8 episodes of a condition" in report.html
    assert 'class="watch"' not in report.html


def test_goals_are_drawn_only_where_they_differ(report):
    condition = Condition("fixed", options={"goal": (0.5, -0.9, 0.1)})
    with svg.look():
        names = [
            chart.name for chart in charts.of_condition(report.results, SUITE.conditions[0], {})
        ]
        results = Results(
            SUITE,
            report.results.policies,
            {("fixed", p): report.results.rows["calm", p] for p in report.results.policies},
        )
        fixed = [chart.name for chart in charts.of_condition(results, condition, {})]
    assert names == ["profile", "times", "failures", "errors", "goals"]
    assert fixed == ["profile", "times", "failures", "errors"]


MISSING = np.full((1, 1), np.nan)


@pytest.mark.parametrize("episodes", [1, 3000])
@pytest.mark.parametrize("done", [False, True])
def test_figures_stand_few_and_many_episodes_none_or_all_done(episodes, done):
    rng = np.random.default_rng(0)
    success = np.full((2, episodes), done)
    times = rng.uniform(20, 60, (2, episodes))
    outline = np.array([[0.2, 0.1], [-0.2, 0.1], [-0.2, -0.1], [0.2, -0.1]])
    with svg.look():
        drawn = [
            single_panel.profile({"one": np.where(success, times, np.inf)}, 60.0),
            single_panel.times(
                {"one": np.where(success, times, np.nan), "other": MISSING}, "time", 60.0
            ),
            single_panel.failures(
                {"one": {} if done else {"strayed": episodes}, "other": {"not settled": 1}},
                {"one": episodes, "other": 1},
            ),
            policy_panels.errors(
                {"one": 10 * rng.random((2, episodes)), "other": MISSING},
                {"one": rng.normal(size=(2, episodes)), "other": MISSING},
                {"one": success, "other": np.zeros((1, 1), dtype=bool)},
                (5.0, 0.1),
                ((4.88, 1.8), (-0.26, 0.44)),
            ),
            policy_panels.goals(rng.normal(size=(episodes, 2)), {"one": success}, outline, 1.2),
            policy_panels.paths({"one": [rng.random((9, 2))]}, {"one": [done]}, outline, None),
            single_panel.overview(["a"], [None], {"one": np.array([[done, 0.0, 1.0]])}),
        ]
        texts = [svg.draw(figure, f"f{k}").content for k, figure in enumerate(drawn)]
    for text in texts:
        Page(text)
        assert "nan" not in text
        assert len(text) < 400_000


def test_causes_of_a_users_task_come_last():
    found = {"tipped over": 2, "not settled": 1, "strayed": 3}
    assert descriptions.in_order(found) == ["strayed", "not settled", "tipped over"]
    with svg.look():
        drawn = svg.draw(single_panel.failures({"one": found}, {"one": 10}), "f").content
    assert "tipped over" in drawn


def test_labels_of_axes_are_kept_to_the_last_digit():
    with svg.look():
        figure = single_panel.times({"one": np.array([[0.001]])}, "time", 0.005)
        figure.axes[0].set_xticks([0.0, 0.00125])
        drawn = svg.draw(figure, "f").content
    assert ">0.00125<" in drawn
    assert not re.search(r"[ \"]\d+\.\d{3}", drawn)
