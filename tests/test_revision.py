"""The git revision is that of the repository which tracks the packages, or none."""

import os
import subprocess

import pytest

from baselines.rollout import provenance

AUTHOR = ("-c", "user.name=x", "-c", "user.email=x@example.org")


def git(folder, *words):
    around = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}
    command = ["git", *AUTHOR, *words]
    ran = subprocess.run(
        command, cwd=folder, env=around, capture_output=True, text=True, check=True
    )
    return ran.stdout.strip()


def packages(folder):
    for package in provenance.PACKAGES:
        (folder / package).mkdir(parents=True)
        (folder / package / "__init__.py").write_text("")


def repository(folder):
    folder.mkdir(parents=True, exist_ok=True)
    git(folder, "init", "-q")
    git(folder, "commit", "-q", "--allow-empty", "-m", "first")
    return folder


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """A repository with the packages in it, in which they are looked for."""
    folder = repository(tmp_path / "here")
    packages(folder / "src")
    monkeypatch.setattr(provenance, "_root", lambda package, tree: folder / "src" / package)
    return folder


def tracked(folder):
    git(folder, "add", "-A")
    git(folder, "commit", "-q", "-m", "second")
    return git(folder, "rev-parse", "--short=12", "HEAD")


def test_a_repository_that_only_encloses_the_packages_is_not_asked(installed):
    assert provenance.revision() is None
    (installed / ".gitignore").write_text("src\n")
    tracked(installed)
    assert provenance.revision() is None


def test_some_tracked_files_are_not_enough(installed):
    git(installed, "add", "src/train")
    git(installed, "commit", "-q", "-m", "some")
    assert provenance.revision() is None


def test_the_repository_of_the_packages_is_named_and_changes_are_marked(installed):
    revision = tracked(installed)
    assert provenance.revision() == revision
    (installed / "src/train/__init__.py").write_text("CHANGED = 1\n")
    assert provenance.revision() == f"{revision}-dirty"


def test_variables_of_git_do_not_count(installed, tmp_path, monkeypatch):
    other = repository(tmp_path / "other")
    for name, value in (("GIT_DIR", other / ".git"), ("GIT_WORK_TREE", installed)):
        monkeypatch.setenv(name, str(value))
    assert provenance.revision() is None
    assert provenance.revision() is None
    assert tracked(installed) == provenance.revision()


def test_a_submodule_has_its_own_revision(tmp_path, installed, monkeypatch):
    revision = tracked(installed)
    outer = repository(tmp_path / "outer")
    git(outer, "-c", "protocol.file.allow=always", "submodule", "add", "-q", str(installed), "sub")
    tracked(outer)
    monkeypatch.setattr(provenance, "_root", lambda package, tree: outer / "sub/src" / package)
    assert provenance.revision() == revision


def test_no_program_of_the_repository_is_run(installed, tmp_path):
    revision, mark = tracked(installed), tmp_path / "mark"
    spy = tmp_path / "spy"
    spy.write_text(f"#!/bin/sh\ntouch {mark}\n")
    spy.chmod(0o755)
    git(installed, "config", "core.fsmonitor", str(spy))
    for hook in ("post-index-change", "pre-commit", "fsmonitor-watchman"):
        (installed / ".git/hooks" / hook).write_text(f"#!/bin/sh\ntouch {mark}\n")
        (installed / ".git/hooks" / hook).chmod(0o755)
    (installed / "src/train/__init__.py").touch()
    assert provenance.revision() == revision
    assert not mark.exists()


def test_without_git_or_commits_there_is_none(installed, tmp_path, monkeypatch):
    git(installed, "update-ref", "-d", "HEAD")
    git(installed, "add", "-A")
    assert provenance.revision() is None  # tracked, but never committed
    tracked(installed)
    assert provenance.revision()
    monkeypatch.setenv("PATH", str(tmp_path))
    assert provenance.revision() is None
