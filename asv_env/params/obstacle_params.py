"""Obstacles: shapes that are given, or a function that samples them, and the walls of a basin.

A layout of obstacles is a function of the parameters, the world's Generator, the goal pose
(x m, y m, heading rad) and the side from which the team pushes (+1 or -1). It returns shapes,
always as many of the same kinds; ``asv_env.tasks.layouts`` has those that are built in.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Annotated, Any, NamedTuple

import numpy as np

from asv_env.checks import Pair, called, check_fields, choice, numbers, plain
from asv_env.memo import by_identity
from asv_env.params.ranges import FAR, Distance, DistanceOrZero
from asv_env.polygons import area, is_simple
from asv_env.text import shown
from asv_env.types import Float, Int

WALL_THICKNESS = 0.5  #: thickness of a wall, m
WALLS = 4  #: number of walls of a basin
MOST_LENGTHS = 1e3  #: largest coordinate and radius, vessel lengths
MOST_ROWS = 1000  #: most segments of all obstacles of a world
Row = tuple[float, float, float, float, float]  #: of ``asv_env.capsules``
Point = Annotated[tuple[float, float], Pair("(x, y)", -FAR, FAR)]


@dataclass(frozen=True)
class Circle:
    """A round pillar."""

    centre: Point  #: m
    radius: Distance  #: m

    def __post_init__(self) -> None:
        check_fields(self)

    @property
    def rows(self) -> tuple[Row, ...]:
        """The capsules that the shape consists of."""
        return ((*self.centre, *self.centre, self.radius),)


@dataclass(frozen=True)
class Segment:
    """A straight pier or wall with round ends."""

    start: Point  #: m
    end: Point  #: m
    radius: DistanceOrZero = 0.01  #: half the thickness, m

    def __post_init__(self) -> None:
        check_fields(self)

    @property
    def rows(self) -> tuple[Row, ...]:
        """The capsules that the shape consists of."""
        return ((*self.start, *self.end, self.radius),)


@dataclass(frozen=True)
class Polygon:
    """A solid of any outline."""

    corners: tuple[tuple[float, float], ...]  #: three or more in order, m

    def __post_init__(self) -> None:
        object.__setattr__(self, "corners", _corners(self.corners))

    @property
    def rows(self) -> tuple[Row, ...]:
        """The capsules that the shape consists of."""
        following = (*self.corners[1:], self.corners[0])
        return tuple((*a, *b, 0.0) for a, b in zip(self.corners, following, strict=True))


Shape = Circle | Segment | Polygon
Layout = Callable[[Any, np.random.Generator, tuple[float, ...], float], Sequence[Shape]]
SHAPES = (Circle, Segment, Polygon)
FIELDS = {frozenset(f.name for f in fields(kind)): kind for kind in SHAPES}
"""Shapes by the names of their fields."""


def _corners(given: Any) -> tuple[tuple[float, float], ...]:
    """Returns corners of a polygon as pairs of floats; ValueError where they are none."""
    items = plain(given)
    listed = list(items) if isinstance(items, Sequence) and not isinstance(items, str) else []
    pairs = [(pair[0], pair[1]) for item in listed if (pair := numbers(item, 2))]
    if len(pairs) != len(listed) or not 3 <= len(pairs) <= MOST_ROWS:
        raise ValueError(
            f"Polygon.corners = {shown(given)}: give three or more corners (x, y), finite, m"
        )
    if not abs(area(pairs)) > 1e-12:
        raise ValueError(
            f"Polygon.corners = {shown(given)}: the polygon has no area; give its corners in "
            "order, or a Segment"
        )
    if not is_simple(pairs):
        raise ValueError(
            f"Polygon.corners = {shown(given)}: the outline crosses or touches itself; give the "
            "corners in their order round the obstacle"
        )
    return tuple(pairs)


def checked(given: Any) -> tuple[Shape, ...] | Layout:
    """Returns obstacles as a tuple of shapes, or the layout that samples them.

    Args:
        given: shapes, or mappings of their fields; one of them alone; None; or a layout.

    Raises:
        ValueError: something else, or shapes with values that are not allowed.
    """
    if given is None:
        return ()
    if isinstance(given, (*SHAPES, Mapping)):
        return (_shape(given),)
    if callable(given):
        return given
    if isinstance(given, Sequence) and not isinstance(given, str | bytes):
        return tuple(map(_shape, given))
    raise ValueError(
        f"obstacles = {shown(given)}: give Circle, Segment and Polygon in a list, the name of a "
        "layout, or a function that returns them"
    )


def _shape(given: Any) -> Shape:
    if isinstance(given, SHAPES):
        return given
    if isinstance(given, Mapping):
        for names, kind in FIELDS.items():
            required = {"centre", "start", "corners"} & names
            if required & given.keys():
                for name in given:
                    choice(f"field of {kind.__name__}", name, sorted(names))
                try:
                    return kind(**given)
                except TypeError as error:
                    raise ValueError(f"obstacles: {shown(dict(given))}: {error}") from error
    raise ValueError(
        f"obstacles: {shown(given)}: give a Circle(centre, radius), Segment(start, end, radius) or "
        "Polygon(corners), or a mapping of its fields"
    )


class Grouping(NamedTuple):
    """How the rows of all obstacles of a world make up obstacles: the same in every episode."""

    groups: Int  #: (G + 1,) first row of every obstacle, and the number of rows; walls come last
    walls: int  #: number of rows that are walls


@by_identity
def grouping(params: Any) -> Grouping:
    """Returns how the obstacles of an environment are grouped."""
    return grouped(params, _nominal(params))


def grouped(params: Any, shapes: Sequence[Shape]) -> Grouping:
    """Returns how shapes, and the walls of an environment, are grouped."""
    walls = 0 if params.water.walls is None else WALLS
    sizes = [*(len(shape.rows) for shape in shapes), *[1] * walls]
    groups = np.concatenate([[0], np.cumsum(sizes, dtype=np.int64)])
    groups.setflags(write=False)
    return Grouping(groups, walls)


def _nominal(params: Any) -> Sequence[Shape]:
    """Returns the obstacles of an environment, or a sample of them."""
    if isinstance(params.obstacles, tuple):
        return params.obstacles
    goal = params.task.goal or (0.0, -params.task.goal_distance[1], 0.0)
    return sampled(params, np.random.default_rng(0), goal, 1.0)


def sampled(
    params: Any, rng: np.random.Generator, goal: tuple[float, ...], side: float
) -> Sequence[Shape]:
    """Returns the shapes that a layout samples.

    Raises:
        FunctionError: the layout fails.
        ValueError: it returns something else.
    """
    name = getattr(params.obstacles, "__name__", type(params.obstacles).__name__)
    found = called("obstacles", name, params.obstacles, params, rng, goal, side)
    if callable(found):
        raise ValueError(f"obstacles {name!r} returned {shown(found)}: must be a list of shapes")
    return checked(found)  # type: ignore[return-value]


def rows(params: Any, shapes: Sequence[Shape]) -> Float:
    """Returns the rows (M, 5) of shapes, and of the walls of an environment.

    Raises:
        ValueError: there are too many, or they reach too far.
    """
    found = [row for shape in shapes for row in shape.rows]
    if len(found) > MOST_ROWS:
        raise ValueError(
            f"obstacles: {len(found)} circles, segments and edges of polygons are more than "
            f"{MOST_ROWS}; give fewer"
        )
    farthest = max((abs(number) for row in found for number in row), default=0.0)
    if farthest > MOST_LENGTHS * params.vessel.length:
        raise ValueError(
            f"obstacles: {farthest:g} m are more than {MOST_LENGTHS:g} times vessel.length = "
            f"{params.vessel.length:g} m; bring them nearer, or make them smaller"
        )
    if params.water.walls is not None:
        d = params.water.walls + WALL_THICKNESS / 2
        corners = [(-d, -d), (d, -d), (d, d), (-d, d)]
        sides = zip(corners, corners[1:] + corners[:1], strict=True)
        found += [(*a, *b, WALL_THICKNESS / 2) for a, b in sides]
    return np.array(found, dtype=np.float64).reshape(-1, 5)
