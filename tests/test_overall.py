"""Means over the conditions of a suite, and the page that describes the suites."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from baselines.evaluate.conditions import Condition, Suite
from baselines.evaluate.overall import live, overall
from baselines.evaluate.publish import gallery
from baselines.evaluate.suites import SUITES


def results_of(rates, unseen=()):
    """Results of 100 episodes by success rates in per cent, {condition: {policy: rate}}."""
    conditions = tuple(Condition(name, out_of_distribution=name in unseen) for name in rates)
    won = {
        (name, policy): np.arange(100)[None] < rate
        for name, row in rates.items()
        for policy, rate in row.items()
    }
    return SimpleNamespace(
        suite=Suite("own", "", conditions),
        policies=tuple(next(iter(rates.values()))),
        success=lambda condition, policy: won[condition, policy],
    )


RATES = {
    "solved": {"a": 100, "b": 99},
    "telling": {"a": 90, "b": 40},
    "half-solved": {"a": 100, "b": 60},
    "hopeless": {"a": 1, "b": 0},
    "far": {"a": 30, "b": 10},
    "farther": {"a": 0, "b": 0},
}


def test_saturated_conditions_do_not_move_the_mean():
    results = results_of(RATES, unseen=("far", "farther"))
    assert [one.name for one in live(results, False)] == ["telling", "half-solved"]
    assert [one.name for one in live(results, True)] == ["far"]
    a, b = overall(results, "a"), overall(results, "b")
    assert (a.mean, b.mean) == pytest.approx((0.95, 0.5))
    assert (a.unseen, b.unseen) == pytest.approx((0.3, 0.1))
    assert (a.worst, a.least) == ("farther", 0.0)


def test_all_conditions_count_where_none_is_live():
    results = results_of({"one": {"a": 100}, "two": {"a": 99}})
    assert overall(results, "a").mean == pytest.approx(0.995)
    assert overall(results, "a").unseen is None


def test_page_lists_every_condition_once_with_digest_and_marks():
    suite = SUITES["quick-v2"]
    far = replace(suite.conditions[1], name="far", out_of_distribution=True)
    mine = replace(suite, name="own", conditions=(*suite.conditions, far))
    text = gallery.page([mine], "suites")
    for condition in mine.conditions:
        assert text.count(f"| `{condition.name}` |") == 1
    assert text.count("(*unseen*)") == 1
    assert mine.digest() in text
    assert "seeds 1000000 to 1000059" in text


def test_picture_shows_what_looks_different():
    shapes = SUITES["shape-v2"]
    noisy = SUITES["plane-v2"]
    assert len(gallery.pictured(shapes)) == gallery.LARGEST
    assert [one.name for one in gallery.pictured(noisy)] == ["nominal"]
    image = np.asarray(gallery.picture(replace(noisy, conditions=noisy.conditions[:1])))
    side = gallery.SIDE
    assert image.shape == (side + gallery.LABEL + 2 * gallery.GAP, side + 2 * gallery.GAP, 3)
    drawn = image[gallery.GAP : gallery.GAP + side, gallery.GAP : gallery.GAP + side]
    np.testing.assert_array_equal(drawn, gallery.frame(noisy.conditions[0], noisy.seed))
