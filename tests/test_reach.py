"""Which goals are within reach in time, and the paths that are planned to them."""

import numpy as np
import pytest

from asv_env import make_params
from baselines.paper import two_arc
from baselines.paper.arc_following import two_arcs
from baselines.paper.coasting import coasting_distance, coasting_time
from baselines.paper.paper_numbers import GAINS, PaperGains
from baselines.paper.paper_policy import push_speed
from baselines.reproduce import reach

PARAMS = make_params()
GOALS = np.array([(0.55, -0.95, 0.1), (0.3, 0.2, 1.0), (-0.5, -0.4, 2.0), (0.0, 0.3, 0.5)])


def test_the_papers_goal_is_in_time_exactly_when_its_path_is_driven_before_the_limit():
    (length,) = reach.lengths(GOALS[:1], PARAMS, GAINS, np.inf)
    assert length == pytest.approx(1.140644, abs=1e-6)
    needed = 80.0 + length / push_speed(PARAMS, GAINS)
    hull, task = PARAMS.hulls()[0], PARAMS.task
    speed = push_speed(PARAMS, GAINS)
    coasted = coasting_distance(hull, speed)
    needed += coasting_time(hull, speed, task.speed_tolerance) + task.delivery_time
    needed -= min(coasted, GAINS.stop_distance) / speed
    for late, expected in ((0.1, True), (-0.1, False)):
        assert reach.in_time(GOALS[:1], PARAMS, GAINS, needed + late)[0] == expected


def test_a_turn_by_goal_reaches_more_and_is_never_longer():
    params, goals = PARAMS, reach.sampled_goals(PARAMS, range(300))
    printed = reach.lengths(goals, params, GAINS, np.inf)
    by_goal = reach.lengths(goals, params, PaperGains(alpha1=None), np.inf)
    assert (by_goal <= printed + 1e-9).all()
    assert np.isfinite(by_goal).sum() > 1.2 * np.isfinite(printed).sum()


@pytest.mark.parametrize("longest", [np.inf, 3.0, 1.0])
def test_arcs_are_as_wide_as_their_bound_and_the_time_permit(longest):
    goals, bound = reach.sampled_goals(PARAMS, range(300)), 0.2 * 2.5
    gains = PaperGains(alpha1=None, min_radius=2.5)
    path = two_arcs(goals, 0.2, longest, gains)
    widest = two_arc.shortest(goals, bound)
    wide = two_arc.feasible(widest, bound) & (widest.total_length <= longest)
    tight = two_arc.shortest(goals, 0.2).total_length
    assert two_arc.feasible(path, 0.2).all()
    np.testing.assert_allclose(path.end, goals, atol=1e-9)
    np.testing.assert_array_equal(path.total_length[wide], widest.total_length[wide])
    assert 0 < wide.sum() < len(goals)
    assert (path.total_length >= tight - 1e-9).all()
    assert ((path.total_length <= longest) == (tight <= longest)).all()
