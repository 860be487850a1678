"""Parameters: what is refused and how, what grows with the team, presets and scenarios."""

import math
import re
from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from asv_env import make_params
from asv_env.params import (
    BoatParams,
    ClockParams,
    EnvParams,
    RewardParams,
    SensorParams,
    TaskParams,
    VariationParams,
    VesselParams,
    WaterParams,
)
from asv_env.simulation import Simulation

approx = pytest.approx

SECTIONS = {
    "boat": BoatParams(),
    "vessel": VesselParams(),
    "water": WaterParams(walls=5.0),
    "sensors": SensorParams(shared=False, range=1.0),
    "clock": ClockParams(),
    "task_params": TaskParams(),
    "variation": VariationParams(lag=(0.1, 0.2), friction=(0.1, 0.2), load=(1.0, 2.0)),
    "reward": RewardParams(),
}


def named(kind, *but):
    """(section, field) of every parameter whose value is of a kind."""
    return [
        (section, field.name)
        for section, values in SECTIONS.items()
        for field in fields(values)
        if isinstance(getattr(values, field.name), kind) and field.name not in but
    ]


TRUTHS = named(bool)
NUMBERS = [one for one in named(int | float) if one not in TRUTHS]
PAIRS = named(tuple)
CHOICES = [*named(str, "name"), ("task_params", "name")]
SIGNED = {"current_heading", "gyre_phase"}
INTERVALS = [(section, name) for section, name in PAIRS if section not in ("boat", "vessel")]


def refuses(section, name, value):
    """Whether a value is refused with the parameter's name in the message."""
    with pytest.raises((ValueError, TypeError), match=name):
        make_params(**{section: {name: value}})
    return True


# ------------------------------------------------------------------ bad input


def test_every_parameter_is_covered_here():
    known = {(section, f.name) for section, values in SECTIONS.items() for f in fields(values)}
    assert known - {*NUMBERS, *TRUTHS, *PAIRS, *CHOICES} == {
        ("task_params", "goal"),
        ("vessel", "outline"),  # see test_outlines.py
    }


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf], ids=str)
@pytest.mark.parametrize(("section", "name"), NUMBERS)
def test_number_that_is_not_finite_is_refused_by_name(section, name, bad):
    assert refuses(section, name, bad)


@pytest.mark.parametrize("bad", ["fast", [1.0], 1j, True], ids=repr)
@pytest.mark.parametrize(("section", "name"), NUMBERS)
def test_parameter_that_is_no_number_is_refused_by_name(section, name, bad):
    assert refuses(section, name, bad)


@pytest.mark.parametrize("bad", ["yes", 1, 0.0, None, [True]], ids=repr)
@pytest.mark.parametrize(("section", "name"), TRUTHS)
def test_what_is_neither_true_nor_false_is_refused_by_name(section, name, bad):
    assert refuses(section, name, bad)


@given(
    parameter=st.sampled_from([p for p in NUMBERS if p[1] not in SIGNED]),
    below=st.floats(-1e6, -1e-6),
)
def test_negative_number_is_refused_by_name(parameter, below):
    assert refuses(*parameter, below)


POSITIVE = {
    "boat": "length width mass inertia bow thrust lever_arm lag",
    "vessel": "length width mass inertia",
    "water": "gyre_size gust_time walls",
    "sensors": "acceleration yaw_acceleration vessel_acceleration vessel_yaw_acceleration",
    "clock": "physics sensing control",
    "task_params": "arena time_limit position_tolerance heading_tolerance speed_tolerance "
    "yaw_rate_tolerance passing_speed passing_yaw_rate slot_distance slot_angle slot_speed",
}


@pytest.mark.parametrize(
    ("section", "name"), [(s, name) for s, names in POSITIVE.items() for name in names.split()]
)
def test_zero_is_refused_where_it_makes_no_sense(section, name):
    assert refuses(section, name, 0)


@pytest.mark.parametrize(
    ("section", "name", "value"),
    [
        ("boat", "astern", 1.01),
        ("boat", "bow", 0.066),
        ("variation", "thrust", 1.0),
        ("variation", "drag", 1.0),
        ("variation", "mass", 1.0),
        ("variation", "failures", 4),
        ("variation", "failures", 0.5),
        ("variation", "failures", 1.5),
        ("water", "walls", 0.3),
    ],
)
def test_number_above_its_range_or_not_whole_is_refused_by_name(section, name, value):
    assert refuses(section, name, value)


@pytest.mark.parametrize(
    "bad", [3.0, (1.0,), (1.0, 2.0, 3.0), (math.nan, 1.0), (0.1, math.inf), ("a", "b"), (-1.0, 2.0)]
)
@pytest.mark.parametrize(("section", "name"), PAIRS)
def test_pair_that_is_none_is_refused_by_name(section, name, bad):
    assert refuses(section, name, bad)


@pytest.mark.parametrize(("section", "name"), INTERVALS)
def test_interval_that_runs_backwards_is_refused_by_name(section, name):
    assert refuses(section, name, (2.0, 1.0))


@pytest.mark.parametrize(("section", "name"), CHOICES)
def test_unknown_choice_is_refused_with_the_nearest(section, name):
    value = getattr(SECTIONS[section], name)
    with pytest.raises(ValueError, match=re.escape(f"Did you mean {value!r}")):
        make_params(**{section: {name: value + "e"}})


@pytest.mark.parametrize(
    ("options", "nearest"),
    [
        ({"task": "transprt"}, "transport"),
        ({"scenario": "noise"}, "noisy"),
        ({"preset": "tnk"}, "tank"),
        ({"action_mode": "thruster"}, "thrusters"),
        ({"gaol": (0, 0, 0)}, "goal"),
        ({"num_boat": 3}, "num_boats"),
        ({"sensor": {}}, "sensors"),
        ({"time_limits": 3}, "time_limit"),
        ({"boat": {"lenght": 0.1}}, "length"),
        ({"water": {"curent": "gyre"}}, "current"),
        ({"task_params": {"aerna": 2.0}}, "arena"),
    ],
)
def test_unknown_name_is_refused_with_the_nearest(options, nearest):
    with pytest.raises(ValueError, match=f"Did you mean {nearest!r}"):
        make_params(**options)


@pytest.mark.parametrize("section", SECTIONS)
def test_section_that_is_no_mapping_is_refused_by_name(section):
    with pytest.raises(TypeError, match=section.removesuffix("_params")):
        make_params(**{section: 3})


@pytest.mark.parametrize("team", [1, 0, -4, 101, 2.5, 4.0, True, "4", math.nan, [4]], ids=repr)
def test_team_size_that_is_none_is_refused(team):
    with pytest.raises(ValueError, match="num_boats"):
        make_params(num_boats=team)


@pytest.mark.parametrize(("team", "length"), [(10, 0.40), (4, 0.19), (2, 0.19), (3, 0.25)])
def test_team_that_does_not_fit_the_vessel_is_refused(team, length):
    with pytest.raises(ValueError, match=f"{team} boats .* do not fit .* length {length:g}"):
        make_params(num_boats=team, vessel={"length": length})


@pytest.mark.parametrize(
    "goal",
    [(3.1, 0, 0), (0, -3.1, 0), (math.nan, 0, 0), (0, 0, math.inf), (0, 0), (0,) * 4, 5, "abc"],
    ids=repr,
)
def test_goal_outside_the_arena_or_malformed_is_refused(goal):
    with pytest.raises(ValueError, match="goal"):
        make_params(goal=goal)
    with pytest.raises(ValueError, match="goal"):
        Simulation(make_params()).reset(goal=goal)


def test_goal_outside_the_arena_of_a_preset_is_refused():
    with pytest.raises(ValueError, match="arena"):
        make_params(preset="tank", goal=(1.6, 0, 0))


@pytest.mark.parametrize(
    "clock", [{"physics": 55}, {"sensing": 15}, {"control": 3}, {"control": 20}, {"physics": 5}]
)
def test_clocks_that_do_not_divide_are_refused(clock):
    with pytest.raises(ValueError, match="multiple"):
        make_params(clock=clock)


@pytest.mark.parametrize("rate", [50.0, np.int64(50), np.float64(50)], ids=repr)
def test_rate_that_is_accepted_can_be_run(rate):
    try:
        sim = Simulation(make_params(clock={"physics": rate}))
    except (ValueError, TypeError):
        return
    sim.reset(seeds=[0])
    sim.step(np.zeros((1, 4, 2)))


def test_annulus_without_room_for_the_team_is_refused():
    with pytest.raises(ValueError, match=r"start_distance|start_spacing"):
        Simulation(make_params(start_spacing=20.0)).reset()


def test_annulus_that_reaches_into_the_vessel_is_refused():
    with pytest.raises(ValueError, match="start_distance"):
        Simulation(make_params(start_distance=(0.01, 0.1), start_spacing=1.0)).reset()


def test_goals_beyond_the_walls_are_refused():
    with pytest.raises(ValueError, match="goal_distance"):
        Simulation(make_params(water={"walls": 0.6}, goal_distance=(1.0, 1.2))).reset()


@pytest.mark.parametrize("count", [0, -1, 1.5, True, "2"], ids=repr)
def test_number_of_worlds_or_threads_that_is_none_is_refused(count):
    with pytest.raises(ValueError, match="num_worlds"):
        Simulation(make_params(), count)
    with pytest.raises(ValueError, match="num_threads"):
        Simulation(make_params(), 2, count)


def begun():
    sim = Simulation(make_params())
    sim.reset(seeds=[0])
    return sim


@pytest.mark.parametrize("shape", [(4, 2), (1, 4), (1, 3, 2), (2, 4, 2), (1, 4, 3)])
def test_action_of_the_wrong_shape_is_refused(shape):
    with pytest.raises(ValueError, match=r"must be \(1, 4, 2\)"):
        begun().step(np.zeros(shape))


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_action_that_is_not_finite_is_refused_with_its_place(bad):
    action = np.zeros((1, 4, 2))
    action[0, 2, 1] = bad
    with pytest.raises(ValueError, match="boat 2 in world 0"):
        begun().step(action)


def test_action_that_is_no_number_is_refused():
    with pytest.raises(TypeError, match="action"):
        begun().step("left")


def test_refused_action_changes_nothing():
    sim = begun()
    before = sim.state.motion.copy()
    with pytest.raises(ValueError, match="finite"):
        sim.step(np.full((1, 4, 2), math.nan))
    np.testing.assert_array_equal(sim.state.motion, before)
    assert sim.state.tick == 0


def test_finite_action_is_clipped():
    wild, full = begun(), begun()
    wild.step(np.full((1, 4, 2), 1e6))
    full.step(np.ones((1, 4, 2)))
    np.testing.assert_array_equal(wild.state.motion, full.state.motion)


def test_step_before_reset_is_refused():
    with pytest.raises(RuntimeError, match="reset"):
        Simulation(make_params()).step(np.zeros((1, 4, 2)))


def test_steps_past_the_end_are_refused():
    sim = Simulation(make_params(time_limit=0.1))
    sim.reset(seeds=[0])
    with pytest.raises(RuntimeError, match=r"world 0 .* reset"):
        [sim.step(np.zeros((1, 4, 2))) for _ in range(3)]


@pytest.mark.parametrize("seed", [-1, 1.5, True, "a"], ids=repr)
def test_seed_that_is_none_is_refused(seed):
    with pytest.raises(ValueError, match="seed"):
        Simulation(make_params()).reset(seeds=[seed])


@pytest.mark.parametrize("mask", [[True], [1, 0], [[True, False]]], ids=repr)
def test_mask_of_the_wrong_shape_or_type_is_refused(mask):
    with pytest.raises(ValueError, match="mask"):
        Simulation(make_params(), 2).reset(np.array(mask))


# ------------------------------------------------------------------ sizes


@pytest.mark.parametrize(
    ("team", "length"), [(2, 0.40), (4, 0.40), (6, 0.40), (7, 0.45), (10, 0.675), (100, 7.425)]
)
def test_vessel_grows_when_the_team_would_not_fit(team, length):
    assert make_params(num_boats=team).vessel.length == approx(length)


def test_longer_vessel_is_heavier_and_drags_more():
    vessel, nominal = make_params(num_boats=10).vessel, VesselParams()
    k = 0.675 / 0.40
    assert (vessel.width, vessel.fins) == (nominal.width, nominal.fins)
    assert vessel.surge == approx((nominal.surge[0] * k**0.5, nominal.surge[1]))
    assert vessel.mass == approx(nominal.mass * k)
    assert vessel.added_mass == approx((nominal.added_mass[0], nominal.added_mass[1] * k))
    assert vessel.sway == approx((nominal.sway[0] * k, nominal.sway[1] * k))
    assert vessel.yaw == approx((nominal.yaw[0] * k**3, nominal.yaw[1] * k**4))
    plank = vessel.mass * (vessel.length**2 + vessel.width**2) / 12
    assert vessel.total_inertia - vessel.added_inertia == approx(plank)


def test_task_scales_with_the_vessel():
    params = make_params(num_boats=10)
    task, length = params.task, params.vessel.length
    assert task.goal_distance == approx((length, 3 * length))
    assert task.start_distance == approx((1.25 * length, 3.75 * length))
    assert task.arena == approx(7.5 * length)
    assert task.position_tolerance == approx(length / 8)
    assert task.time_limit == approx(180 * length / 0.40)
    assert task.heading_tolerance == TaskParams().heading_tolerance


@pytest.mark.parametrize(
    ("task", "seconds"), [("approach", 120), ("push", 120), ("transport", 180)]
)
def test_time_limits_are_those_of_the_design(task, seconds):
    params = make_params(task)
    assert params.task.time_limit == seconds
    assert params.time_limit_ticks == seconds * 10


def test_nominal_task_is_that_of_the_design():
    task = make_params().task
    assert task.goal_distance == approx((0.4, 1.2))
    assert task.start_distance == approx((0.5, 1.5))
    assert (task.start_spacing, task.arena) == (1.5, 3.0)
    assert (task.position_tolerance, task.heading_tolerance) == (0.05, 0.1)
    assert (task.delivery, task.delivery_time) == ("holding", 3.0)
    assert (task.speed_tolerance, task.yaw_rate_tolerance) == (0.002, 0.01)
    assert (task.passing_speed, task.passing_yaw_rate) == (0.01, 0.05)
    assert (task.slot_distance, task.slot_angle, task.slot_speed) == (0.03, 0.3, 0.02)
    assert (task.hold_time, task.end_gap) == (1.0, 0.005)
    assert (task.side, task.goal_anchor) == ("+n", "world")


def test_nominal_clocks_are_those_of_the_design():
    params = make_params()
    assert params.clock == ClockParams(physics=50, sensing=10, control=10)


def test_explicit_parameters_win():
    params = make_params(
        num_boats=10,
        scenario="noisy",
        preset="experiment",
        vessel={"length": 0.9, "mass": 5.0},
        sensors={"position_noise": 0.03},
        clock={"physics": 200},
        arena=4.0,
        goal=None,
    )
    assert (params.vessel.length, params.vessel.mass) == (0.9, 5.0)
    assert (params.sensors.position_noise, params.sensors.heading_noise) == (0.03, 0.05)
    assert params.clock == ClockParams(physics=200, sensing=20, control=10)
    assert (params.task.arena, params.task.goal) == (4.0, None)


@pytest.mark.parametrize("length", [0.8, 0.2])
def test_given_length_scales_vessel_and_task(length):
    params = make_params(num_boats=2, boat={"width": 0.05}, vessel={"length": length})
    assert params.vessel.mass == approx(0.6 * length / 0.4)
    assert params.task.arena == approx(7.5 * length)


def test_section_as_a_whole_is_taken_as_it_is():
    boat, task = BoatParams(thrust=0.02), TaskParams(arena=2.0)
    params = make_params(boat=boat, task_params=task)
    assert params.boat == boat
    assert params.task == task


def test_parameters_cannot_be_changed_behind_the_environment():
    with pytest.raises(AttributeError):
        make_params().boat.mass = 1.0


def test_headings_of_goals_are_wrapped():
    assert make_params(goal=(0, 0, 7.0)).task.goal[2] == approx(7.0 - 2 * math.pi)
    assert make_params(goal=(0, 0, -math.pi)).task.goal[2] == approx(math.pi)


# ------------------------------------------------------------------ presets


def test_experiment_runs_at_the_rates_of_the_paper():
    params = make_params(preset="experiment")
    assert params.clock == ClockParams(physics=100, sensing=20, control=10)
    assert params.task.goal == approx((0.55, -0.95, 0.1))
    assert params.task.goal_anchor == "closure"
    assert (params.num_boats, params.vessel) == (4, VesselParams())


def test_paper_simulation_has_ten_boats_that_weigh_what_the_vessel_does():
    params = make_params(preset="paper_simulation")
    assert params.num_boats == 10
    assert params.vessel.mass == approx(10 * params.boat.mass)
    assert params.clock == ClockParams(physics=50, sensing=50, control=50)


@pytest.mark.parametrize(("team", "mass"), [(4, 0.1), (10, 0.05), (20, 0.1)])
def test_masses_of_the_paper_simulation_add_up_for_every_team(team, mass):
    params = make_params(num_boats=team, preset="paper_simulation", boat={"mass": mass})
    assert params.vessel.mass == approx(team * mass)


@pytest.mark.parametrize("team", [4, 10, 30, 100])
def test_hulls_of_the_paper_simulation_fit_the_nominal_plank(team):
    params = make_params(num_boats=team, preset="paper_simulation")
    assert params.vessel.length == 0.40
    assert params.boat.width < params.pitch
    assert params.boat.length / params.boat.width == approx(0.12 / 0.065)


def test_paper_simulation_has_plain_linear_damping():
    vessel, boat = make_params(preset="paper_simulation").hulls()
    for hull in (vessel, boat):
        assert {hull.surge[1], hull.sway[1], hull.yaw[1]} == {0.0}
        assert min(hull.surge[0], hull.sway[0], hull.yaw[0]) > 0


def test_inertia_of_the_paper_simulation_follows_from_its_masses():
    vessel = make_params(preset="paper_simulation").vessel
    plank = vessel.mass * (0.40**2 + 0.15**2) / 12
    assert vessel.total_inertia - vessel.added_inertia == approx(plank)


def test_tank_is_three_metres_square_and_all_begins_inside_it():
    params = make_params(preset="tank")
    assert params.water.walls == 1.5
    assert params.task.arena == 1.5
    sim = Simulation(params, 32)
    sim.reset(seeds=range(32))
    assert np.abs(sim.state.motion[..., :2]).max() < 1.5 - params.boat.length / 2
    assert np.abs(sim.state.goal[:, :2]).max() < 1.5 - params.vessel.width / 2


@pytest.mark.parametrize(
    "preset", ["nominal", "experiment", "paper_simulation", "tank", "tank-calibrated"]
)
@pytest.mark.parametrize("task", ["approach", "push", "transport"])
def test_every_preset_runs_every_task(preset, task):
    params = make_params(task, preset=preset)
    sim = Simulation(params)
    sim.reset(seeds=[0])
    step = sim.step(np.ones((1, params.num_boats, 2)))
    assert np.isfinite(step.observation).all()
    assert np.isfinite(step.reward).all()


# ------------------------------------------------------------------ scenarios


def what_differs(scenario):
    """Fields of a scenario's parameters that are not the nominal ones."""
    nominal, params = make_params(), make_params(scenario=scenario)
    return {
        f.name: getattr(getattr(params, section.name), f.name)
        for section in fields(EnvParams)
        if section.name in (*SECTIONS, "task")
        for f in fields(getattr(params, section.name))
        if getattr(getattr(params, section.name), f.name)
        != getattr(getattr(nominal, section.name), f.name)
    }


NOISE = {
    "position_noise": 0.01,
    "heading_noise": 0.05,
    "speed_noise": 0.01,
    "yaw_rate_noise": 0.1,
}
GYRE = {"current": "double_gyre", "current_speed": 0.02}
MISMATCH = {
    "thrust": 0.15,
    "lag": (0.05, 0.3),
    "drag": 0.3,
    "mass": 0.2,
    "friction": (0.1, 0.6),
}


@pytest.mark.parametrize(
    ("scenario", "values"),
    [
        ("nominal", {}),
        ("noisy", NOISE),
        ("current", {"current": "uniform", "current_speed": 0.01}),
        ("gyre", GYRE),
        ("mismatch", MISMATCH),
        ("failure", {"failures": 1}),
        ("harsh", {**NOISE, **GYRE, **MISMATCH, "failures": 1}),
    ],
)
def test_scenario_has_the_values_of_the_design(scenario, values):
    assert what_differs(scenario) == values


def test_nominal_world_is_still_exact_and_as_it_should_be():
    params = make_params()
    assert params.water.current == "still"
    assert params.sensors.exact
    assert params.variation == VariationParams()
    assert params.variation.failure_time == (5.0, 60.0)


def test_linear_drag_is_a_preset_of_the_same_model():
    params = make_params(water={"drag": "linear"})
    quadratic = replace(params, water=WaterParams())
    for linear, full in zip(params.hulls(), quadratic.hulls(), strict=True):
        assert linear.surge[1] == 0
        assert linear.surge[0] > full.surge[0]
