"""The fingerprint of the code follows what an episode depends on, and nothing else."""

import ast
import re
import shutil
import zipfile
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


@pytest.mark.parametrize(
    "name", [f"baselines/{name}/tuned.json" for name in ("paper", "scripted", "allocation")]
)
def test_values_that_a_module_reads_from_its_package_count(tree, name):
    def other(text):
        return re.sub(r"(: -?)(\d)", r"\g<1>1\g<2>", text, count=1)

    assert edited(tree, name, other)
    assert not edited(tree, name, lambda text: f"{text}\n\n")


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
        "baselines.learned.team_view",
    } <= names
    assert not {name for name in names if name.startswith(("baselines.evaluate", "train"))}


# ------------------------------------------------------------------ where the source lies


def rewritten(tree, name, change):
    """Whether the fingerprint changes when a file's bytes are changed, which is undone."""
    file, before = tree / name, provenance.code(tree=tree)
    content = file.read_bytes()
    file.write_bytes(change(content))
    changed = provenance.code(tree=tree) != before
    file.write_bytes(content)
    return changed


@pytest.mark.parametrize(
    "change",
    [
        lambda content: content.replace(b"\n", b"\r\n"),
        lambda content: b"\xef\xbb\xbf" + content,
        lambda content: b"# -*- coding: utf-8 -*-\n" + content,
    ],
    ids=["CRLF", "BOM", "coding"],
)
def test_the_way_in_which_files_are_checked_out_does_not_count(change, tree):
    assert not rewritten(tree, "baselines/scripted/grasp_controller.py", change)


def test_a_library_without_metadata_is_of_an_unknown_version():
    found = provenance.versions(["numpy", "no-such-library"])
    assert found["no-such-library"] == "unknown"
    assert found["numpy"][0].isdigit()


def test_an_installation_without_source_is_refused(tree, tmp_path):
    with pytest.raises(ValueError, match=r"asv_env has no source .*: install it with its source"):
        provenance.code(tree=tmp_path)


def test_packages_in_an_archive_have_the_same_fingerprint(tree, tmp_path):
    shutil.make_archive(str(tmp_path / "packages"), "zip", tree)
    root = zipfile.Path(tmp_path / "packages.zip")
    assert provenance.code(tree=root) == provenance.code(tree=tree)
    assert provenance.code("train", tree=root) == provenance.code("train", tree=tree)


def test_the_packages_are_those_that_python_imports(tree, monkeypatch):
    """Not those beside this module, where files of the current folder are imported instead."""
    here = provenance.code()
    monkeypatch.setattr(
        provenance.resources,
        "files",
        lambda package: (tree if package == "asv_env" else ROOT) / package,
    )
    assert provenance.code() == here
    file = tree / "asv_env/physics/water.py"
    text = file.read_text()
    file.write_text(f"{text}\nADDED = 1\n")
    changed = provenance.code()
    file.write_text(text)
    assert changed != here


def test_instructions_are_the_same_text_in_every_version_of_python():
    """Newer versions leave out empty fields, older ones do not know some of them."""
    parsed = ast.parse("def f(a, *, b=None):\n    return f'{a!r:>{b}}'\n")
    text = provenance._dump(parsed)
    assert text.startswith("Module(body=[FunctionDef(name='f',args=arguments(args=[arg(arg='a')]")
    assert "type_params" not in text
    assert "=[]" not in text
    assert text != provenance._dump(ast.parse("def f(a, *, b=0):\n    return f'{a!r:>{b}}'\n"))
