"""The order in which a picture of one world is painted, from the water up to the captions."""

from asv_env.render.backdrop import paint_backdrop
from asv_env.render.camera import Trail
from asv_env.render.canvas import Canvas
from asv_env.render.captions import paint_header, paint_legend
from asv_env.render.hulls import paint_boats, paint_vessel
from asv_env.render.layout import Layout
from asv_env.render.overlays import outline_goal, paint_goal, paint_slots, paint_trails
from asv_env.types import State


def paint_still(canvas: Canvas, layout: Layout) -> None:
    """Paints what stays the same for as long as the camera does."""
    paint_backdrop(canvas, layout)
    paint_legend(canvas, layout)


def paint_moving(canvas: Canvas, layout: Layout, state: State, trail: Trail) -> None:
    """Paints what moves, and the captions about it; ``state`` is one world, without axis W."""
    has_goal = layout.params.definition.has_goal
    if has_goal:
        paint_goal(canvas, layout, state.goal)
    paint_trails(canvas, layout, state, trail)
    paint_vessel(canvas, layout, state.motion[0])
    if has_goal:
        outline_goal(canvas, layout, state)
    paint_slots(canvas, layout, state)
    paint_boats(canvas, layout, state)
    paint_header(canvas, layout, state)
