"""Parameters are values, whatever they were given as; what is none is refused by its name."""

import copy
import inspect
import math
import pickle
from collections import deque
from dataclasses import fields, replace
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from asv_env import FEATURES, HULLS, PRESETS, SCENARIOS, TASKS, Simulation, make_params
from asv_env.checks import Name, Number, Pair, Truth, UnknownOptionError, Whole, fields_checked
from asv_env.params import BoatParams, EnvParams, TaskParams, VesselParams, WaterParams
from asv_env.params.outlines import Outline
from asv_env.presets import SECTIONS, TASK_OPTIONS
from asv_env.sensing.observation import LENGTH, NAMES, Feature, scalar
from asv_env.tasks import TRANSPORT, Task

ARGUMENTS = [n for n in inspect.signature(make_params).parameters if n != "options"]
OPTIONS = [*ARGUMENTS, *TASK_OPTIONS, *(s for s in SECTIONS if s != "task"), "task_params"]
FIELDS = [
    ("task_params" if section == "task" else section, name, check)
    for section, kind in SECTIONS.items()
    for name, (check, _) in fields_checked(kind).items()
] + [("boat", "bow", Number(1e-9, 0.065))]
NUMERIC = [field for field in FIELDS if not isinstance(field[2], Name | Truth | Outline)]


def plain(value):
    """Whether a value consists of Python's own numbers, texts and tuples."""
    if type(value) is tuple:
        return all(map(plain, value))
    return value is None or type(value) in (bool, float, int, str)


def all_plain(params):
    sections = [getattr(params, name) for name in SECTIONS]
    return all(plain(getattr(s, f.name)) for s in sections for f in fields(s)) and plain(
        (params.num_boats, params.action_mode, params.observation)
    )


# ------------------------------------------------------------------ equal content, equal values

LAG = {"variation": {"lag": (0.25, 0.5)}}
SAME = [
    ({"goal": (0.5, -0.25, 0.0)}, {"goal": np.array([0.5, -0.25, 0.0])}),
    ({"goal": (0.5, -0.25, 0.0)}, {"goal": [np.float32(0.5), Fraction(-1, 4), 0]}),
    ({"goal": (1.0, 0.0, 0.0)}, {"goal": np.array([1, 0, 0], dtype=np.int8)}),
    ({"goal": (1.0, 0.0, 0.0)}, {"goal": deque([1, 0, 0])}),
    ({"goal_distance": (0.0, 1.0)}, {"goal_distance": range(2)}),
    ({"goal_distance": (0.5, 0.75)}, {"goal_distance": np.array([0.5, 0.75], dtype=np.float16)}),
    ({"goal_distance": (0.5, 0.75)}, {"goal_distance": [np.array(0.5), np.float64(0.75)]}),
    ({"time_limit": 60.0}, {"time_limit": np.array(60)}),
    ({"time_limit": 0.5}, {"time_limit": Fraction(1, 2)}),
    ({"num_boats": 6}, {"num_boats": np.int64(6)}),
    ({"num_boats": 6}, {"num_boats": np.array(6, dtype=np.uint8)}),
    ({"side": "goal"}, {"side": np.str_("goal")}),
    ({"action_mode": "thrusters"}, {"action_mode": np.array("thrusters")}),
    ({"preset": "tank"}, {"preset": np.str_("tank")}),
    ({"task": "push"}, {"task": np.str_("push")}),
    ({"vessel": "no-fins"}, {"vessel": np.str_("no-fins")}),
    ({"clock": {"physics": 100}}, {"clock": {"physics": np.int32(100)}}),
    ({"boat": {"surge": (0.25, 0.5)}}, {"boat": {"surge": np.array([0.25, 0.5])}}),
    ({"water": {"walls": 5.0}}, {"water": WaterParams(walls=np.float32(5))}),
    ({"scenario": LAG}, {"scenario": {"variation": {"lag": [0.25, 0.5]}}}),
    (LAG, {"scenario": {"variation": {"lag": np.array([0.25, 0.5])}}}),
    ({"scenario": "noisy"}, {"scenario": SCENARIOS["noisy"]}),
    ({"sensors": {"shared": False}}, {"sensors": {"shared": np.bool_(0)}}),
    ({"observation": ("slot", "goal")}, {"observation": np.array(["slot", "goal"])}),
    ({"observation": tuple(FEATURES)}, {"observation": FEATURES}),
]  # fmt: skip


@pytest.mark.parametrize(("one", "other"), SAME, ids=lambda options: repr(options)[:40])
def test_equal_content_makes_equal_parameters(one, other):
    first, second = make_params(**one), make_params(**other)
    assert first == second
    assert hash(first) == hash(second)
    assert all_plain(first)
    assert all_plain(second)


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("scenario", SCENARIOS)
def test_parameters_of_every_preset_and_scenario_are_values(preset, scenario):
    params = make_params(preset=preset, scenario=scenario)
    assert all_plain(params)
    for again in (pickle.loads(pickle.dumps(params)), copy.deepcopy(params), replace(params)):
        assert again == params
        assert hash(again) == hash(params)


def test_what_the_caller_holds_can_change_afterwards():
    ends, pose, drag = [0.4, 0.8], np.array([0.5, 0.0, 0.0]), [0.1, 0.2]
    names, terms, scale = ["slot", "goal"], list(TRANSPORT.reward), [1.0]
    feature = replace(scalar("one", 1.0, 1.0, None), scale=scale)
    task = replace(TRANSPORT, name="mine", reward=terms)
    scenario = {"variation": {"lag": [0.1, 0.2]}}
    options = {"scenario": scenario, "boat": {"sway": drag}, "goal": pose, "goal_distance": ends}
    params = make_params(task, observation=names, **options)
    twin = make_params(task, observation=names, **options)
    before = hash(params)
    for given_list in (ends, drag, names, terms, scale, scenario["variation"]["lag"]):
        given_list.clear()
    pose[:] = 9.0
    assert (params, hash(params)) == (twin, before)
    assert len(task.reward) == len(TRANSPORT.reward)
    assert feature.scale == (1.0,)


def test_replaced_sections_are_values_too():
    params = replace(make_params(), observation=["slot"], num_boats=np.int64(4))
    assert all_plain(params)
    assert replace(params.task, goal=np.ones(3)).goal == (1.0, 1.0, 1.0)
    assert replace(params.vessel, sway=np.ones(2)).sway == (1.0, 1.0)


# ------------------------------------------------------------------ tables


def tables():
    return [
        SCENARIOS["harsh"],
        SCENARIOS["harsh"]["sensors"],
        SCENARIOS["mismatch"]["variation"],
        HULLS["no-fins"],
        PRESETS["tank"],
        PRESETS["experiment"]["task"],
        SECTIONS,
    ]


@pytest.mark.parametrize("change", [
    lambda table: table.update(fins=9.0),
    lambda table: table.__setitem__("fins", 9.0),
    lambda table: table.setdefault("other", {}),
    lambda table: table.popitem(),
    lambda table: table.clear(),
    lambda table: table.pop(next(iter(table))),
    lambda table: table.__delitem__(next(iter(table))),
    lambda table: table.__ior__({"fins": 9.0}),
])  # fmt: skip
def test_public_tables_cannot_be_changed(change):
    for table in tables():
        before = dict(table)
        with pytest.raises(TypeError, match="read-only"):
            change(table)
        assert table == before


def test_tables_can_be_copied_pickled_and_joined():
    noise = SCENARIOS["harsh"]["sensors"]
    assert pickle.loads(pickle.dumps(noise)) == copy.deepcopy(noise) == noise
    assert make_params(sensors={**noise, "position_noise": 0.5}).sensors.position_noise == 0.5
    assert dict(noise) | {"speed_noise": 0.0} != noise


def test_what_is_registered_does_not_change_with_its_source(monkeypatch):
    for registry in (SCENARIOS, TASKS):
        monkeypatch.setattr(registry, "_entries", dict(registry._entries))
    source = {"variation": {"lag": [0.1, 0.2]}}
    SCENARIOS.register("own", source)
    source["variation"]["lag"][0] = 9.0
    source["sensors"] = {"position_noise": 1.0}
    assert make_params(scenario="own") == make_params(variation={"lag": (0.1, 0.2)})
    with pytest.raises(TypeError, match="task"):
        TASKS.register("own", {"reward": ()})


def test_constant_arrays_cannot_be_written_to():
    from asv_env.sensing.observation import BOUND, bounds, chosen

    for array in (BOUND, bounds(chosen(("slot",)))):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 9.0


# ------------------------------------------------------------------ what is no value


class Odd:
    """An object whose text fails."""

    def __repr__(self):
        raise RuntimeError("no text")


JUNK = st.one_of(
    st.sampled_from([
        "", "fast", ":", "a:", ":b", "a:b:c", ".a:b", "os:path", "no_such_module:A", "0.5", b"1",
        (), [], {}, set(), {"a": 1}, {1: 2}, {"goal": 1}, object(), Odd(), len, int, np.float64,
        1j, math.nan, math.inf, -math.inf, 10**400, -(10**5000), Decimal("0.5"), True, np.bool_(1),
        [1.0], [1.0, math.nan], ["a", "b"], [[1, 2], [3, 4]], [{}], [None] * 3, range(10**9),
        np.zeros(0), np.zeros((2, 2)), np.array([True, False]), np.array(None), np.array("x"),
        np.array([1, 2], dtype=object), np.ma.masked, np.datetime64("2020-01-01"), "x" * 10_000,
        np.array([np.nan, 1.0]), np.array(1j), "\x1b[31m\n", BoatParams, WaterParams(), TRANSPORT,
    ]),
    st.floats(), st.integers(), st.complex_numbers(), st.text(max_size=5),
    st.lists(st.floats(), max_size=4), st.dictionaries(st.text(max_size=3), st.none(), max_size=2),
)  # fmt: skip


def complaint(make):
    """What the error says with which something is not made."""
    try:
        make()
    except (ValueError, TypeError) as error:
        return str(error)
    return None


def refused_by_name(name, make):
    """Asserts that it is made, or refused with the name in a printable line of some length."""
    text = complaint(make)
    if text is None:
        return
    assert name in text
    assert text.isprintable()
    assert len(text) < 1000


@settings(max_examples=600)
@given(option=st.sampled_from(OPTIONS), junk=JUNK)
def test_option_that_is_no_value_is_refused_by_its_name(option, junk):
    refused_by_name(option, lambda: make_params(**{option: junk}))


@settings(max_examples=600)
@given(field=st.sampled_from(FIELDS), junk=JUNK)
@example(field=("task_params", "goal", None), junk=np.zeros((3, 1)))
@example(field=("task_params", "name", None), junk=[])
def test_field_that_is_no_value_is_refused_by_its_name(field, junk):
    section, name, _ = field
    refused_by_name(name, lambda: make_params(**{section: {name: junk}}))


@given(section=st.sampled_from([f.name for f in fields(EnvParams)]), junk=JUNK)
def test_section_that_is_none_is_refused_by_its_name(section, junk):
    named = "task" if section == "definition" else section
    refused_by_name(named, lambda: replace(make_params(), **{section: junk}))


@pytest.mark.parametrize("scenario", [{"sensor": {}}, {"a": 1}, {"boats": {"mass": 1.0}}])
def test_scenario_with_an_unknown_section_is_refused(scenario):
    with pytest.raises(ValueError, match="section of the scenario"):
        make_params(scenario=scenario)


@pytest.mark.parametrize(
    "name", ["frameskip", "gaol", "timelimit", "num_boat", "__class__", "render_mode"]
)
def test_unknown_option_is_refused_as_python_refuses_an_argument(name):
    for kind in (TypeError, ValueError, UnknownOptionError):
        with pytest.raises(kind, match=f"unexpected keyword argument '{name}'") as caught:
            make_params(**{name: 1})
    assert "Known: action_mode, arena, boat" in str(caught.value)


# ------------------------------------------------------------------ the whole range


def edges(check):
    """Numbers of the whole range of a check, their logarithms uniform, its ends included."""
    if isinstance(check, Pair):
        pair = st.tuples(edges(Number(check.low, check.high)), edges(Number(check.low, check.high)))
        return pair.map(sorted) if check.ordered else pair
    low = math.log(max(check.low, 1e-9))
    drawn = st.floats(low, math.log(check.high)).map(math.exp)
    numbers = st.one_of(st.sampled_from([check.low, check.high]), drawn)
    numbers = numbers.map(lambda number: min(max(number, check.low), check.high))
    return numbers.map(int) if isinstance(check, Whole) else numbers


ASSIGNMENTS = st.lists(
    st.sampled_from(NUMERIC).flatmap(lambda f: st.tuples(st.just(f[:2]), edges(f[2]))),
    min_size=1,
    max_size=6,
)


@settings(max_examples=120)
@given(
    task=st.sampled_from(sorted(TASKS)),
    preset=st.sampled_from(sorted(PRESETS)),
    assignments=ASSIGNMENTS,
    in_scenario=st.booleans(),
    drag=st.sampled_from(["quadratic", "linear"]),
    current=st.sampled_from(["still", "uniform", "double_gyre"]),
    shared=st.booleans(),
)
def test_numbers_that_are_accepted_can_be_run(
    task, preset, assignments, in_scenario, drag, current, shared
):
    options = {"water": {"drag": drag, "current": current}, "sensors": {"shared": shared}}
    for (section, name), value in assignments:
        options.setdefault(section, {})[name] = value
    if in_scenario and "task_params" not in options:
        options = {"scenario": options}
    try:
        sim = Simulation(make_params(task, preset=preset, **options))
    except ValueError:
        return
    clock = sim.params.clock
    if clock.physics > 500 * clock.control:
        return  # It runs, but takes its time.
    sim.reset(seeds=[0])
    for sign in (1.0, -1.0):
        step = sim.step(np.full((1, sim.params.num_boats, 2), sign) * [1.0, -1.0])
        for array in (sim.state.motion, sim.sensed.estimate, step.observation, step.reward):
            assert np.isfinite(array).all()
        if step.ending.terminated.any() or step.ending.truncated.any():
            break


WIDE = {"start_distance": (50.0, 90.0), "arena": 100.0}
SLIM = {"width": 1e-3, "bow": 1e-3}


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ({"time_limit": 1e18}, "time_limit"),
        ({"vessel": {"width": 1e300}}, "width"),
        ({"end_gap": 1e9}, "end_gap"),
        ({"arena": 1e12}, "arena"),
        ({"clock": {"physics": 10**6, "sensing": 10**6, "control": 1}}, "physics"),
        ({"water": {"walls": 1e9}}, "walls"),
        ({"boat": {"mass": 1e-6, "added_mass": (0.0, 0.0), "thrust": 1e6}}, "thrust"),
        ({"boat": {"lever_arm": 100.0, "inertia": 1e-12, "added_inertia": 0.0}}, "lever_arm"),
        ({"boat": {"length": 90.0}, **WIDE}, "boat.length"),
        ({"vessel": {"width": 90.0}, **WIDE}, "vessel.width"),
        ({"vessel": {"length": 0.01}, "boat": SLIM, "water": {"walls": 200.0}}, "walls"),
        ({"variation": {"failure_time": (0.0, 1e30)}}, "failure_time"),
        ({"variation": {"failures": 10**30}}, "failures"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)  # fmt: skip
def test_absurd_number_is_refused_by_name_before_anything_is_built(options, named):
    with pytest.raises(ValueError, match=named):
        make_params(**options)


@pytest.mark.parametrize("count", [0, 10**7, 10**30, 2.0, math.nan, "4"], ids=repr)
def test_absurd_number_of_worlds_is_refused(count):
    with pytest.raises(ValueError, match="num_worlds"):
        Simulation(make_params(), count)
    with pytest.raises(ValueError, match="num_threads"):
        Simulation(make_params(), 1, count)


def test_the_widest_ranges_hold_for_the_largest_team():
    for boat in ({"width": 100.0}, {"width": 1e-4, "bow": 1e-4}):
        params = make_params("push", 100, boat=boat)
        assert params.vessel.length == max(0.4, 99 * (params.boat.width + 0.01))


@pytest.mark.parametrize("team", [2, 3, 4, 5])
def test_the_vessel_grows_with_wide_boats_of_every_team(team):
    params = make_params(num_boats=team, boat={"width": 0.3}, start_distance=(2.0, 4.0))
    assert params.pitch >= 0.3


@pytest.mark.parametrize(
    ("scale", "bound", "columns"),
    [
        ((1.0,), (1.0, 1.0), ()),
        ((), (), ()),
        ((0.0,), (1.0,), ()),
        ((1.0,), (math.nan,), ()),
        ((1.0,), (1.0,), ("a", "b")),
    ],
)
def test_feature_whose_columns_do_not_match_is_refused_when_it_is_made(scale, bound, columns):
    with pytest.raises(ValueError, match="feature 'odd'"):
        Feature("odd", None, scale, bound, columns)
    assert Feature("odd", None, (1.0, LENGTH), [2, 2]).columns == ("odd_1", "odd_2")


def test_names_and_definitions_are_checked_by_their_class():
    with pytest.raises(TypeError, match="task"):
        EnvParams("push")
    with pytest.raises(TypeError, match="boat"):
        EnvParams(TRANSPORT, boat={"mass": 1.0})
    with pytest.raises(ValueError, match="observation"):
        EnvParams(TRANSPORT, observation="slot")
    assert isinstance(EnvParams(TRANSPORT).definition, Task)
    assert EnvParams(TRANSPORT, vessel=VesselParams(), task=TaskParams()).task.goal is None
    assert set(make_params(observation=["slot_fine"]).observation) <= {*FEATURES, *NAMES}
