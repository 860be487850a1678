"""The captions of a picture: scale and current below the water, the episode's progress above."""

import numpy as np

from asv_env.checks import TINY
from asv_env.geometry import plane, wrap
from asv_env.params import EnvParams
from asv_env.render.backdrop import FLOW_LENGTH, paint_streamline
from asv_env.render.canvas import Canvas
from asv_env.render.colours import DIM, GOOD, HEADER, INK
from asv_env.render.layout import Layout, placed, round_number
from asv_env.types import State

ROOMY = 440  #: width from which on all captions have room, px


def paint_legend(canvas: Canvas, layout: Layout) -> None:
    """Paints the bands for captions, a scale bar, and the speed of the current if there is one."""
    unit, (width, height) = layout.unit, layout.size
    for top, bottom in ((-2.0, layout.band), (height - layout.band, height + 2.0)):
        corners = [(-2.0, top), (width + 2.0, top), (width + 2.0, bottom), (-2.0, bottom)]
        canvas.fill(np.array(corners), HEADER)
    left, right, row = 14 * unit, width - 14 * unit, height - layout.band / 2
    end = left + layout.bar * layout.camera.scale
    canvas.lines(np.array([(left, row), (end, row)]), 2 * unit, INK)
    for x in (left, end):
        canvas.lines(np.array([(x, row - 5 * unit), (x, row + 5 * unit)]), 2 * unit, INK)
    text = f"{layout.bar:g} m"
    if layout.enlarged > 1:
        text += f"    boats drawn {layout.enlarged:.1f} times larger"
    canvas.write(text, (end + 10 * unit, row), "midleft", INK)
    if layout.flows:
        speed = layout.params.water.current_speed
        shown = round_number(speed)
        text = f"current {100 * shown:g} cm/s"
        right -= canvas.write(text, (right, row), "midright", INK) + 18 * unit
        columns = right + np.linspace(-FLOW_LENGTH * unit * shown / speed, 0, 11)
        paint_streamline(canvas, np.stack([columns, np.full(11, row)], axis=-1), unit, 1.6)


def paint_header(canvas: Canvas, layout: Layout, state: State) -> None:
    """Writes the time, and as the width allows the phase and the errors of one world."""
    params, width = layout.params, layout.size[0]
    pad, row = 14 * layout.unit, layout.band / 2
    colour = GOOD if at_goal(params, state) else DIM
    seconds = state.tick / params.clock.control
    canvas.write(f"{seconds:.1f} s", (width - pad, row), "midright", INK)
    if width < ROOMY:
        canvas.write(errors(params, state), (pad, row), "midleft", colour)
    else:
        canvas.write(phase(params, state), (pad, row), "midleft", INK)
        canvas.write(errors(params, state), (0.56 * width, row), "center", colour)


def paint_gust(canvas: Canvas, layout: Layout, state: State) -> None:
    """Paints the gust of the moment below the water: an arrow, full at 1.5 ``gust_speed``."""
    usual = layout.params.water.gust_speed
    if usual == 0.0:
        return
    unit, row = layout.unit, layout.size[1] - layout.band / 2
    gust = state.gust * np.array([1.0, -1.0])  # Pixels count downwards.
    speed = float(np.hypot(*gust))
    reach = 0.42 * layout.band * min(1.0, speed / (1.5 * usual)) / max(speed, TINY)
    centre = np.array([0.5 * layout.size[0] - 0.5 * layout.band, row])
    tail, head = centre - reach * gust, centre + reach * gust
    left = 0.35 * (head - tail) @ np.array([[0.0, 1.0], [-1.0, 0.0]])
    back = head - 0.45 * (head - tail)
    canvas.lines(np.array([tail, head]), 2 * unit, INK)
    canvas.lines(np.array([back + left, head, back - left]), 2 * unit, INK)
    text = f"gust {100 * speed:.1f} cm/s"
    canvas.write(text, (centre[0] + 0.6 * layout.band, row), "midleft", INK)


def phase(params: EnvParams, state: State) -> str:
    """Returns how the boats of one world stand to the vessel: closure, or who touches it."""
    team, working = params.num_boats, int(state.working.sum())
    boats = f"{team} boats" if working == team else f"{working} of {team} boats"
    if state.closed:
        return f"{boats} in closure"
    return f"{boats}, {int(state.touching[:, 0].sum())} at the vessel"


def at_goal(params: EnvParams, state: State) -> bool:
    """Returns whether the vessel of one world is within the tolerances of its goal pose."""
    task, (distance, turn) = params.task, _goal_errors(state)
    near = distance <= task.position_tolerance and abs(turn) <= task.heading_tolerance
    return near and params.definition.has_goal


def errors(params: EnvParams, state: State) -> str:
    """Returns how far one world is from success, in words."""
    if not params.definition.has_goal:
        away = np.abs(plane(state.motion)[1:] - placed(state.slot, state.motion[0]))
        return f"farthest boat {_distance(away[state.working].max())} from its slot"
    distance, turn = _goal_errors(state)
    return f"position error {_distance(distance)}    heading error {turn:+.2f} rad"


def _goal_errors(state: State) -> tuple[float, float]:
    """Returns distance, m, and signed turn, rad, of the vessel of one world from its goal."""
    error = state.motion[0, :3] - state.goal
    return float(np.hypot(error[0], error[1])), float(wrap(error[2]))


def _distance(metres: float) -> str:
    return f"{100 * metres:.1f} cm" if metres < 10 else f"{metres:.2f} m"
