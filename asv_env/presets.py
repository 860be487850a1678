"""Named sets of parameters, and the one place where options become ``EnvParams``.

A *preset* is a world (the nominal one, the paper's experiment, its simulation, its tank), a
*difficulty* makes it easier or harder, a *scenario* is a set of disturbances, a *hull* is another
vessel or boat than the nominal one. Each is a mapping of the parameters that differ from the
defaults. Others are registered or given::

    SCENARIOS.register("murky", {"sensors": {"position_noise": 0.03}})
    make_params(scenario={"sensors": {"position_noise": 0.03}})
"""

from collections.abc import Mapping, Sequence
from dataclasses import MISSING, fields, is_dataclass, replace
from typing import Any

from asv_env.checks import check_num_boats, choice, plain, refuse_option
from asv_env.params import (
    NOMINAL_LENGTH,
    BoatParams,
    EnvParams,
    HullParams,
    TaskParams,
    VesselParams,
    obstacle_params,
    pitches,
    shaping,
)
from asv_env.params.env_params import round_delays
from asv_env.params.literature import CRAFT
from asv_env.params.obstacle_params import Shape
from asv_env.params.outlines import SHAPES
from asv_env.params.scaling import SCALE, overrides, scaled, scaled_shapes
from asv_env.registry import ReadOnlyDict, Registry
from asv_env.sensing import observation as observing
from asv_env.tasks import TASKS, Task, layouts
from asv_env.text import shown

Overrides = Mapping[str, Any]  #: fields that differ, by section

NOISE = {"position_noise": 0.01, "heading_noise": 0.05, "speed_noise": 0.01, "yaw_rate_noise": 0.1}
UNLIKE = {"thrust": 0.2, "boat_size": 0.15}
IN_PUSH = {"failure_clock": "closure", "failure_time": (2.0, 20.0)}
GYRE = {"current": "double_gyre", "current_speed": 0.02}
MISMATCH = {"thrust": 0.15, "lag": (0.05, 0.3), "drag": 0.3, "mass": 0.2, "friction": (0.1, 0.6)}


def _is_mapping(thing: object) -> bool:
    return isinstance(thing, Mapping)


def _are_obstacles(thing: object) -> bool:
    if isinstance(thing, tuple | list):
        return all(isinstance(each, Shape | Mapping) for each in thing)
    return callable(thing)


SCENARIOS: Registry[Overrides] = Registry(
    "scenario",
    {
        "nominal": {},
        "noisy": {"sensors": NOISE},
        "delay": {"sensors": {"delay": 0.2}},
        "dropout": {"sensors": {"dropout": 0.5}},
        "shelter": {"water": {"shelter": 0.3}},
        "current": {"water": {"current": "uniform", "current_speed": 0.01}},
        "gyre": {"water": GYRE},
        "gusts": {"water": {"gust_speed": 0.01}},
        "mismatch": {"variation": MISMATCH},
        "unlike": {"variation": UNLIKE},
        "load": {"variation": {"load": (1.0, 2.0)}},
        "failure": {"variation": {"failures": 1}},
        "failure-in-push": {"variation": {**IN_PUSH, "failures": 1}},
        "harsh": {"sensors": NOISE, "water": GYRE, "variation": {**MISMATCH, "failures": 1}},
    },
    _is_mapping,
)  #: disturbances, by name
EASY: Overrides = {
    "boat": {"full_speed": 0.1, "full_yaw_rate": 0.5},
    "task": {
        "goal_distance": (0.15, 0.3),
        "goal_bearing": 0.25,
        "goal_turn": 0.2,
        "start_distance": (0.35, 0.7),
        "position_tolerance": 0.1,
        "heading_tolerance": 0.5,
    },
}
"""Short ways ahead, to the tolerances of the paper's own trials, with commands that are gentle: a
learner that begins with large random ones keeps its grasp for longer."""
HARD: Overrides = {
    "obstacles": "dock",
    "sensors": {**NOISE, "shared": False, "range": 1.5, "delay": 0.1, "dropout": 0.1},
    "water": {"gust_speed": 0.01},
    "variation": {**UNLIKE, "load": (1.0, 2.0)},
}
"""A dock, own sensing, gusts, unlike boats and an unknown load at once."""
DIFFICULTIES: Registry[Overrides] = Registry(
    "difficulty",
    {
        "easy": EASY,
        "standard": {},
        "hard": HARD,
    },
    _is_mapping,
)
"""How hard the worlds are, by name, in lengths of the nominal vessel and at its scale."""
HULLS: Registry[Any] = Registry(
    "hull",
    {
        **{"nominal": {}, "plank": {}, "no-fins": {"fins": 0.0}},
        **{name: {"outline": name} for name in SHAPES},
    },
    lambda thing: isinstance(thing, Mapping | HullParams),
)
"""Hulls by name, for the options ``vessel`` and ``boat``.

An ``outline`` is that of a vessel, and can be the name of one of ``SHAPES``.
"""

OBSTACLES: Registry[Any] = Registry(
    "layout of obstacles",
    {
        "none": (),
        "pillars": layouts.Pillars(),
        "channel": layouts.Channel(),
        "dock": layouts.Dock(),
    },
    _are_obstacles,
)
"""Obstacles by name: layouts, or lists of shapes."""

CRAFT_CLOCK = {"physics": 50, "sensing": 5, "control": 5}
EXPERIMENT: Overrides = {
    "clock": {"physics": 100, "sensing": 20, "control": 10},
    "task": {"goal": (0.55, -0.95, 0.1), "goal_anchor": "closure", "delivery": "passing"},
}
CALIBRATED: Overrides = {"variation": {"thrust": 0.5}}
"""Disturbances by which the experiment's errors are nearest to those of the paper's tank.

``python -m baselines.reproduce.calibrate`` found them.
"""
TANK = {"arena": 1.5, "start_distance": (0.5, 1.4), "goal_distance": (0.4, 1.0)}
PRESETS: Registry[Overrides] = Registry(
    "preset",
    {
        "nominal": {},
        "experiment": EXPERIMENT,
        "tank-calibrated": {**EXPERIMENT, **CALIBRATED},
        "paper_simulation": {
            "clock": {"physics": 50, "sensing": 50, "control": 50},
            "water": {"drag": "linear"},
            "vessel": {"length": NOMINAL_LENGTH},
            "task": {"goal": (0.55, -0.95, 0.1), "delivery": "passing"},
        },
        "tank": {"water": {"walls": 1.5}, "task": TANK},
        **{name: {"boat": vars(craft.boat), "clock": CRAFT_CLOCK} for name, craft in CRAFT.items()},
    },
    _is_mapping,
)  #: worlds, by name
SCALES = ReadOnlyDict({name: craft.scale for name, craft in CRAFT.items()})
"""How many times longer than the nominal one a world is, by preset; 1 elsewhere."""
DEFAULT_TEAM = ReadOnlyDict({"paper_simulation": 10})  #: numbers of boats, by preset; 4 elsewhere

SECTIONS = ReadOnlyDict(
    {f.name: f.default_factory for f in fields(EnvParams) if f.default_factory is not MISSING}
)  #: classes of the sections of parameters, by name
TASK_OPTIONS = tuple(f.name for f in fields(TaskParams) if f.name != "name")
ARGUMENTS = (
    *("num_boats", "scenario", "preset", "difficulty", "action_mode", "observation", "scale"),
)
OF_ADAPTERS = ("render_mode", "max_episode_steps", "flat")  #: options of an environment alone
KNOWN = tuple(
    sorted({*ARGUMENTS, *OF_ADAPTERS, *TASK_OPTIONS, *SECTIONS, "task_params", "obstacles"})
)
"""Names of the options of an environment."""


def make_params(
    task: str | Task = "transport",
    num_boats: int | None = None,
    scenario: str | Overrides = "nominal",
    preset: str = "nominal",
    action_mode: str = "tracking",
    observation: Sequence[str | observing.Feature] | None = None,
    scale: float | None = None,
    difficulty: str | Overrides = "standard",
    **options: Any,
) -> EnvParams:
    """Returns the parameters of an environment from names and options.

    Options override the scenario, which overrides the difficulty, which overrides the preset.
    Names of tasks, difficulties, scenarios and hulls can also be ``"module:ATTRIBUTE"``, which is
    imported.

    Args:
        task: Name of a task, or a ``Task``.
        num_boats: Team size, 2 to 100; None takes the preset's (4, in ``paper_simulation`` 10).
        scenario: Disturbances: a name of ``SCENARIOS``, or a mapping of sections to the fields
            that differ.
        preset: World, a name of ``PRESETS``.
        action_mode: "tracking" for speed and yaw rate, "thrusters" for the two motors, or
            "discrete" for the number of one of ``asv_env.params.DISCRETE_ACTIONS``.
        observation: Features that a boat observes, names of ``FEATURES`` or ``Feature`` objects;
            None takes all built-in ones.
        scale: How many times longer the world is than the nominal one: everything that is not
            in the preset or in ``options``, the scenario included, is scaled by Froude's law;
            None takes the preset's (1, but of published craft, see ``asv_env.params.literature``).
        difficulty: How hard the worlds are: "easy", "standard", "hard" or another name of
            ``DIFFICULTIES``, or a mapping of sections to the fields that differ.
        **options: Any field of ``TaskParams`` by its name (``goal``, ``side``,
            ``time_limit`` ...), or a whole section (``boat``, ``vessel``, ``water``,
            ``sensors``, ``clock``, ``task``, ``variation``, ``reward``), as its dataclass or
            as a mapping of the fields that differ. The section ``task`` has the name
            ``task_params`` here. ``boat`` and ``vessel`` may be names of ``HULLS``.
            ``obstacles`` is a name of ``OBSTACLES``, a mapping with its ``name`` and the numbers
            that differ, a layout, or a list of ``Circle``, ``Segment`` and ``Polygon``.

    Returns:
        Validated parameters. The vessel grows with the team unless its length is given;
        distances and times of the task scale with the vessel.

    Raises:
        ValueError: an unknown name (with the nearest known one) or a value out of range.
        TypeError: a section that is neither its dataclass nor a mapping, or a task that is none.
    """
    definition = TASKS.find(task)
    preset = choice("preset", preset, PRESETS)
    team = check_num_boats(DEFAULT_TEAM.get(preset, 4) if num_boats is None else num_boats)
    given = _by_section(options)
    k = SCALE.checked("scale", SCALES.get(preset, 1.0) if scale is None else scale)
    named = {
        "preset": PRESETS[preset],
        "difficulty": DIFFICULTIES.find(difficulty),
        "scenario": SCENARIOS.find(scenario),
    }
    for kind, layer in named.items():
        for name in layer:
            choice(f"section of the {kind}", name, (*SECTIONS, "obstacles"))
    world, tier, disturbances = named.values()
    around = (_at_scale(layer, k) for layer in (tier, disturbances))
    layers: tuple[Mapping[str, Any], ...] = (world, *around, given)

    boat = _merged(scaled(_preset_boat(preset, team), k), "boat", layers)
    vessel = _vessel(boat, team, preset, k, layers)
    task_params = _task(definition, vessel.size / (k * NOMINAL_LENGTH), k, layers, tier)
    sections = {"boat": boat, "vessel": vessel, "task": task_params}
    if sections["task"].name != definition.name:
        choice("name of the task", sections["task"].name, TASKS)
        raise ValueError(
            f"task_params: its name is {sections['task'].name!r}, the task is "
            f"{definition.name!r}; leave the name out"
        )
    for name in [name for name in SECTIONS if name not in sections]:
        sections[name] = _merged(scaled(SECTIONS[name](), k), name, layers)
    if k != 1.0:  # Times and the clock's rates are scaled, so delays fall between its ticks.
        by_hand = {n: _as_mapping(layer, n) for n, layer in given.items() if n in SECTIONS}
        round_delays(sections, by_hand)
    features: Any = observation
    given_obstacles = [layer["obstacles"] for layer in layers if "obstacles" in layer]
    sections["obstacles"] = _obstacles(given_obstacles[-1]) if given_obstacles else ()
    params = EnvParams(definition, team, action_mode, features, **sections, scale=k)
    observing.features(params)
    return params


def _task(
    definition: Task, grown: float, k: float, layers: Sequence[Mapping[str, Any]], tier: Overrides
) -> TaskParams:
    """Returns the numbers of a task at scale k, for a vessel ``grown`` times the nominal length.

    Those of a preset with an arena of its own do not grow with the vessel; those of a difficulty
    always do.
    """
    world, _, *above = layers
    nominal = TaskParams(name=definition.name, time_limit=definition.time_limit)
    eased = scaled(_merged(nominal, "task", (tier,)).scaled(grown), k)
    of_tier = {name: getattr(eased, name) for name in _as_mapping(tier.get("task", {}), "task")}
    if "arena" not in _as_mapping(world.get("task", {}), "task"):
        nominal = nominal.scaled(grown)
    task: TaskParams = _merged(scaled(nominal, k), "task", (world, {"task": of_tier}, *above))
    return task


def _preset_boat(preset: str, team: int) -> BoatParams:
    """The nominal boat, shrunk in the paper's simulation so that the team fits its plank."""
    boat = BoatParams()
    if preset != "paper_simulation":
        return boat
    pitch = NOMINAL_LENGTH / max(team - 1, 1)
    return boat.scaled(min(1.0, 0.8 * pitch / boat.width))


def _vessel(
    boat: BoatParams, team: int, preset: str, k: float, layers: tuple[Mapping[str, Any], ...]
) -> VesselParams:
    """The nominal vessel at scale k, as long as the team needs, with what is given on top."""
    needed = pitches(team) * (boat.width + 0.01 * k)
    outline, layers = shaping.given_outline(layers)
    if outline is None:
        nominal = scaled(VesselParams(), k)
        stretched = nominal.stretched(max(nominal.length, needed))
        vessel = nominal.stretched(_merged(stretched, "vessel", layers).length)
    else:
        vessel = shaping.shaped(outline, needed, k, layers)
    if preset == "paper_simulation":
        # "the sum of the ASVs' weights is equal to the individual weight of the vessel"
        vessel = replace(vessel, mass=team * boat.mass, inertia=None)
    return _merged(vessel, "vessel", layers)


def _by_section(options: Mapping[str, Any]) -> dict[str, Any]:
    """Returns options sorted into sections; fields of the task come flat."""
    given: dict[str, Any] = {}
    flat: dict[str, Any] = {}
    for name, value in options.items():
        if name in TASK_OPTIONS:
            flat[name] = value
        elif name == "task_params":
            given["task"] = value
        elif name in ("boat", "vessel"):
            word = plain(value)
            given[name] = HULLS.find(word, name) if isinstance(word, str) else value
        elif name in (*SECTIONS, "obstacles") and name != "task":
            given[name] = value
        else:
            refuse_option(name, KNOWN)
    if flat:
        given["task"] = {**_as_mapping(given.get("task", {}), "task_params"), **flat}
    return given


def _at_scale(layer: Overrides, k: float) -> dict[str, Any]:
    """Returns overrides as they are in a world ``k`` times as long, obstacles among them."""
    sections = {name: section for name, section in layer.items() if name != "obstacles"}
    result = overrides(sections, SECTIONS, k)
    if "obstacles" in layer:
        result["obstacles"] = scaled_shapes(_obstacles(layer["obstacles"]), k)
    return result


def _obstacles(given: Any) -> Any:
    """Returns obstacles as ``EnvParams`` takes them, from what an option may be."""
    word = plain(given)
    if isinstance(word, Mapping) and "name" in word:
        found = OBSTACLES.find(word["name"], "obstacles")
        numbers = {name: value for name, value in word.items() if name != "name"}
        known = [f.name for f in fields(found)] if is_dataclass(found) else []
        for name in numbers:
            choice(f"number of the layout {shown(word['name'])}", name, known)
        return replace(found, **numbers) if numbers else found
    found = OBSTACLES.find(word, "obstacles") if isinstance(word, str) else word
    return obstacle_params.checked(found)


def _merged(base: Any, section: str, layers: tuple[Mapping[str, Any], ...]) -> Any:
    """Returns one section with the layers' overrides; later layers win."""
    label = "task_params" if section == "task" else section
    for layer in layers:
        if section not in layer:
            continue
        override = layer[section]
        if isinstance(override, type(base)):
            base = override
        else:
            changes = _as_mapping(override, label)
            for name in changes:
                choice(f"parameter of {label}", name, [f.name for f in fields(base)])
            if section in ("boat", "vessel") and {"length", "width", "mass"} & changes.keys():
                changes.setdefault("inertia", None)  # It follows from what is given.
            base = replace(base, **changes)
    return base


def _as_mapping(override: Any, section: str) -> dict[str, Any]:
    if is_dataclass(override) and not isinstance(override, type):
        return {f.name: getattr(override, f.name) for f in fields(override)}
    if not isinstance(override, Mapping):
        raise TypeError(
            f"{section} = {shown(override)}: give its dataclass, or a mapping of the fields "
            "that differ"
        )
    return dict(override)
