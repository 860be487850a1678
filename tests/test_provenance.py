"""The fingerprint of the code follows what an episode depends on, and nothing else."""

import shutil
from pathlib import Path

import pytest

from baselines.rollout import provenance

ROOT = Path(__file__).resolve().parent.parent
PARTS = (
    *("asv_env/presets.py", "asv_env/simulation.py", "asv_env/tasks/push.py"),
    *("asv_env/physics/water.py", "asv_env/sensing/observation.py", "asv_env/tasks/metrics.py"),
    *(
        "baselines/scripted/grasp_controller.py",
        "baselines/paper/two_arc.py",
        "baselines/mirror.py",
    ),
    *("baselines/learned/network.py", "baselines/rollout/loop.py", "baselines/policy.py"),
)
OTHERS = (
    *("asv_env/render/viewer.py", "asv_env/envs/vector.py", "baselines/rollout/film.py"),
    *("baselines/evaluate/workers.py", "baselines/evaluate/report/palette.py"),
    *("baselines/evaluate/report/single_panel.py", "baselines/reproduce/single_runs.py"),
    "train/run.py",
)


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """A copy of the source, to be edited."""
    tree = tmp_path_factory.mktemp("tree")
    for package in provenance.PACKAGES:
        shutil.copytree(ROOT / package, tree / package, ignore=shutil.ignore_patterns("weights"))
    return tree


def edited(tree, name, edit):
    """Whether the fingerprint changes with an edit of a file, which is undone."""
    file, before = tree / name, provenance.code(tree=tree)
    text = file.read_text()
    file.write_text(edit(text))
    changed = provenance.code(tree=tree) != before
    file.write_text(text)
    assert provenance.code(tree=tree) == before
    return changed


@pytest.mark.parametrize("name", PARTS)
def test_an_edit_of_what_episodes_depend_on_changes_it(tree, name):
    assert edited(tree, name, lambda text: f"{text}\nADDED = 1\n")


@pytest.mark.parametrize("name", OTHERS)
def test_an_edit_of_anything_else_does_not(tree, name):
    assert not edited(tree, name, lambda text: f"{text}\nADDED = 1\n")


def test_comments_and_docstrings_do_not_count(tree):
    def explain(text):
        docstring, quotes, rest = text[3:].partition('"""')
        return f'"""Another text.{quotes}  # and a comment\n\n\n{rest}' if docstring else text

    assert not edited(tree, "baselines/scripted/grasp_controller.py", explain)


def test_a_part_that_is_moved_is_followed(tree):
    """A new module counts as soon as something that counts imports it, even as a string."""
    (tree / "baselines/scripted/gripper.py").write_text("FORCE = 1.0\n")
    for line in ("from baselines.scripted import gripper", 'LAZY = "baselines.scripted.gripper:F"'):
        assert edited(
            tree, "baselines/scripted/grasp_controller.py", lambda text, line=line: text + line
        )
        grasp = tree / "baselines/scripted/grasp_controller.py"
        text = grasp.read_text()
        grasp.write_text(text + line)
        assert edited(tree, "baselines/scripted/gripper.py", lambda text: "FORCE = 2.0\n")
        grasp.write_text(text)


def test_further_modules_and_packages_count_where_they_are_named(tree):
    names = provenance.dependencies(["train"], tree)
    assert {"train.run", "train.sb3.ppo", "asv_env.simulation"} <= set(names)
    assert provenance.code("train", tree=tree) != provenance.code(tree=tree)


def test_the_policies_of_the_package_are_covered():
    names = set(provenance.dependencies(provenance.ROLLOUT))
    assert {
        "baselines.scripted.planner",
        "baselines.paper.arcs",
        "baselines.learned.phases",
    } <= names
    assert not {name for name in names if name.startswith(("baselines.evaluate", "train"))}
