"""The paper's controller: its laws one by one, and what it comes to on the real physics."""

from collections import Counter
from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest
from helpers import DOWN, begin_at, bodies, copied
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from asv_env import Simulation, make_params
from asv_env.params import BoatParams
from asv_env.tasks.formation import slots
from asv_env.types import rows
from baselines.paper.coasting import coasting_speed, coasting_time
from baselines.paper.paper_numbers import GAINS, IN_RANGE, PaperGains
from baselines.paper.paper_policy import PaperPolicy
from baselines.rollout import runner

GOAL = (0.55, -0.95, 0.1)
FULL_SPEED, FULL_YAW_RATE = BoatParams().full_speed, BoatParams().full_yaw_rate
CENTRE = 0.57727235
"""x of the first circle's centre for that goal and alpha_1 = 1, from the checked equations, m."""


class Trial:
    """Worlds under the paper's policy, one control tick at a time."""

    def __init__(self, params, seeds=(0,), motions=None, **policy):
        self.sim = Simulation(params, len(seeds))
        self.policy = PaperPolicy(params, **policy)
        if motions is None:
            self.observation = self.sim.reset(seeds=list(seeds))
        else:
            self.observation = begin_at(self.sim, motions)
        self.memory, self.fresh, self.over = None, np.ones(len(seeds), dtype=bool), False

    def act(self):
        """Action of this tick, which is then taken."""
        action, self.memory = self.policy.act(
            self.sim.sensed, self.observation, self.memory, self.fresh
        )
        step = self.sim.step(action)
        self.observation = step.observation
        self.fresh = step.ending.terminated | step.ending.truncated
        self.over = bool(self.fresh.any())
        return action

    def run(self, ticks):
        """Actions (T, W, A, 2) until then, or until a world ends."""
        actions = []
        while len(actions) < ticks and not self.over:
            actions.append(self.act())
        return np.array(actions)


def decide(params, sensed, memory=None):
    """One decision of a new policy."""
    fresh = np.full(len(sensed.side), memory is None)
    return PaperPolicy(params).act(sensed, np.empty(0), memory, fresh)


def sensed(params, seeds=(0,)):
    """What is sensed at the start of episodes."""
    sim = Simulation(params, len(seeds))
    sim.reset(seeds=list(seeds))
    return copied(sim.sensed)


def spiral_length(offset):
    """Length of Eq (4) from an offset (x, y) to the target, by quadrature."""
    r0 = np.hypot(*offset)
    theta0 = abs((np.arctan2(offset[1], offset[0]) - np.pi / 2 + np.pi) % (2 * np.pi) - np.pi)
    r_pi = r0 / (1 - np.exp(-theta0))
    return quad(lambda t: r_pi * np.hypot(1 - np.exp(-t), np.exp(-t)), 0, theta0)[0]


def test_approach_speed_is_the_spirals_length_over_the_time_left():
    params = make_params(boat={"thrust": 0.02})
    begun = sensed(params)
    policy = PaperPolicy(params, PaperGains(arrival_time=200.0))
    action, memory = policy.act(begun, np.empty(0), None, np.ones(1, dtype=bool))
    boats = begun.measured[0, 1:, :2]
    for boat, target, speed in zip(boats, memory.target[0], action[0, :, 0], strict=True):
        length = spiral_length(boat - (target.real, target.imag))
        wanted = (length - params.task.slot_distance) / 200.0
        assert speed * FULL_SPEED == pytest.approx(wanted, rel=1e-5)


def test_a_boat_on_the_heading_of_the_law_goes_straight_on():
    params = make_params()
    begun = sensed(params)
    _, memory = decide(params, begun)
    offset = begun.measured[0, 1:, 0] + 1j * begun.measured[0, 1:, 1] - memory.target[0]
    alpha = np.angle(offset)
    theta = np.abs(np.angle(np.exp(1j * (alpha - np.pi / 2))))
    phi = np.pi / 2 * (1 - np.exp(-theta))
    turn = np.where(offset.real >= 0, 1, 0)
    turned = copied(begun)
    for error in (0.0, 0.1, -0.3):
        turned.estimate[0, 1:, 2] = alpha + np.pi - (2 * turn - 1) * phi + error
        action, _ = decide(params, turned)
        yaw_rate = action[0, :, 1] * FULL_YAW_RATE
        np.testing.assert_allclose(yaw_rate, -GAINS.steering * error, atol=1e-6)


@pytest.mark.parametrize("num_boats", [2, 5, 6])
def test_every_working_boat_has_one_target_of_least_total_distance(num_boats):
    params = make_params(num_boats=num_boats)
    begun = sensed(params, range(8))
    begun.working[3, 1] = False
    begun.slot[3, 1] = 2.0 + 1.0j
    _, memory = decide(params, begun)
    for world in range(8):
        works = begun.working[world]
        target, slot = memory.target[world, works], begun.slot[world, works]
        assert Counter(target) == Counter(slot)
        boats = (begun.measured[world, 1:, :2] @ (1, 1j))[works]
        least = min(np.abs(boats - order).sum() for order in permutations(slot))
        assert np.abs(boats - target).sum() == pytest.approx(least)
    assert memory.target[3, 1] == 2.0 + 1.0j


def test_boats_in_their_slots_wait_for_the_last_one():
    params = make_params()
    places = slots(params, 4)
    start = bodies((), *[(p.real, p.imag, DOWN) for p in places])
    start[4, :3] = (1.5, 1.5, DOWN)
    trial = Trial(params, motions=[start])
    for _ in range(50):
        action = trial.act()
        np.testing.assert_allclose(action[0, :3], 0.0, atol=1e-3)
        assert action[0, 3, 0] > 0
    assert not trial.memory.pushing.any()


def test_first_circle_is_the_one_of_the_checked_equations():
    _, memory = decide(make_params("push", goal=GOAL), sensed(make_params("push", goal=GOAL)))
    assert memory.pushing.all()
    assert memory.centre[0, 0] == pytest.approx(CENTRE, abs=1e-7)
    assert memory.centre[0, 1] == pytest.approx(-0.07284169 - 1.01249262j, abs=1e-7)
    np.testing.assert_allclose(memory.rho[0], (0.57727235, -0.62596900), atol=1e-6)


def test_pushers_are_asked_for_the_speeds_of_eq_16():
    params = make_params("push", goal=GOAL)
    begun = sensed(params)
    action, _ = decide(params, begun)
    inner = begun.measured[0, 2:4, :2]
    mean = coasting_speed(params.hulls()[0], IN_RANGE)
    wanted = np.hypot(*(inner - (CENTRE, 0.0)).T) / CENTRE * mean
    np.testing.assert_allclose(action[0, 1:3, 0] * FULL_SPEED, wanted, rtol=1e-5)


def test_pushers_move_in_the_ratio_of_eq_16():
    """Along the normal, by their distances from the centre at the time: they slide on the hull."""
    trial = Trial(make_params("push", goal=GOAL))
    travelled, distance = np.zeros(2), np.zeros(2)
    for _ in range(150):
        before = trial.sim.state.motion[0]
        trial.act()
        after = trial.sim.state.motion[0]
        ahead = -np.array([-np.sin(before[0, 2]), np.cos(before[0, 2])])
        travelled += (after - before)[2:4, :2] @ ahead
        distance += np.abs(before[2:4, :2] @ (1, 1j) - CENTRE)
    assert trial.memory.arc[0] == 0
    assert travelled[0] / travelled[1] == pytest.approx(distance[0] / distance[1], rel=0.05)


def test_pushers_turn_the_vessel_to_face_the_centre():
    """A vessel that has turned too far: its left pusher, outside, goes slower, the right faster."""
    params = make_params("push", goal=GOAL)
    begun = sensed(params)
    straight, memory = decide(params, begun)
    turned = copied(begun)
    turned.estimate[0, :, 2] += 0.1
    position = turned.estimate[0, 1:, :2] @ (1, 1j) * np.exp(0.1j)
    turned.estimate[0, 1:, 0], turned.estimate[0, 1:, 1] = position.real, position.imag
    action, _ = decide(params, turned, memory)
    centre = np.abs(position[1:3] - CENTRE) / CENTRE * coasting_speed(params.hulls()[0], IN_RANGE)
    u = slots(params, 4)[1:3].real
    np.testing.assert_allclose(
        action[0, 1:3, 0] * FULL_SPEED, centre + GAINS.vessel_yaw * 0.1 * u, rtol=1e-5
    )
    assert action[0, 1, 0] < straight[0, 1, 0]


def test_end_boats_turn_against_the_drift_of_the_vessel():
    """All is 1 cm off its circle, away from the centre: end boats turn towards it."""
    params = make_params("push", goal=GOAL)
    begun = sensed(params)
    _, memory = decide(params, begun)
    drifted = copied(begun)
    drifted.estimate[0, :, 0] -= 0.01
    action, _ = decide(params, drifted, memory)
    on_circle, _ = decide(params, begun, memory)
    turns = (action - on_circle)[0, (0, 3), 1] * FULL_YAW_RATE
    np.testing.assert_allclose(turns, GAINS.steering * 0.01 / GAINS.cross_track, rtol=1e-3)


def test_coasting_speed_agrees_with_the_integrated_motion():
    hull = make_params().hulls()[0]
    linear, quadratic = hull.sway
    slowing = lambda v: hull.masses[1] / (linear + quadratic * v)  # noqa: E731 (dx/dv)
    assert quad(slowing, 0, coasting_speed(hull, 0.3))[0] == pytest.approx(0.3)
    linearised = hull.linearised(0.1, 0.5)
    assert quad(lambda v: hull.masses[1] / linearised.sway[0], 0, coasting_speed(linearised, 0.3))[
        0
    ] == pytest.approx(0.3)


def test_coasting_time_agrees_with_the_integrated_motion():
    hull = make_params().hulls()[0]
    linear, quadratic = hull.sway
    slowing = lambda v: hull.masses[1] / ((linear + quadratic * v) * v)  # noqa: E731 (dt/dv)
    assert quad(slowing, 0.002, 0.04)[0] == pytest.approx(coasting_time(hull, 0.04, 0.002))
    assert coasting_time(hull, 0.001, 0.002) == 0.0


@pytest.mark.parametrize("mode", ["tracking", "thrusters"])
def test_motors_are_off_from_20_cm_on(mode):
    params = make_params("push", goal=(0.2, -0.5, 0.4), action_mode=mode)
    trial = Trial(params)
    distances, thrusts = [], []
    while not trial.over and len(distances) < 400:
        distances.append(float(trial.sim.relations.goal_error[0]))
        action = trial.act()
        thrusts.append(np.abs(trial.sim.state.thrust).max())
        assert trial.memory.motors_off[0] == (min(distances) < IN_RANGE)
        if trial.memory.motors_off[0] and mode == "thrusters":
            assert not action.any()
    off = np.argmax(np.array(distances) < IN_RANGE)
    assert 50 < off < len(distances) - 100
    lagging = round(10 * params.boat.lag * params.clock.control)
    assert max(thrusts[:off]) > 0.3 * params.boat.thrust
    assert max(thrusts[off + lagging :]) < 0.05 * params.boat.thrust


def test_wheel_speeds_act_one_tick_late():
    params = make_params(preset="paper_simulation", action_mode="thrusters")
    begun = sensed(params)
    first, memory = decide(params, begun)
    assert not first.any()
    elsewhere = copied(begun)
    elsewhere.estimate[..., :2] *= 1.5
    second, memory_there = decide(params, elsewhere, memory)
    np.testing.assert_array_equal(second, decide(params, begun, memory)[0])
    assert second.any()
    third, _ = decide(params, begun, memory_there)
    assert (third != second).any()


def test_wheel_speeds_are_those_of_eq_3():
    params = make_params(preset="paper_simulation", action_mode="thrusters")
    begun = sensed(params)
    _, memory = decide(params, begun)
    offset = begun.measured[0, 1:, :2] @ (1, 1j) - memory.target[0]
    alpha, sign = np.angle(offset), np.where(offset.real >= 0, 1, -1)
    theta = np.abs(np.angle(np.exp(1j * (alpha - np.pi / 2))))
    phase = begun.measured[0, 1:, 2] - alpha + np.pi / 2
    phase += sign * np.pi / 2 * (1 - np.exp(-theta))
    difference = GAINS.steering * params.boat.lever_arm * np.cos(phase)
    left, right = memory.wheels[0].T
    np.testing.assert_allclose((left - right) / 2, difference, atol=1e-12)
    assert ((left + right) / 2 <= GAINS.max_speed + 1e-12).all()


def test_thrust_keeps_the_wheel_speed_up_in_steady_motion():
    """A boat that already moves at the speed of its wheels gets just the thrust of its drag."""
    params = make_params("transport", action_mode="thrusters")
    begun = sensed(params)
    _, memory = decide(params, begun)
    speed, yaw_rate = 0.03, 0.2
    half = yaw_rate * params.boat.lever_arm
    memory.wheels[...] = (speed - half, speed + half)
    heading = begun.estimate[0, 1:, 2]
    begun.estimate[0, 1:, 3:] = np.stack(
        [speed * np.cos(heading), speed * np.sin(heading), 0 * heading + yaw_rate], axis=-1
    )
    action, _ = decide(params, begun, memory)
    boat = params.hulls()[1]
    thrust = boat.thrust * np.where(action < 0, boat.astern, 1.0) * action
    drag = (boat.surge[0] + boat.surge[1] * speed) * speed
    moment = (boat.yaw[0] + boat.yaw[1] * yaw_rate) * yaw_rate
    np.testing.assert_allclose(thrust.sum(axis=-1), drag, rtol=1e-5)
    np.testing.assert_allclose(
        (thrust[..., 1] - thrust[..., 0]) * boat.lever_arm, moment, rtol=1e-4
    )


def test_the_paper_controller_grasps_and_delivers_to_within_centimetres():
    """The paper: 4.88 +- 1.8 cm and -0.26 +- 0.44 rad at the instant of minimal distance."""
    params = make_params(preset="experiment")
    done = [log.episode for log in runner.run(PaperPolicy, params, range(6), 6)]
    errors = np.array([row.min_position_error for row in done])
    assert np.median(errors) < 0.0488
    assert np.median([abs(row.heading_error_at_min) for row in done]) < 0.26
    assert (errors < IN_RANGE).all()


@pytest.mark.parametrize("mode", ["tracking", "thrusters"])
def test_the_other_side_is_the_mirror_image(mode):
    params = make_params("transport", goal=GOAL, action_mode=mode)
    begun = sensed(params, range(3))
    signs = np.array([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])
    image = replace(
        begun,
        estimate=begun.estimate * signs,
        goal=begun.goal * signs[:3],
        slot=begun.slot.conj(),
        side=-begun.side,
    )
    one, memory = decide(params, begun)
    other, memory_image = decide(params, image)
    one, _ = decide(params, begun, memory)
    other, _ = decide(params, image, memory_image)
    assert one.any()
    mirrored = one * (1, -1) if mode == "tracking" else one[..., ::-1]
    np.testing.assert_allclose(other, mirrored, atol=1e-6)


def test_a_world_is_decided_on_alone():
    params = make_params("transport", scenario="noisy")
    begun = sensed(params, range(4))
    together, _ = decide(params, begun)
    for world in range(4):
        alone, _ = decide(params, rows(begun, slice(world, world + 1)))
        np.testing.assert_array_equal(alone[0], together[world])


def test_the_policy_leaves_what_it_is_given_alone():
    params = make_params("push", goal=GOAL)
    trial = Trial(params)
    trial.run(5)
    given_sensed, given_memory = copied(trial.sim.sensed), copied(trial.memory)
    decide(params, trial.sim.sensed, trial.memory)
    for name, array in vars(given_memory).items():
        np.testing.assert_array_equal(getattr(trial.memory, name), array)
    np.testing.assert_array_equal(trial.sim.sensed.estimate, given_sensed.estimate)


def test_a_new_episode_begins_without_memory_of_the_last():
    params = make_params("push", goal=GOAL)
    trial = Trial(params, (0, 1))
    trial.run(30)
    begun = sensed(params, (0, 1))
    policy = PaperPolicy(params)
    _, memory = policy.act(begun, np.empty(0), trial.memory, np.array([True, False]))
    assert memory.travelled[0] == 0 < trial.memory.travelled[0]
    np.testing.assert_array_equal(memory.centre[0], decide(params, begun)[1].centre[0])


HARD_GOALS = [
    (0.0, 0.0, 1.0),
    (0.0, 0.0, 0.0),
    (0.6, -0.4, 0.0),
    (0.0, -0.8, 0.0),
    (0.0, 0.8, 0.0),
    (0.5, -0.5, 1.0),
    (0.5, 0.5, 1.0),
    (0.7, 0.2, np.pi),
    (0.4, -0.4, 1e-12),
]


@pytest.mark.parametrize("goal", HARD_GOALS)
@pytest.mark.parametrize("alpha1", [1.0, 0.0, None])
def test_actions_are_finite_for_singular_goals(goal, alpha1):
    trial = Trial(make_params("push", goal=goal, time_limit=8.0), gains=PaperGains(alpha1=alpha1))
    assert np.isfinite(trial.run(60)).all()


@settings(max_examples=15, deadline=None)
@given(
    num_boats=st.integers(2, 20),
    task=st.sampled_from(["approach", "push", "transport"]),
    side=st.sampled_from(["+n", "-n", "goal"]),
    scenario=st.sampled_from(["nominal", "harsh"]),
    preset=st.sampled_from(["nominal", "experiment"]),
    mode=st.sampled_from(["tracking", "thrusters"]),
    seed=st.integers(0, 10**6),
)
def test_actions_are_finite_in_any_world(num_boats, task, side, scenario, preset, mode, seed):
    """Any team, side, goal and failure; the simulation refuses actions that are not finite."""
    options = {"goal": None, "side": side, "time_limit": 10.0}
    if scenario == "harsh":
        options["variation"] = {"failures": num_boats - 1, "failure_time": (1.0, 5.0)}
    params = make_params(task, num_boats, scenario, preset, mode, **options)
    actions = Trial(params, (seed,)).run(50)
    assert np.abs(actions).max() <= 1.0


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("alpha1", np.nan),
        ("arrival_time", 0.0),
        ("push_speed", -1.0),
        ("switch_distance", -0.01),
        ("min_radius", None),
    ],
)
def test_bad_gains_are_refused(name, value):
    with pytest.raises(ValueError, match=name):
        PaperGains(**{name: value})
