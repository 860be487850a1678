"""The scripted policy on the real physics."""

import numpy as np
import pytest
from helpers import successes
from scipy.stats import binom

from asv_env import Simulation, make_params
from asv_env.params.outlines import SHAPES
from baselines.policy import POLICIES
from baselines.rollout import runner
from baselines.scripted.scripted_policy import ScriptedPolicy

GOAL = (0.55, -0.95, 0.1)
PARAMS = make_params("transport", goal=GOAL)
HALF_TURN = np.pi / PARAMS.boat.full_yaw_rate
"""Time in which a boat turns round, s: boats that come late to their slots need no longer."""


def rows(params, episodes):
    logs = runner.run(ScriptedPolicy, params, range(episodes), episodes)
    return [log.episode for log in logs]


@pytest.fixture(scope="module")
def deliveries():
    """Twenty episodes on the paper's goal from anywhere round the vessel."""
    return rows(PARAMS, 20)


def test_delivers_to_the_papers_goal(deliveries):
    assert sum(row.success for row in deliveries) >= 19


def test_boats_arrive_together_and_keep_their_grasp_until_they_let_go(deliveries):
    delivered = [row for row in deliveries if row.success]
    assert np.median([row.closure_spread for row in delivered]) < HALF_TURN
    assert np.median([row.closure_lost for row in delivered]) <= 1  # At the end they let go.
    assert np.median([row.path_length_ratio for row in delivered]) < 1.15


def test_is_precise_under_noise_in_the_papers_experiment():
    done = rows(make_params("transport", 4, "noisy", "experiment"), 12)
    distances = [row.min_position_error for row in done]
    headings = [row.heading_error_at_min for row in done]
    assert np.mean(distances) < 0.015
    assert abs(np.mean(headings)) < 0.02
    assert np.std(headings) < 0.06


@pytest.mark.parametrize(
    ("scenario", "num_boats", "delivery", "success"),
    [
        ("noisy", 4, "holding", 0.99),
        ("noisy", 8, "holding", 0.99),
        ("delay", 4, "holding", 0.96),
        ("current", 4, "passing", 0.9),
        ("current", 4, "holding", 0.92),
        ("failure", 6, "holding", 0.9),
    ],
)
def test_delivers_to_goals_all_over_the_plane(scenario, num_boats, delivery, success):
    """At the share ``success`` so many failures have a probability above 5 %."""
    params, episodes = make_params("transport", num_boats, scenario, delivery=delivery), 10
    enough = episodes - binom.ppf(0.95, episodes, 1.0 - success)
    assert successes(ScriptedPolicy, params, episodes, enough) == enough


def test_the_mirror_image_of_a_push_is_the_push_from_the_other_side():
    plus = make_params("push", goal=GOAL)
    minus = make_params("push", goal=(0.55, 0.95, -0.1), side="-n")
    (one,) = rows(plus, 1)
    (other,) = rows(minus, 1)
    assert one.success
    assert other.success
    assert other.heading_error == pytest.approx(-one.heading_error, abs=0.05)
    assert other.time_to_goal == pytest.approx(one.time_to_goal, abs=2.0)


def test_thruster_actions_are_refused():
    with pytest.raises(ValueError, match="tracking"):
        ScriptedPolicy(make_params(action_mode="thrusters"))


def test_the_policy_leaves_what_it_is_given_alone():
    simulation = Simulation(make_params(), 3)
    observation = simulation.reset(seeds=range(3))
    policy, fresh = ScriptedPolicy(simulation.params), np.ones(3, dtype=bool)
    motion = simulation.sensed.estimate.copy()
    _, memory = policy.act(simulation.sensed, observation, None, fresh)
    due = memory.grasp.due.copy()
    policy.act(simulation.sensed, observation, memory, fresh)
    np.testing.assert_array_equal(simulation.sensed.estimate, motion)
    np.testing.assert_array_equal(memory.grasp.due, due)


@pytest.mark.parametrize("num_boats", [2, 3, 10])
def test_teams_of_other_sizes_grasp_the_vessel(num_boats):
    assert successes(ScriptedPolicy, make_params("approach", num_boats), 10, enough=8) == 8


@pytest.mark.parametrize("name", ["scripted", "allocation"])
@pytest.mark.parametrize("vessel", [None, *SHAPES])
def test_large_teams_begin_round_every_named_hull(name, vessel):
    """The side that they grasp may be nearer to the centre than the other one."""
    params = make_params("transport", 20, vessel=vessel) if vessel else make_params(num_boats=20)
    simulation = Simulation(params)
    observation = simulation.reset(seeds=[0])
    policy = POLICIES.find(name)(params)
    action, _ = policy.act(simulation.sensed, observation, None, np.ones(1, dtype=bool))
    assert np.isfinite(action).all()
