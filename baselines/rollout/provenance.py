"""Fingerprints of the code, and versions of the libraries, by which results were made."""

import ast
import hashlib
import json
import os
import re
import subprocess
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from importlib import metadata, resources
from importlib.resources.abc import Traversable
from importlib.util import resolve_name
from pathlib import Path
from typing import Any

PACKAGES = {"asv_env", "baselines", "train"}
ROLLOUT = (
    *("asv_env.presets", "baselines.rollout.runner"),
    *("baselines.policy", "baselines.learned.sb3_policy"),
)
"""Modules by which episodes are run; with those that they import, all on which episodes depend.

The registry of policies names its modules as strings."""
LAZY = re.compile(r"(\w+(?:\.\w+)+):\w+")
"""An import that is written as a string, "module:NAME", such as the entries of registries."""
DATA = re.compile(r"\w+\.json")
"""Name of a file of values in the package of the module that reads it."""


PATIENCE = 20.0  #: time after which git is not waited for, s


def code(*modules: str, tree: Path | None = None) -> str:
    """Returns a fingerprint of the code on which episodes, and further modules, depend.

    It covers the instructions of ``ROLLOUT``, of ``modules`` (dotted names; a package stands for
    all modules in it), and of every module of ``PACKAGES`` that one of these imports, directly or
    not. Comments, docstrings and layout do not count. The packages are those that Python imports,
    from wherever it does, or those in ``tree``.

    Raises:
        ValueError: a package is installed without its source.
    """
    digest = hashlib.sha256()
    for name, instructions in sorted(dependencies([*ROLLOUT, *modules], tree).items()):
        digest.update(f"{name}\n{instructions}\n".encode())
    return digest.hexdigest()[:16]


def dependencies(modules: Sequence[str], tree: Path | None = None) -> dict[str, str]:
    """Returns the instructions of modules and of all that they import, by dotted name.

    A package's ``__init__`` counts where a name is imported from it that is not a module. Values
    in the JSON files of its package that a module names belong to its instructions.
    """
    found: dict[str, str] = {}
    waiting = [one for name in modules for one in _inside(name, tree)]
    while waiting:
        name = waiting.pop()
        file = _file(name, tree)
        if file is not None and name not in found:
            package = name if file.name == "__init__.py" else name.rpartition(".")[0]
            found[name], imports, data = _read(file.read_bytes(), package)
            found[name] += "".join(_values(package, each, tree) for each in data)
            for imported in imports:  # a module, or a name in one
                waiting.append(imported if _file(imported, tree) else imported.rpartition(".")[0])
    return found


def _root(package: str, tree: Path | None) -> Traversable:
    """Returns the folder of a package, in an archive perhaps."""
    root: Traversable = resources.files(package) if tree is None else tree / package
    if not (root / "__init__.py").is_file():
        raise ValueError(
            f"{package} has no source in {root}, so results of other code could not be "
            "distinguished: install it with its source"
        )
    return root


def _inside(name: str, tree: Path | None) -> Iterator[str]:
    """Yields a module, or all modules of a package."""
    yield name
    package, *names = name.split(".")
    folder = _root(package, tree).joinpath(*names)
    for each in folder.iterdir() if folder.is_dir() else ():
        if each.is_dir():
            yield from _inside(f"{name}.{each.name}", tree)
        elif each.name.endswith(".py") and each.name != "__init__.py":
            yield f"{name}.{each.name.removesuffix('.py')}"


def _file(name: str, tree: Path | None) -> Traversable | None:
    """Returns the file of a module of this repository; None for any other name."""
    package, *names = name.split(".")
    if package not in PACKAGES:
        return None
    *folders, last = names or [""]
    folder = _root(package, tree).joinpath(*folders)
    files = (folder / f"{last}.py", folder.joinpath(last) / "__init__.py")
    return next((file for file in files if file.is_file()), None)


def _values(package: str, name: str, tree: Path | None) -> str:
    """Returns the values in a JSON file of a package, if there is one of that name."""
    root, *folders = package.split(".")
    file = _root(root, tree).joinpath(*folders, name)
    return repr(json.loads(file.read_text(encoding="utf-8"))) if file.is_file() else ""


class _WithoutTexts(ast.NodeTransformer):
    def visit_Expr(self, node: ast.Expr) -> ast.Expr | None:
        return None if isinstance(node.value, ast.Constant) else node


@cache
def _read(source: bytes, package: str) -> tuple[str, tuple[str, ...], tuple[str, ...]]:
    """Returns the instructions of a module, what it imports, and the JSON files that it names."""
    parsed = _WithoutTexts().visit(ast.parse(source))
    texts = (str(node.value) for node in ast.walk(parsed) if isinstance(node, ast.Constant))
    data = sorted({text for text in texts if DATA.fullmatch(text)})
    return _dump(parsed), tuple(_imports(parsed, package)), tuple(data)


def _dump(node: Any) -> str:
    """Returns the instructions of a tree as text, the same in every version of Python."""
    if isinstance(node, list):
        return f"[{','.join(map(_dump, node))}]"
    if not isinstance(node, ast.AST):
        return repr(node)
    given = ((name, value) for name, value in ast.iter_fields(node) if value not in (None, []))
    return f"{type(node).__name__}({','.join(f'{name}={_dump(v)}' for name, v in given)})"


def _imports(parsed: ast.Module, package: str) -> Iterator[str]:
    """Yields the dotted names of what a module imports, wherever in it."""
    for node in ast.walk(parsed):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = resolve_name("." * node.level + (node.module or ""), package)
            yield from (f"{base}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Constant) and (lazy := LAZY.fullmatch(str(node.value))):
            yield lazy[1]


def revision() -> str | None:
    """Returns the git revision of the packages, marked where files differ from it.

    None where there is no git, or no repository that tracks the files of the packages. A repository
    that only encloses them, such as one with a virtual environment in it, is not asked further.
    Variables of git do not count, and no program is run that a repository names as its monitor.
    """
    try:
        roots = [Path(str(_root(package, None))) for package in sorted(PACKAGES)]
        files = [str(root / "__init__.py") for root in roots]
        _git(roots[0], "ls-files", "--error-unmatch", "--", *files)
        return _git(roots[0], "describe", "--always", "--dirty", "--abbrev=12") or None
    except (ImportError, TypeError, ValueError, OSError, subprocess.SubprocessError):
        return None


def _git(folder: Path, *words: str) -> str:
    """Returns what git answers; CalledProcessError where it refuses."""
    around = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}
    around |= {"GIT_OPTIONAL_LOCKS": "0", "LC_ALL": "C"}
    command = ["git", "-c", "core.fsmonitor=false", "-c", f"core.hooksPath={os.devnull}", *words]
    options: dict[str, Any] = {"stdin": subprocess.DEVNULL, "timeout": PATIENCE, "check": True}
    ran = subprocess.run(
        command, cwd=folder, env=around, capture_output=True, encoding="utf-8", **options
    )
    return ran.stdout.strip()


def versions(libraries: Iterable[str]) -> dict[str, str]:
    """Returns the installed versions of libraries, by name; "unknown" where they say none."""
    return {library: _version(library) for library in libraries}


def _version(library: str) -> str:
    try:
        return str(metadata.version(library))
    except metadata.PackageNotFoundError:
        return "unknown"
