"""Imports run one way, and every heavy library has its one place."""

import ast
import sys
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent

GROUND = {"types", "checks", "geometry", "params", "presets"}
MIDDLE = {
    "basin", "water", "thrusters", "tracking", "dynamics", "sensors", "formation", "scenarios",
    "observation", "reward", "termination", "metrics",
}  # fmt: skip
TOP = {"simulation"}
LAYERS = (GROUND, MIDDLE, TOP)
"""Modules of asv_env from the ground up; all others are faces and pictures above them."""

ONLY_IN = {
    "pymunk": {"asv_env/basin.py"},
    "pygame": {"asv_env/render.py"},
    "stable_baselines3": {
        "asv_env/sb3_env.py",
        "baselines/sb3_policy.py",
        "train/networks.py",
        "train/ppo.py",
        "train/rollouts.py",
        "train/worlds.py",
    },
    "ray": {"train/rllib.py"},
    "torch": {
        "asv_env/sb3_env.py",
        "train/export.py",
        "train/imitation.py",
        "train/networks.py",
        "train/perceptron.py",
        "train/ppo.py",
        "train/rollouts.py",
        "train/rllib.py",
    },
}


def imported(path):
    """Dotted names that a file imports, wherever in it, relative ones made absolute."""
    package = path.relative_to(ROOT).parent.parts
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else ()
            module = ".".join((*base, *filter(None, [node.module])))
            names |= {module, *(f"{module}.{alias.name}" for alias in node.names)}
    return names


def files(package):
    return {path.relative_to(ROOT).as_posix(): path for path in (ROOT / package).rglob("*.py")}


def roots(path):
    return {name.split(".")[0] for name in imported(path)}


def modules():
    """{module: modules it imports} of asv_env, by short names, without the package itself."""
    paths = {Path(name).stem: path for name, path in files("asv_env").items()}
    graph = {
        name: {part[1] for dotted in imported(path) if (part := dotted.split("."))[0] == "asv_env"
               and len(part) > 1 and part[1] in paths}
        for name, path in paths.items()
    }  # fmt: skip
    return {name: graph[name] for name in graph if name != "__init__"}


def layer(module):
    """How far above the ground a module stands."""
    return next((i for i, names in enumerate(LAYERS) if module in names), len(LAYERS))


def test_layers_name_modules_that_exist():
    assert set().union(*LAYERS) <= set(modules())


@pytest.mark.parametrize("module", sorted(modules()))
def test_module_imports_nothing_from_above(module):
    assert {name for name in modules()[module] if layer(name) > layer(module)} == set()


def test_modules_do_not_import_in_circles():
    try:
        list(TopologicalSorter(modules()).static_order())
    except CycleError as error:
        pytest.fail(f"modules import each other: {error.args[1]}")


@pytest.mark.parametrize("package", ["asv_env", "baselines", "train"])
@pytest.mark.parametrize("library", ONLY_IN)
def test_library_is_used_only_where_it_belongs(package, library):
    users = {name for name, path in files(package).items() if library in roots(path)}
    assert users <= ONLY_IN[library]


def test_the_kernel_is_found_to_use_pymunk():
    assert "pymunk" in roots(ROOT / "asv_env/basin.py")


def test_core_knows_nothing_of_the_interfaces():
    for module in set().union(*LAYERS):
        libraries = roots(ROOT / f"asv_env/{module}.py")
        assert not libraries & {"gymnasium", "pettingzoo", "matplotlib", "imageio", "tqdm"}


def test_environment_knows_nothing_of_policies_and_training():
    for path in files("asv_env").values():
        assert not roots(path) & {"baselines", "train", "tests"}


def test_policies_know_nothing_of_training():
    for path in files("baselines").values():
        assert not roots(path) & {"train", "tests", "ray"}


def test_core_needs_only_its_declared_libraries():
    allowed = {"asv_env", "numpy", "scipy", "pymunk", *sys.stdlib_module_names}
    for module in set().union(*LAYERS):
        assert roots(ROOT / f"asv_env/{module}.py") <= allowed


def test_no_module_draws_from_a_global_generator():
    for package in ("asv_env", "baselines"):
        for path in files(package).values():
            names = {
                f"{node.value.value.id}.{node.value.attr}.{node.attr}"
                for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
                if isinstance(node, ast.Attribute)
                and isinstance(node.value, ast.Attribute)
                and isinstance(node.value.value, ast.Name)
            }
            drawn = {name for name in names if name.startswith("np.random.")}
            assert drawn <= {
                "np.random.Generator",
                "np.random.default_rng",
                "np.random.SeedSequence",
            }
            assert "random" not in roots(path)
