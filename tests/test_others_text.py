"""What users write, names and errors and descriptions, in every output."""

import html
import re
from dataclasses import replace

import invented
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from baselines.evaluate.conditions import Condition, Suite
from baselines.evaluate.names import check_distinct, check_name, check_policy_name
from baselines.evaluate.report import rendering
from baselines.evaluate.tables.markdown import code, escaped, prose
from baselines.evaluate.tables.table import Column, tabulated

NASTY = "<img src=x onerror=alert(1)> [a](javascript:alert(1)) | `b` **c** </script> $d$ \\"
MARKUP = re.compile(r"(?<!\\)(?:\\\\)*[`*\[\]|~$]")


@given(st.text("<>&`*_[]()|\\ab~$#! \n", max_size=40))
def test_escaped_text_holds_no_markup_and_all_of_itself(text):
    shown = escaped(text)
    assert not MARKUP.search(shown)
    assert not set("<>\n") & set(shown)
    plain = re.sub(r"\\([\\`*\[\]|~$#_])", r"\1", shown)
    assert html.unescape(plain) == " ".join(text.split())


@given(st.text("`a| \\<", max_size=20))
def test_a_code_span_is_closed_by_its_own_fence_alone(text):
    shown = code(text)
    fence = re.match("`+", shown)[0]
    inside = shown[len(fence) : -len(fence)]
    assert shown.endswith(fence)
    assert fence not in re.findall("`+", inside)


def test_words_that_need_no_escape_stay_as_they_are():
    for text in ("policy error", "4 boats, harsh", "my_policy_2", "aspect-1.5", "±15 %, 0.05 to 3"):
        assert escaped(text) == text
    assert prose("half the noise of `noisy`, <b>") == "half the noise of `noisy`, &lt;b&gt;"


def test_cells_of_others_do_not_break_a_table():
    heads = [Column("name", lambda text: text, kind="policy"), Column("x|y", lambda _: "0.1")]
    lines = tabulated("t", "", heads, [NASTY, "a|b"]).markdown.splitlines()
    assert [len(re.findall(r"(?<!\\)\|", line)) for line in lines] == [3] * 4
    assert "<img" not in lines[2]


@pytest.fixture
def nasty(tmp_path):
    """A report whose names, descriptions and causes are all nasty."""
    name = NASTY.replace("/", " ").replace("\\", " ").strip()
    conditions = (Condition(name, NASTY), Condition("other", control=name))
    suite = Suite("<b>|s", NASTY, conditions, seed=10, episodes=2)
    return invented.report(tmp_path, suite, {"own": (["aabbccddeeff0011"], 0.0)})


def test_a_report_with_nasty_names_has_no_raw_markup(nasty):
    assert "<img" not in nasty.markdown
    assert not re.search(r"(?<!\\)\]\(", nasty.markdown)
    shown = nasty.html.split('<script type="application/json"')
    assert "<img" not in shown[0]
    data = [part.split("</script>")[0] for part in shown[1:]]
    assert not any("<" in part.partition(">")[2] for part in data)  # within the elements


def test_errors_are_single_lines_in_all_lists(report):
    rows = [replace(row, error=f"{NASTY}\n- second\x1b[31m") for row in report.results]
    lines = rendering.broken(rows)
    assert all(line.isprintable() for line in lines)
    assert all(line.endswith("- second\\x1b[31m") for line in lines[:-1])


def test_a_notebook_shows_whole_cells_whatever_the_options_of_pandas(report):
    from baselines.evaluate.api import Comparison

    shown = Comparison(None, report.results, report.summary)
    plain = shown._repr_html_()
    assert "..." not in plain
    assert "&lt;/script&gt;" in plain
    with pd.option_context("display.max_colwidth", 5, "display.html.border", 3):
        assert shown._repr_html_() == plain


# Names


@pytest.mark.parametrize(
    "name",
    ["", " ", "a/b", "..", "../x", "a\\b", ".", "a\nb", "a\0", "a ", "con", "NUL.txt", "x" * 101,
     "\u202ea", "é" * 51, "\udcff", 3, None, b"a", "a."],
)  # fmt: skip
def test_what_cannot_name_a_folder_is_refused(name):
    with pytest.raises(ValueError, match="cannot be a name"):
        check_name("condition", name)
    with pytest.raises(ValueError, match="cannot be a name"):
        check_policy_name(name)
    with pytest.raises(ValueError, match="cannot be a name"):
        Suite("own", "", (Condition(name),))


@pytest.mark.parametrize("name", ["a|b", "<b>", "4 boats, harsh", "ünïcode 船", "=1+1", ".hidden"])
def test_any_other_text_names_a_condition(name):
    check_name("condition", name)


def test_names_that_are_one_folder_on_some_systems_are_refused():
    check_distinct("policies", ["a", "b", "ab"])
    for pair in (["PPO", "ppo"], ["é", "e\u0301"], ["a", "a"], ["ß", "SS"]):
        with pytest.raises(ValueError, match="a name of its own"):
            check_distinct("policies", pair)
