"""Who takes part: from a word of the command line to a policy.

A word is the name of a policy that is part of this package, the path of a policy file (``.npz``)
or of a stable-baselines3 model (``.zip``), or ``module:Class``. ``NAME=WORD`` gives it another
name; ``NAME=WORD,WORD,...`` is one policy that was trained several times.
"""

from __future__ import annotations

import hashlib
import importlib
import inspect
import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from asv_env.checks import choice
from asv_env.params import EnvParams
from asv_env.simulation import Simulation
from baselines.evaluate.conditions import Suite
from baselines.learned import policy_file, shipped
from baselines.learned.sb3_policy import Sb3Policy
from baselines.policy import POLICIES, Policy
from baselines.rollout import provenance
from baselines.rollout.guard import checked_action

EXPORTED, SB3 = policy_file.SUFFIX, ".zip"
SB3_NEEDS = ("stable-baselines3", "torch")
NAME = re.compile(r"[A-Za-z0-9][\w.+-]*")
"""Of a policy: it also names a folder."""


@dataclass(frozen=True)
class Source:
    """Where a policy comes from; can be sent to another process.

    Attributes:
        word: as given on the command line.
    """

    word: str

    @property
    def path(self) -> Path | None:
        """Of its file; None where it is not in one."""
        path = Path(self.word)
        return path if path.suffix in (EXPORTED, SB3) else None

    def make(self, params: EnvParams) -> Policy:
        """The policy, for an environment.

        Raises:
            ValueError: it is not a policy, or does not fit the environment.
            FileNotFoundError: there is no such file.
            ImportError: there is no such module.
        """
        if self.word in POLICIES:
            return POLICIES[self.word](params)
        if self.path is not None:
            load: Any = policy_file.load if self.path.suffix == EXPORTED else Sb3Policy
            return load(self.path, params)
        return self._class()(params)

    def check(self, trusted: bool) -> None:
        """Refuses what cannot be a policy, or must not be read.

        Args:
            trusted: whether files may be read that run code.

        Raises:
            ValueError, FileNotFoundError, ImportError: as ``make``.
        """
        if self.word in POLICIES:
            return
        if self.path is None:
            if ":" not in self.word:
                choice("policy", self.word, POLICIES)
            try:
                self._class()
            except SyntaxError as error:
                raise ValueError(f"{self.word}: {error}") from error
        elif not self.path.is_file():
            raise FileNotFoundError(f"{self.word}: there is no such file")
        elif self.path.suffix == SB3 and not trusted:
            raise ValueError(
                f"{self.word} holds pickled objects, and reading it runs whatever code is in it: "
                "add --trust-pickles if you trust its source"
            )

    def fingerprint(self) -> str:
        """A digest of what it is; for a scripted policy of this package, which it is.

        Of a class it covers the file in which it is written, not what that imports.
        """
        if self.word == "learned":
            return shipped.fingerprint()
        if self.word in POLICIES:
            return self.word
        path = self.path or Path(inspect.getsourcefile(self._class()) or "")
        digest = hashlib.sha256(path.read_bytes()).hexdigest()[:16]
        return digest if path.suffix != SB3 else f"{digest} with {_libraries(SB3_NEEDS)}"

    def _class(self) -> type[Any]:
        module, _, name = self.word.partition(":")
        if "" not in sys.path:
            sys.path.insert(0, "")  # modules of the folder in which the command was given
        found = getattr(importlib.import_module(module), name, None)
        if not inspect.isclass(found):
            raise ValueError(f"{self.word}: the module {module} has no class {name!r}")
        return found


def _libraries(names: Sequence[str]) -> str:
    return ", ".join(f"{name} {version}" for name, version in provenance.versions(names).items())


@dataclass(frozen=True)
class Entrant:
    """A policy that takes part.

    Attributes:
        name: in tables.
        sources: one for each of its trainings.
    """

    name: str
    sources: tuple[Source, ...]

    def training_seed(self, number: int) -> int | None:
        """What rows say of its ``number``-th source."""
        return number if len(self.sources) > 1 else None


def entrant(word: str) -> Entrant:
    """From a word of the command line.

    Raises:
        ValueError: a name that cannot be one, or several trainings without a name of their own.
    """
    name, given, rest = word.partition("=")
    if not given or Path(word).exists():
        name, given, rest = "", "", word
    sources = tuple(Source(source) for source in rest.split(","))
    if len(sources) > 1 and (not given or any(one.word in POLICIES for one in sources)):
        raise ValueError(
            f"{word}: several trainings of one policy need a name and files or classes of their "
            "own, NAME=A.zip,B.zip; part different policies with spaces"
        )
    path = sources[0].path
    if not given:
        name = sources[0].word.rpartition(":")[2] if path is None else path.stem
    if not NAME.fullmatch(name):
        raise ValueError(
            f"{word}: {name!r} cannot be a name; begin with a letter or a digit and use these, "
            "dots, plus, minus and underscores"
        )
    return Entrant(name, sources)


def entrants(words: Sequence[str], suite: Suite, trusted: bool) -> tuple[Entrant, ...]:
    """All that take part, each found to fit every condition of a suite.

    Raises:
        ValueError: a name twice, something that is not a policy or does not fit.
        FileNotFoundError, ImportError: there is no such file or module.
    """
    found = tuple(map(entrant, words))
    names = [one.name for one in found]
    if len(set(names)) < len(names):
        raise ValueError(f"--policies {' '.join(words)}: name each policy once (name=...)")
    for one in found:
        for source in one.sources:
            source.check(trusted)
            for condition in suite.conditions:
                try:
                    _try(source, condition.params, suite.seed)
                except ValueError as error:
                    raise ValueError(
                        f"{one.name} in condition {condition.name!r}: {error}"
                    ) from error
    return found


def _try(source: Source, params: EnvParams, seed: int) -> None:
    """Makes the policy and lets it decide once.

    Raises:
        ValueError, TypeError: it cannot be made, or does not speak as ``Policy`` says.
    """
    policy = _made(source, params)
    if not hasattr(policy, "act"):
        raise ValueError(f"{source.word} is not a policy: it has no method act")
    simulation = Simulation(params)
    observation = simulation.reset(seeds=[seed])
    given = (simulation.sensed, observation, None, np.ones(1, dtype=np.bool_))
    try:
        inspect.signature(policy.act).bind(*given)
    except TypeError as error:
        raise ValueError(
            f"{source.word}: act must take (sensed, observation, memory, fresh): {error}"
        ) from error
    try:
        decided = policy.act(*given)
    except Exception:
        return  # It fails its episodes, one by one, and each is named.
    if not (isinstance(decided, tuple) and len(decided) == 2):
        raise ValueError(
            f"{source.word}: act returned {type(decided).__name__}: return (action, memory)"
        )
    checked_action(decided[0], (1, params.num_boats, 2))


def _made(source: Source, params: EnvParams) -> Policy:
    """The policy; whatever else its class raises becomes a ValueError that names it."""
    try:
        return source.make(params)
    except (ValueError, ImportError, OSError):
        raise
    except Exception as error:
        raise ValueError(f"{source.word}: {type(error).__name__}: {error}") from error
