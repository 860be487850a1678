"""By which code and which libraries numbers were made."""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterable, Sequence
from importlib import metadata
from pathlib import Path

import asv_env
import baselines

PACKAGES = [Path(str(package.__file__)).parent for package in (asv_env, baselines)]
ALL, TOP = "**/*.py", "*.py"


def code(pattern: str = ALL) -> str:
    """A fingerprint of the source of the environment and of the baselines.

    Args:
        pattern: of the files: ``ALL``, or ``TOP`` for those on which episodes depend, the
            environment and the policies, without what is made of episodes.
    """
    return fingerprint(PACKAGES, pattern)


def fingerprint(folders: Sequence[Path], pattern: str = ALL) -> str:
    """A digest of the modules in folders that match a pattern, by their names and what they do.

    Comments, docstrings and the layout of the source do not count.
    """
    digest = hashlib.sha256()
    for folder in folders:
        for path in sorted(folder.glob(pattern)):
            digest.update(path.relative_to(folder).as_posix().encode())
            digest.update(_instructions(path.read_text(encoding="utf-8")).encode())
    return digest.hexdigest()[:16]


def _instructions(source: str) -> str:
    tree = ast.parse(source)
    for node in ast.walk(tree):
        if isinstance(getattr(node, "body", None), list):
            node.body = [one for one in node.body if not _is_text(one)]  # type: ignore[attr-defined]
    return ast.dump(tree)


def _is_text(statement: ast.AST) -> bool:
    return (
        isinstance(statement, ast.Expr)
        and isinstance(statement.value, ast.Constant)
        and isinstance(statement.value.value, str)
    )


def versions(libraries: Iterable[str]) -> dict[str, str]:
    """Installed versions of libraries, by name."""
    return {library: metadata.version(library) for library in libraries}
