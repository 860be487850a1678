"""Froude's law: a world of another size does the same, with times that grow as the root."""

from dataclasses import fields

import numpy as np
import pytest
from helpers import World, bodies, open_water, successes

from asv_env import Simulation, make_params
from asv_env.params import BoatParams, ClockParams
from asv_env.params.literature import CRAFT
from asv_env.params.scaling import EXPONENTS, MOTION, scaled
from asv_env.presets import SCENARIOS, SECTIONS
from baselines.rollout.loop import rollout
from baselines.scripted import ScriptedPolicy

DIMENSIONLESS = {
    *("inertia", "astern", "thrust_law", "drag", "current", "current_heading", "contact_friction"),
    *("gyre_phase", "load", "boat_size", "failure_clock", "goal_bearing", "goal_turn"),
    *("shelter", "heading_noise", "shared", "dropout", "acceleration", "vessel_acceleration"),
    *(
        "thrust",
        "thrust_bias",
        "mass",
        "friction",
        "failures",
        "name",
        "goal_anchor",
        "side",
    ),
    *("start_spacing", "heading_tolerance", "delivery", "water_tolerance", "slot_angle"),
    *("closure", "precision", "success", "accuracy", "strayed", "nearing_tolerance"),
}
"""Fields that may lack a power of the scale; ``EXPONENTS`` has the others."""
SLOW = {"control": 5, "sensing": 5}  #: rates that are fast for craft, Hz
BIG = 4  #: scale at which rates of clocks stay whole, and rounding stays the same


@pytest.mark.parametrize("kind", EXPONENTS, ids=lambda kind: kind.__name__)
def test_every_number_has_its_power_of_the_scale(kind):
    names = {f.name for f in fields(kind)}
    assert set(EXPONENTS[kind]) <= names
    assert names - set(EXPONENTS[kind]) <= DIMENSIONLESS


def trajectories(params, seeds, ticks):
    """Motions (ticks, W, B, 6) and rewards (ticks, W, A) of the scripted policy."""
    simulation = Simulation(params, len(seeds))
    steps = rollout(simulation, ScriptedPolicy(params).act, seeds, ticks)
    found = [(simulation.state.motion.copy(), tick.step.reward) for tick in steps]
    return tuple(map(np.array, zip(*found, strict=True)))


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_scaled_world_does_the_same(scenario):
    """A push with every scenario's disturbances; with all at once from the boats' approach on."""
    task, ticks = ("transport", 450) if scenario == "harsh" else ("push", 120)
    seeds = range(2)
    motion, reward = trajectories(make_params(task, scenario=scenario), seeds, ticks)
    big, big_reward = trajectories(make_params(task, scenario=scenario, scale=BIG), seeds, ticks)
    np.testing.assert_allclose(big / float(BIG) ** np.array(MOTION), motion, rtol=0, atol=1e-9)
    np.testing.assert_allclose(big_reward, reward, rtol=0, atol=1e-9)
    assert np.abs(motion[-1, :, 0, :2]).max() > 0.05


def test_boats_of_a_scaled_world_observe_the_same():
    for scenario in ("nominal", "noisy"):
        worlds = [Simulation(make_params(scenario=scenario, scale=scale), 3) for scale in (1, BIG)]
        small, big = (world.reset(seeds=[0, 1, 2]) for world in worlds)
        np.testing.assert_allclose(big, small, rtol=0, atol=1e-6)
        action = np.full((3, 4, 2), 0.4, np.float32)
        for _ in range(50):
            small, big = (world.step(action).observation for world in worlds)
        np.testing.assert_allclose(big, small, rtol=0, atol=1e-5)


def test_scaled_boats_ram_slide_and_hit_walls_alike():
    def run(scale):
        params = open_water(3, control=10, scale=scale, arena=1.5 * scale, goal=(scale, 0, 0),
            water={"walls": 1.5 * scale}, clock=scaled(ClockParams(control=10), scale),
        )  # fmt: skip
        start = bodies((), (0.1, 0.2, -1.2, 0, -0.2), (-0.05, 0.14, -1.5), (1.3, 1.2, 0.5, 0.2))
        units = float(scale) ** np.array(MOTION)
        world = World(params, start * units)
        return world.record(10 * scale**0.5, [(1, 0.7), (0.6, 1), (1, 1)]) / units

    np.testing.assert_allclose(run(BIG), run(1), rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", CRAFT)
def test_craft_push_a_barge_as_long_for_them_as_the_nominal_one(name):
    params, craft = make_params(preset=name), CRAFT[name]
    assert params.boat == craft.boat
    assert params.scale == craft.scale
    assert params.vessel.length == pytest.approx(0.4 * craft.scale)
    assert params.vessel.width == pytest.approx(0.15 * craft.scale)
    assert params.task.time_limit == pytest.approx(180 * craft.scale**0.5)


def test_four_otters_push_a_barge_of_six_metres_seventy():
    vessel = make_params(preset="otter").vessel
    assert (vessel.length, vessel.width) == pytest.approx((6.67, 2.5), abs=0.01)


@pytest.mark.parametrize("name", CRAFT)
def test_scripted_team_of_craft_delivers_its_barge(name):
    scale = CRAFT[name].scale
    goal = (0.1 * scale, -0.5 * scale, 0.0)
    params = make_params(preset=name, delivery="passing", goal=goal, clock=SLOW)
    assert successes(ScriptedPolicy, params, 4, enough=3) == 3


def test_parameters_come_back_from_another_scale():
    params = make_params(scenario="harsh", goal=(0.4, -0.5, 0.3))
    there = params.rescaled(BIG)
    assert there.scale == BIG
    assert there.boat.mass == pytest.approx(params.boat.mass * BIG**3)
    assert there.rescaled(1 / BIG) == params
    for name in SECTIONS:
        assert type(getattr(there, name)) is type(getattr(params, name))


def test_reynolds_numbers_are_not_kept():
    """What the scale changes and the model does not: a world twice as long has 2^1.5 of them."""
    boat = scaled(BoatParams(), 2.0)
    before = BoatParams().full_speed * BoatParams().length
    assert boat.full_speed * boat.length == pytest.approx(2**1.5 * before)


@pytest.mark.parametrize("scale", [0.0, -1.0, float("nan"), 1e9, "big"])
def test_scales_that_make_no_sense_are_refused(scale):
    with pytest.raises(ValueError, match="scale = "):
        make_params(scale=scale)
