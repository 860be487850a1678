"""Rooms of the tree: imports run one way, libraries have their places, names occur once."""

import ast
import sys
from collections import Counter
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
GROUND = {
    f"asv_env.{name}"
    for name in (
        *("types", "text", "checks", "files", "geometry", "numerics", "registry", "params"),
        *("compiled", "threads", "memo", "capsules", "polygons"),
    )
}
WORLD = {
    *GROUND,
    *(f"asv_env.{name}" for name in ("arguments", "physics", "tasks", "sensing", "presets")),
}
WORLD |= {"asv_env.simulation", "asv_env.render", "asv_env.envs", "asv_env"}
POLICIES = {
    f"baselines.{name}"
    for name in ("policy", "distributed", "mirror", "paper", "scripted", "allocation", "learned")
}
RUN = {*WORLD, *POLICIES, "baselines.rollout"}
EVALUATE = "baselines.evaluate"
ROOMS = {
    # the world
    "asv_env.types": set(),
    "asv_env.text": set(),
    "asv_env.checks": {"asv_env.text"},
    "asv_env.files": set(),
    "asv_env.arguments": GROUND,
    "asv_env.numerics": set(),
    "asv_env.memo": set(),
    "asv_env.compiled": set(),
    "asv_env.threads": GROUND,
    "asv_env.registry": GROUND,
    "asv_env.geometry": GROUND,
    "asv_env.capsules": GROUND,
    "asv_env.polygons": GROUND,
    "asv_env.params": GROUND,
    "asv_env.physics": GROUND,
    "asv_env.tasks": GROUND,
    "asv_env.sensing": {*GROUND, "asv_env.physics", "asv_env.tasks"},
    "asv_env.presets": {*GROUND, "asv_env.sensing", "asv_env.tasks"},
    "asv_env.simulation": {
        *GROUND,
        *(f"asv_env.{name}" for name in ("arguments", "physics", "sensing", "tasks")),
    },
    "asv_env.render": {*GROUND, "asv_env.files", "asv_env.physics", "asv_env.tasks"},
    "asv_env.envs": WORLD - {"asv_env", "asv_env.physics"},
    "asv_env": WORLD,
    "asv_env.__main__": WORLD,
    # policies
    "baselines.policy": GROUND,
    "baselines.distributed": {*WORLD, "baselines.policy"},
    "baselines.mirror": WORLD,
    "baselines.paper": {*WORLD, "baselines.policy", "baselines.mirror"},
    "baselines.scripted": {*WORLD, "baselines.policy", "baselines.mirror", "baselines.paper"},
    "baselines.allocation": {
        *WORLD,
        *(f"baselines.{name}" for name in ("policy", "mirror", "paper", "scripted")),
    },
    "baselines.learned": {*WORLD, *POLICIES},
    # what is made with them
    "baselines.paper.tune": {*RUN},
    "baselines.scripted.tune": {*RUN},
    "baselines.allocation.tune": {*RUN, "baselines.scripted.tune"},
    "baselines.rollout": {*WORLD, *POLICIES},
    EVALUATE: RUN,
    f"{EVALUATE}.tables": {*RUN, EVALUATE},
    f"{EVALUATE}.report": {*RUN, EVALUATE, f"{EVALUATE}.tables"},
    f"{EVALUATE}.publish": {*RUN, EVALUATE, f"{EVALUATE}.tables", f"{EVALUATE}.report"},
    "baselines.reproduce": {
        *RUN,
        EVALUATE,
        *(f"{EVALUATE}.{name}" for name in ("tables", "report", "publish")),
    },
    "train": {*RUN, EVALUATE, f"{EVALUATE}.report"},
    "train.sb3": {*RUN, "train"},
    "train.rllib": {*RUN, "train"},
    "train.team": {*RUN, "train"},
}
"""What each room may import, besides itself. In ``baselines.evaluate`` and ``train``, whose modules
stand on both sides of their folders, arrows are checked module by module: there is no circle."""
OPEN = {"baselines", EVALUATE, "train"}
"""Rooms whose own modules are rooms of their own where circles are looked for."""

ONLY_IN = {
    "pymunk": {"asv_env/physics/"},
    "numba": {"asv_env/compiled.py", "asv_env/physics/native.py"},
    "llvmlite": {"asv_env/physics/native.py"},
    "pygame": {"asv_env/render/"},
    "stable_baselines3": {
        "asv_env/envs/sb3.py",
        "baselines/learned/sb3_policy.py",
        "train/sb3/",
    },
    "ray": {"train/rllib/"},
    "torchrl": {"asv_env/envs/torchrl.py", "asv_env/envs/benchmarl/"},
    "benchmarl": {"asv_env/envs/benchmarl/"},
    "hydra": {"asv_env/envs/benchmarl/"},
    "torch": {
        "asv_env/envs/sb3.py",
        "asv_env/envs/torchrl.py",
        "train/actors.py",
        "train/imitation.py",
        "train/recipe.py",
        "train/sb3/",
        "train/rllib/",
        "train/team/",
    },
    "argparse": set(),
}
"""Places of libraries: folders, which end in "/", and files."""


def files(*packages):
    """{name: path} of the Python files of packages."""
    paths = [path for name in packages for path in (ROOT / name).rglob("*.py")]
    return {path.relative_to(ROOT).as_posix(): path for path in paths}


SOURCE = files("asv_env", "baselines", "train")
PATHS = {
    name.removesuffix(".py").removesuffix("/__init__").replace("/", "."): path
    for name, path in SOURCE.items()
}
"""{dotted name: path} of all modules and packages."""


@cache
def imported(path):
    """Dotted names of the modules that a file imports, wherever in it."""
    package = path.relative_to(ROOT).parent.parts
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else ()
            module = ".".join((*base, *filter(None, [node.module])))
            found = {f"{module}.{alias.name}" for alias in node.names}
            names |= {name if name in PATHS else module for name in found}
    return names


GRAPH = {module: imported(path) & set(PATHS) - {module} for module, path in PATHS.items()}


def room(module):
    """The room in which a module lies: the longest one whose name begins its own."""
    rooms = [name for name in ROOMS if f"{module}.".startswith(f"{name}.")]
    return max(rooms, key=len, default=module)


def roots(path):
    return {name.split(".")[0] for name in imported(path)}


def test_rooms_exist():
    assert {name for name in ROOMS if name not in PATHS} == set()


@pytest.mark.parametrize("name", ROOMS)
def test_room_imports_only_what_lies_below_it(name):
    inside = [module for module in PATHS if room(module) == name]
    arrows = {room(target) for module in inside for target in GRAPH[module]} - {name}
    if name in OPEN:
        arrows = {arrow for arrow in arrows if not arrow.startswith(f"{name}.")}
    assert arrows <= ROOMS[name]


def circle(graph):
    try:
        list(TopologicalSorter(graph).static_order())
    except CycleError as error:
        return error.args[1]
    return None


def test_files_do_not_import_in_circles():
    assert circle(GRAPH) is None


def test_folders_do_not_import_in_circles():
    """Modules that lie directly in a package of packages count as rooms of their own."""

    def place(module):
        return module if room(module) in OPEN else room(module)

    folders = {}
    for module, targets in GRAPH.items():
        folders.setdefault(place(module), set()).update(map(place, targets))
    assert circle({name: targets - {name} for name, targets in folders.items()}) is None


def test_a_module_name_occurs_once():
    names = Counter(path.stem for path in SOURCE.values())
    repeated = {name for name, count in names.items() if count > 1}
    assert repeated == {"__init__", "__main__", "tune"}  # commands of packages have one name


@pytest.mark.parametrize("library", ONLY_IN)
def test_library_is_used_only_where_it_belongs(library):
    users = {name for name, path in SOURCE.items() if library in roots(path)}
    assert {user for user in users if not user.startswith(tuple(ONLY_IN[library]))} == set()


def test_libraries_are_found_where_they_are_used():
    assert "pymunk" in roots(ROOT / "asv_env/physics/basin.py")
    assert "numba" in roots(ROOT / "asv_env/compiled.py")


def test_no_file_is_long():
    lines = {
        name: path.read_text().count("\n")
        for name, path in files("asv_env", "baselines", "train", "benchmarks").items()
    }
    assert {name for name, count in lines.items() if count > 400} == set()


def test_core_needs_only_its_declared_libraries():
    core = WORLD - {"asv_env", "asv_env.envs", "asv_env.render"}
    libraries = {"numpy", "scipy", "pymunk", "numba", "llvmlite"}
    allowed = {"asv_env", *libraries, *sys.stdlib_module_names}
    for module, path in PATHS.items():
        if room(module) in core:
            assert roots(path) <= allowed, module


def test_policies_know_nothing_of_training():
    for path in files("baselines").values():
        assert not roots(path) & {"train", "tests", "ray"}


def test_no_module_draws_from_a_global_generator():
    for path in files("asv_env", "baselines").values():
        names = {
            f"{node.value.value.id}.{node.value.attr}.{node.attr}"
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
            if isinstance(node, ast.Attribute)
            and isinstance(node.value, ast.Attribute)
            and isinstance(node.value.value, ast.Name)
        }
        drawn = {name for name in names if name.startswith("np.random.")}
        assert drawn <= {"np.random.Generator", "np.random.default_rng", "np.random.SeedSequence"}
        assert "random" not in roots(path)
