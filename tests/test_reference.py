"""The physics against an independent simulator of Fossen's models: an Otter in five manoeuvres.

``data/otter.json`` holds the pose and the velocity over ground of an Otter (centre of gravity
amidships, no cross-flow drag), every half second, in the axes of that simulator: x north, y east,
headings clockwise. Propeller speeds, rad/s, were constant but in the zig-zag.
"""

import json
from pathlib import Path

import numpy as np
import pytest
from helpers import World, bodies

from asv_env import make_params
from asv_env.params.literature import OTTER

RECORD = json.loads((Path(__file__).parent / "data/otter.json").read_text())
FIRST = 1
"""Row of the boat that repeats the manoeuvres."""
RUNS = {
    # run: (left, right) propeller speed, rad/s; (speed m/s, direction rad) of the current
    "straight_80_80": ((80, 80), (0.0, 0.0)),
    "turning_circle_100_60": ((100, 60), (0.0, 0.0)),
    "zigzag_20": ((100, 70), (0.0, 0.0)),
    "drift_current_0.5_60deg": ((0, 0), (0.5, np.radians(60))),
    "turn_in_current": ((90, 60), (0.3, np.pi / 2)),
}
FASTEST = RECORD["parameters"]["propeller_limits"][1]


def manoeuvre(name, params):
    """Motions (T, 6) of the boat at the times of the record, in its axes."""
    propellers = np.array(RUNS[name][0]) / FASTEST
    clock, times = params.clock, np.array(RECORD["runs"][name])[:, 0]
    world = World(params, bodies((), (-60, -60), (60, 60)))
    every = round(clock.control * (times[1] - times[0]))
    motions, command = [world.motion[FIRST]], propellers
    for tick in range(1, every * (len(times) - 1) + 1):
        action = command
        if name.startswith("zigzag"):
            # The propellers change over where the heading reaches 20 degrees, within a step.
            turn, rate = -world.motion[FIRST, 2], -world.motion[FIRST, 5]
            side = 1 if command is propellers else -1
            left = (np.radians(20) - side * turn) / max(side * rate * clock.dt, 1e-12)
            if left < 1:
                command = propellers[::-1] if side > 0 else propellers
                action = left * action + (1 - left) * command
        motion = world.step([action, (0.0, 0.0)])[FIRST]
        if tick % every == 0:
            motions.append(motion)
    # Mirrored: y to the other side, headings the other way round.
    found = np.array(motions) * (1, -1, -1, 1, -1, -1)
    found[:, 2] = np.unwrap(found[:, 2])
    found[:, :2] -= found[0, :2]
    return found


@pytest.fixture
def params(request):
    speed, direction = RUNS[request.param][1]
    return make_params(
        "push",
        2,
        preset="otter",
        action_mode="thrusters",
        clock={"physics": 100, "sensing": 100, "control": 100},
        water={"current": "uniform", "current_speed": speed, "current_heading": -direction},
        vessel={"length": 10.0},
        arena=1000.0,
        goal=(900.0, 900.0, 0.0),
        time_limit=1e5,
    )


@pytest.mark.parametrize(("params", "name"), [(n, n) for n in RUNS], indirect=["params"])
def test_otter_moves_as_in_the_reference(params, name):
    """Within 1 % of the length of the path and 1 degree, at every sample."""
    expected = np.array(RECORD["runs"][name])[:, 1:]
    found = manoeuvre(name, params)
    path = np.hypot(*np.diff(expected[:, :2], axis=0).T).sum()
    assert np.hypot(*(found - expected)[:, :2].T).max() < 0.01 * path
    assert np.abs(found - expected)[:, 2].max() < np.radians(1)
    cos, sin = np.cos(expected[:, 2]), np.sin(expected[:, 2])
    u, v = expected[:, 3], expected[:, 4]
    velocity = np.stack([cos * u - sin * v, sin * u + cos * v], axis=-1)
    np.testing.assert_allclose(found[:, 3:5], velocity, atol=0.02 * np.abs(velocity).max())


def test_craft_is_that_of_the_reference():
    boat, given = OTTER.boat, RECORD["parameters"]
    ahead, astern = given["propeller_limits"][1] ** 2, given["propeller_limits"][0] ** 2
    assert boat.mass == given["mass"]
    assert (boat.added_mass, boat.added_inertia) == (
        (given["added_surge"], given["added_sway"]),
        given["added_yaw"],
    )
    assert (boat.inertia, boat.length) == (given["Iz"], given["length"])
    assert boat.surge == pytest.approx((given["Xu"], 0.0))
    assert boat.sway == (given["Yv"], 0.0)
    assert boat.yaw == (given["Nr"], given["Nrr"])
    assert (boat.lever_arm, boat.lag) == (given["lever"], given["propeller_lag"])
    assert boat.thrust == pytest.approx(given["k_pos"] * ahead, rel=1e-4)
    assert boat.astern * boat.thrust == pytest.approx(given["k_neg"] * astern, rel=1e-3)
