"""Pictures show the world where the camera says, are the same every time and change nothing."""

import copy
import hashlib
import os
import subprocess
import sys
from dataclasses import fields

import numpy as np
import pytest

from asv_env import make_params
from asv_env.params import Circle, Polygon
from asv_env.render import colours
from asv_env.render.backdrop import streamlines
from asv_env.render.camera import Camera, Trail
from asv_env.render.layout import Layout, round_number
from asv_env.render.viewer import Viewer
from asv_env.simulation import Simulation

SIZE = (320, 320)
HASH_OF_A_PUSH = """
import hashlib, sys
from test_render import pushed
print(hashlib.sha256(b"".join(f.tobytes() for f in pushed()[1])).hexdigest())
import pygame
print(pygame.display.get_init())
"""


def simulation(worlds=1, seed=3, **options):
    sim = Simulation(make_params(**options), worlds)
    sim.reset(seeds=[seed + k for k in range(worlds)])
    return sim


def drive(sim, speed=0.6):
    action = np.zeros((*sim.state.thrust.shape[:2], 2))
    action[..., 0] = speed
    sim.step(action)


def pushed(steps=15, size=SIZE):
    """A push, and its frames."""
    sim = simulation(task="push", goal=(0.55, -0.95, 0.1))
    viewer = Viewer(sim.params, size=size)
    frames = [viewer.draw(sim.state)]
    for _ in range(steps):
        drive(sim)
        frames.append(viewer.draw(sim.state))
    return viewer, frames, sim


def posed(
    vessel=(0.2, 0.3, 0.7), goal=(-0.5, 0.8, 2.0), boats=((0.9, 0.9, 1.2), (0.9, -0.5, -2.0))
):
    """Parameters and a state with given poses."""
    sim = simulation(task="transport", num_boats=2)
    state = copy.deepcopy(sim.state)
    state.motion[0, 0, :3], state.goal[0] = vessel, goal
    state.motion[0, 1:, :3] = boats
    return sim.params, state


def by_hand(camera, pose, u, w):
    """Column and row of the point (u, w) of a body, without any of the package's functions."""
    x = pose[0] + u * np.cos(pose[2]) - w * np.sin(pose[2])
    y = pose[1] + u * np.sin(pose[2]) + w * np.cos(pose[2])
    column = camera.middle.real + camera.scale * (x - camera.centre.real)
    row = camera.middle.imag - camera.scale * (y - camera.centre.imag)
    return column, row


def at(frame, place):
    return frame[int(place[1]), int(place[0])].astype(int)


def near(colour, other, tolerance=12):
    return np.abs(np.asarray(colour, dtype=int) - other).max(axis=-1) <= tolerance


# ---------------------------------------------------------------------- frames


@pytest.mark.parametrize("size", [(320, 240), (240, 320), (800, 800)])
def test_frame_has_the_size_that_was_asked_for(size):
    params, state = posed()
    frame = Viewer(params, size=size).draw(state)
    assert frame.shape == (size[1], size[0], 3)
    assert frame.dtype == np.uint8
    assert frame.flags.c_contiguous
    assert frame.flags.writeable


def test_default_size_is_even():
    params, state = posed()
    height, width, _ = Viewer(params).draw(state).shape
    assert height % 2 == width % 2 == 0


@pytest.mark.parametrize("size", [(321, 320), (320, 10), (0, 0), "large", (1, 2, 3), None])
def test_bad_sizes_are_refused(size):
    with pytest.raises(ValueError, match="size"):
        Viewer(make_params(), size=size)


def test_unknown_mode_is_refused_with_the_nearest():
    with pytest.raises(ValueError, match="rgb_array"):
        Viewer(make_params(), mode="rgb_arry")


# ---------------------------------------------------------------------- what is where


def test_vessel_and_goal_are_where_the_camera_says():
    params, state = posed()
    viewer = Viewer(params, size=(640, 480))
    frame = viewer.draw(state)
    vessel, length, width = params.vessel, params.vessel.length / 2, params.vessel.width / 2
    ghost = colours.mix(colours.WATER, colours.WHITE, 0.17)
    assert vessel.length * viewer.camera.scale > 40
    for pose, colour in ((state.motion[0, 0], colours.DECK), (state.goal[0], ghost)):
        for u in (-0.6, 0.6):
            for w in (-0.7, 0.7):
                inside = by_hand(viewer.camera, pose, u * length, w * width)
                assert near(at(frame, inside), colour, 20)
        for u, w in ((1.25, 0), (-1.25, 0)):
            outside = by_hand(viewer.camera, pose, u * length, w * width)
            assert not near(at(frame, outside), colour, 20)


def test_vessel_is_as_large_as_it_is():
    params, state = posed(vessel=(0.0, 0.0, 0.0))
    viewer = Viewer(params, size=(800, 800))
    deck = near(viewer.draw(state), colours.DECK)
    camera, edge = viewer.camera, 2.0 + 0.004 * viewer.camera.scale
    left, top = by_hand(camera, (0, 0, 0), -0.2, 0.075)
    right, bottom = by_hand(camera, (0, 0, 0), 0.2, -0.075)
    deck[: int(top) - 20], deck[int(bottom) + 20 :] = False, False
    rows, columns = np.nonzero(deck)
    assert left <= columns.min() <= left + edge
    assert top <= rows.min() <= top + edge
    assert right - edge <= columns.max() <= right
    assert bottom - edge <= rows.max() <= bottom


def test_boats_show_colour_and_bow():
    params, state = posed()
    viewer = Viewer(params, size=(800, 800))
    frame = viewer.draw(state)
    for boat, pose in enumerate(state.motion[0, 1:]):
        stern = by_hand(viewer.camera, pose, -0.03, 0.0)
        bow = by_hand(viewer.camera, pose, 0.052, 0.0)
        assert near(at(frame, stern), colours.boat_colour(boat), 20)
        assert near(at(frame, bow), colours.WHITE, 20)


def test_slots_are_marked_in_the_boats_colours():
    params, state = posed()
    viewer = Viewer(params, size=(800, 800))
    frame = viewer.draw(state)
    for boat, slot in enumerate(state.slot[0]):
        place = by_hand(viewer.camera, state.motion[0, 0], slot.real, slot.imag)
        assert near(at(frame, place), colours.boat_colour(boat), 60)


def test_failed_boat_is_grey():
    params, state = posed()
    state.working[0, 1] = False
    viewer = Viewer(params, size=(800, 800))
    frame = viewer.draw(state)
    grey = by_hand(viewer.camera, state.motion[0, 2], -0.045, 0.0)
    assert near(at(frame, grey), colours.FAILED, 20)
    mark = by_hand(viewer.camera, state.motion[0, 2], -0.0096, 0.0)
    assert near(at(frame, mark), colours.MARK, 40)


def test_obstacles_are_stone_and_in_view():
    shapes = [Circle((1.0, 1.0), 0.3), Polygon([(-1.0, -1.0), (-0.5, -1.0), (-0.5, -0.6)])]
    params = make_params("push", obstacles=shapes, goal=(0.5, -0.5, 0.0))
    simulation = Simulation(params)
    simulation.reset(seeds=[0])
    viewer = Viewer(params)
    frame = viewer.draw(simulation.state)
    for x, y in ((1.0, 1.0), (1.0, 1.25), (-0.6, -0.9)):
        assert near(at(frame, by_hand(viewer.camera, (0, 0, 0), x, y)), colours.STONE)
    assert not near(at(frame, by_hand(viewer.camera, (0, 0, 0), -0.9, -0.7)), colours.STONE)


def test_walls_and_land():
    sim = simulation(preset="tank")
    viewer = Viewer(sim.params, size=(800, 800))
    frame = viewer.draw(sim.state)
    assert near(at(frame, by_hand(viewer.camera, (0, 0, 0), 1.53, 0.7)), colours.LAND)
    assert not near(at(frame, by_hand(viewer.camera, (0, 0, 0), 1.48, 0.7)), colours.LAND)


def test_goal_turns_green_once_it_is_reached():
    frames = []
    for x in (0.0, 0.01):
        params, state = posed(vessel=(x, 0.0, 0.0), goal=(0.055, 0.0, 0.0))
        frames.append(Viewer(params, size=(800, 800)).draw(state))
    green = [near(frame, colours.GOOD, 30).sum() for frame in frames]
    assert green[0] == 0
    assert green[1] > 100


def test_approach_shows_no_goal():
    sim = simulation(task="approach")
    one, other = copy.deepcopy(sim.state), copy.deepcopy(sim.state)
    other.goal[...] += 1.0
    one, other = (Viewer(sim.params, size=SIZE).draw(state) for state in (one, other))
    np.testing.assert_array_equal(one, other)


def test_current_is_visible():
    frames = []
    for current in ("still", "double_gyre"):
        water = {"current": current, "current_speed": 0.02}
        sim = simulation(water=water)
        frames.append(Viewer(sim.params, size=SIZE).draw(sim.state))
    changed = (frames[0] != frames[1]).any(axis=-1)
    assert 0.02 < changed.mean() < 0.5


def test_streamlines_follow_the_water():
    upwards = {"current": "uniform", "current_speed": 0.03, "current_heading": np.pi / 2}
    camera = Camera(0j, 250.0, 160 + 160j)
    lines = streamlines(Layout(make_params(water=upwards), camera, SIZE, 0.0), 50.0, 40.0)
    drift = lines[:, -1] - lines[:, 0]
    np.testing.assert_allclose(drift, np.broadcast_to([0.0, -40.0], drift.shape), atol=1e-9)

    gyre = make_params(scenario="gyre")
    lines = streamlines(Layout(gyre, camera, SIZE, 0.0), 50.0, 40.0, steps=40)
    middle = camera.points(lines[:, 20])
    k = np.pi / gyre.water.gyre_size
    speed = np.hypot(
        np.sin(k * middle.real) * np.sin(k * middle.imag),
        np.cos(k * middle.real) * np.cos(k * middle.imag),
    )
    step = np.hypot(*(lines[:, 21] - lines[:, 20]).T)
    np.testing.assert_allclose(step, speed, atol=0.02)


# ---------------------------------------------------------------------- camera and trails


def test_camera_pixels_and_points_are_inverse():
    camera = Camera(0.3 - 0.2j, 170.0, 200 + 150j)
    points = np.array([0.3 - 0.2j, 1 + 1j, -2 + 0.5j])
    np.testing.assert_allclose(camera.pixels(points)[:2], [[200, 150], [319, -54]], atol=1e-9)
    np.testing.assert_allclose(camera.points(camera.pixels(points)), points, atol=1e-12)


@pytest.mark.parametrize("num_boats", [2, 4, 10, 40])
def test_all_is_in_view_at_the_start(num_boats):
    sim = simulation(num_boats=num_boats)
    viewer = Viewer(sim.params, size=SIZE)
    viewer.draw(sim.state)
    poses = [*sim.state.motion[0, :, :3], sim.state.goal[0]]
    places = np.array([by_hand(viewer.camera, pose, 0, 0) for pose in poses])
    assert (places > 10).all()
    assert (places < 310).all()


def test_view_is_fixed_until_a_body_leaves_it():
    params, state = posed()
    viewer = Viewer(params, size=SIZE)
    viewer.draw(state)
    first = viewer.camera
    state.tick[...] += 1
    state.motion[0, 1, :2] = 0.6, 0.8
    viewer.draw(state)
    assert viewer.camera == first
    state.tick[...] += 1
    state.motion[0, 1, :2] = 2.5, 0.8
    viewer.draw(state)
    assert viewer.camera.scale < first.scale
    column, row = by_hand(viewer.camera, state.motion[0, 1], 0, 0)
    assert 0 < column < SIZE[0]
    assert 0 < row < SIZE[1]


def test_trails_begin_with_an_episode():
    viewer, frames, sim = pushed()
    sim.reset(seeds=[3])
    np.testing.assert_array_equal(viewer.draw(sim.state), frames[0])
    other = simulation(task="push", seed=9).state
    np.testing.assert_array_equal(viewer.draw(other), Viewer(sim.params, size=SIZE).draw(other))


def test_trails_show_where_bodies_were():
    viewer, frames, sim = pushed(steps=60, size=(800, 800))
    camera = viewer.camera
    behind = by_hand(camera, (0, 0, 0), 0.0, 0.0)
    travelled = -sim.state.motion[0, 0, 1]
    assert travelled > 0.1
    trail, water = at(frames[-1], behind), colours.WATER
    assert np.linalg.norm(trail - water) > 100
    assert np.linalg.norm(trail - np.array(colours.DECK)) > 10


def test_trail_is_thinned():
    trail = Trail(spacing=0.1, limit=8)
    for tick in range(100):
        trail.record(tick, np.array([0.05 * tick, 0.0 + 0j]))
    assert len(trail.ticks) <= 8
    assert trail.ticks[0] == 0
    np.testing.assert_allclose(np.array(trail.points)[:, 0], 0.05 * np.array(trail.ticks))


def test_any_world_can_be_drawn():
    sim = simulation(worlds=3)
    alone = simulation(seed=5)
    viewer = Viewer(sim.params, size=SIZE)
    viewer.draw(sim.state, 0)
    np.testing.assert_array_equal(
        viewer.draw(sim.state, 2), Viewer(sim.params, size=SIZE).draw(alone.state)
    )


@pytest.mark.parametrize(
    ("limit", "number"), [(1.0, 1.0), (1.9, 1.0), (2.0, 2.0), (0.049, 0.02), (0.5, 0.5), (999, 500)]
)
def test_round_number(limit, number):
    assert round_number(limit) == pytest.approx(number)


# ---------------------------------------------------------------------- no bystander


def test_drawing_changes_nothing():
    plain, drawn = (simulation(task="push", scenario="harsh") for _ in range(2))
    viewer = Viewer(drawn.params, size=SIZE)
    for _ in range(40):
        before = copy.deepcopy(drawn.state)
        viewer.draw(drawn.state)
        for f in fields(before):
            np.testing.assert_array_equal(getattr(before, f.name), getattr(drawn.state, f.name))
        drive(plain)
        drive(drawn)
        assert plain.state.motion.tobytes() == drawn.state.motion.tobytes()
    assert drawn.state.touching[..., 0].any()


def test_frames_are_given_away():
    params, state = posed()
    viewer = Viewer(params, size=SIZE)
    first = viewer.draw(state)
    kept = first.copy()
    first[:] = 0
    np.testing.assert_array_equal(viewer.draw(state), kept)


def test_same_pixels_without_display_in_another_process():
    frames = pushed()[1]
    clean = {k: v for k, v in os.environ.items() if k[:3] != "SDL" and k != "DISPLAY"}
    here = os.path.dirname(os.path.abspath(__file__))
    ran = subprocess.run(
        [sys.executable, "-c", HASH_OF_A_PUSH],
        env=clean | {"PYTHONPATH": here},
        capture_output=True,
        text=True,
        check=True,
    )
    wanted = hashlib.sha256(b"".join(frame.tobytes() for frame in frames)).hexdigest()
    assert ran.stdout.split() == [wanted, "False"]


def test_pygame_is_optional_and_missed_politely():
    code = (
        "import sys; sys.modules['pygame'] = None\n"
        "import asv_env\n"
        "try:\n    import asv_env.render.viewer\n"
        "except ImportError as error:\n    print(error)\n"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "asv-env[eval]" in ran.stdout


@pytest.mark.parametrize(
    "options",
    [
        {"num_boats": 2},
        {"num_boats": 3, "task": "push"},
        {"num_boats": 100},
        {"num_boats": 100, "task": "push"},
        {"preset": "paper_simulation"},
        {"scenario": "harsh"},
        {"side": "-n", "task": "push"},
    ],
)
def test_everything_is_drawn(options):
    sim = simulation(**options)
    viewer = Viewer(sim.params, size=SIZE)
    first = viewer.draw(sim.state)
    for _ in range(3):
        drive(sim, 1.0)
    assert (viewer.draw(sim.state) != first).any()


# ---------------------------------------------------------------------- window


@pytest.fixture
def window(monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    sim = simulation(clock={"control": 50, "sensing": 50})
    viewer = Viewer(sim.params, mode="human", size=SIZE)
    yield viewer, sim
    viewer.close()


def test_window_shows_the_frame(window):
    pygame = pytest.importorskip("pygame")
    viewer, sim = window
    for _ in range(3):
        assert viewer.draw(sim.state) is None
        drive(sim)
    assert viewer.draw(sim.state) is None
    shown = pygame.surfarray.array3d(viewer._window._window.get_surface()).swapaxes(0, 1)
    assert near(shown, colours.DECK).any()


def test_window_closes_when_asked(window):
    pygame = pytest.importorskip("pygame")
    viewer, sim = window
    viewer.draw(sim.state)
    pygame.event.post(pygame.event.Event(pygame.QUIT))
    viewer.draw(sim.state)
    assert viewer.closed
    assert not pygame.display.get_init()
    assert viewer.draw(sim.state) is None
    assert not pygame.display.get_init()


def test_close_may_be_called_again(window):
    viewer, sim = window
    viewer.draw(sim.state)
    viewer.close()
    viewer.close()
    unused = Viewer(sim.params, size=SIZE)
    unused.close()
    unused.close()
