"""Fingerprints of the code, and versions of the libraries, by which results were made."""

import ast
import hashlib
import re
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from importlib import metadata
from importlib.util import resolve_name
from pathlib import Path

TREE = Path(__file__).parents[2]
PACKAGES = {"asv_env", "baselines", "train"}
ROLLOUT = (
    *("asv_env.presets", "baselines.rollout.runner"),
    *("baselines.policy", "baselines.learned.sb3_policy"),
)
"""Modules by which episodes are run; with those that they import, all on which episodes depend.

The registry of policies names its modules as strings."""
LAZY = re.compile(r"(\w+(?:\.\w+)+):\w+")
"""An import that is written as a string, "module:NAME", such as the entries of registries."""


def code(*modules: str, tree: Path = TREE) -> str:
    """Returns a fingerprint of the code on which episodes, and further modules, depend.

    It covers the instructions of ``ROLLOUT``, of ``modules`` (dotted names; a package stands for
    all modules in it), and of every module in ``tree`` that one of these imports, directly or not.
    Comments, docstrings and layout do not count.
    """
    digest = hashlib.sha256()
    for name, instructions in sorted(dependencies([*ROLLOUT, *modules], tree).items()):
        digest.update(f"{name}\n{instructions}\n".encode())
    return digest.hexdigest()[:16]


def dependencies(modules: Sequence[str], tree: Path = TREE) -> dict[str, str]:
    """Returns the instructions of modules and of all that they import, by dotted name.

    A package's ``__init__`` counts where a name is imported from it that is not a module.
    """
    found: dict[str, str] = {}
    waiting = [one for name in modules for one in _inside(name, tree)]
    while waiting:
        name = waiting.pop()
        file = _file(name, tree)
        if file is not None and name not in found:
            package = name if file.name == "__init__.py" else name.rpartition(".")[0]
            found[name], imports = _read(file.read_text(encoding="utf-8"), package)
            for imported in imports:  # a module, or a name in one
                waiting.append(imported if _file(imported, tree) else imported.rpartition(".")[0])
    return found


def _inside(name: str, tree: Path) -> Iterator[str]:
    """Yields a module, or all modules of a package."""
    yield name
    for file in tree.joinpath(*name.split(".")).rglob("*.py"):
        yield ".".join(file.relative_to(tree).with_suffix("").parts).removesuffix(".__init__")


def _file(name: str, tree: Path) -> Path | None:
    """Returns the file of a module of this repository; None for any other name."""
    if name.split(".")[0] not in PACKAGES:
        return None
    path = tree.joinpath(*name.split("."))
    files = (path.with_suffix(".py"), path / "__init__.py")
    return next((file for file in files if file.exists()), None)


class _WithoutTexts(ast.NodeTransformer):
    def visit_Expr(self, node: ast.Expr) -> ast.Expr | None:
        return None if isinstance(node.value, ast.Constant) else node


@cache
def _read(source: str, package: str) -> tuple[str, tuple[str, ...]]:
    """Returns the instructions of a module, and the dotted names of what it imports."""
    parsed = _WithoutTexts().visit(ast.parse(source))
    return ast.dump(parsed), tuple(_imports(parsed, package))


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


def versions(libraries: Iterable[str]) -> dict[str, str]:
    """Returns the installed versions of libraries, by name."""
    return {library: metadata.version(library) for library in libraries}
