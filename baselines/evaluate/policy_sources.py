"""Where policies come from: registered names, files, and classes, also those of a notebook."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from asv_env.checks import choice
from asv_env.params import EnvParams
from asv_env.registry import load
from baselines.evaluate.code_identity import fingerprint, identify, is_own
from baselines.learned import policy_file, shipped
from baselines.learned.sb3_policy import Sb3Policy
from baselines.policy import POLICIES, MakePolicy, Policy
from baselines.rollout import provenance

EXPORTED, SB3 = policy_file.SUFFIX, ".zip"
"""Endings of the names of policy files, and of models that stable-baselines3 has saved."""
SB3_NEEDS = ("stable-baselines3", "torch")


@dataclass(frozen=True)
class PolicySource:
    """A policy, or one training of it, before it is made for an environment.

    It can be sent to another process.

    Attributes:
        word: name in messages.
        factory: function that makes the policy.
        file: file that stores or defines it; None for a policy of this package or a notebook.
        identity: part of the fingerprint that does not depend on the file.
    """

    word: str
    factory: MakePolicy
    file: Path | None = None
    identity: str = ""

    def make(self, params: EnvParams) -> Policy:
        """Returns the policy for an environment.

        Raises:
            ValueError: it is not a policy, or does not fit the environment.
            FileNotFoundError: there is no such file.
        """
        try:
            return self.factory(params)
        except (ValueError, ImportError, OSError):
            raise
        except Exception as error:
            raise ValueError(f"{self.word}: {type(error).__name__}: {error}") from error

    def fingerprint(self) -> str:
        """Returns a digest of the policy; the name of a scripted policy of this package.

        A class is covered by the file in which it is written, not by what that imports.
        """
        return fingerprint(self.file, self.identity)


def is_file(word: str) -> bool:
    """Returns whether a word is the path of a policy file or of a model, by its ending."""
    return Path(word).suffix in (EXPORTED, SB3)


def find(given: str | Path | MakePolicy, trust_pickles: bool = False) -> PolicySource:
    """Returns the source of a policy.

    Args:
        given: name of a registered policy, path of a policy file (``.npz``) or of a
            stable-baselines3 model (``.zip``), "module:Class", or a class or another function
            ``EnvParams -> Policy``.
        trust_pickles: whether files may be read that run code.

    Raises:
        ValueError: an unknown name, or a file that must not be read.
        FileNotFoundError, ImportError: there is no such file or module.
        TypeError: something else.
    """
    if callable(given):
        return _written(getattr(given, "__name__", type(given).__name__), given)
    if not isinstance(given, str | Path):
        raise TypeError(f"{given!r} is not a policy: give a name, a path, a class or a function")
    word, path = str(given), Path(given)
    if word in POLICIES:
        return _registered(word)
    if is_file(word):
        return _stored(word, path, trust_pickles)
    if ":" not in word:
        choice("policy", word, POLICIES)
    try:
        return _written(word, load(word))
    except SyntaxError as error:
        raise ValueError(f"{word}: {error}") from error


def _registered(name: str) -> PolicySource:
    factory = POLICIES[name]
    if is_own(factory):
        return _written(name, factory)
    return PolicySource(name, factory, None, shipped.fingerprint() if name == "learned" else name)


def _stored(word: str, path: Path, trust_pickles: bool) -> PolicySource:
    """Returns the source of a policy in a file that training has left."""
    if not path.is_file():
        raise FileNotFoundError(f"{word}: there is no such file")
    if path.suffix == EXPORTED:
        return PolicySource(word, partial(policy_file.load, path), path)
    if not trust_pickles:
        raise ValueError(
            f"{word} holds pickled objects, and reading it runs whatever code is in it: "
            "add trust_pickles=True if you trust its source"
        )
    libraries = provenance.versions(SB3_NEEDS)
    identity = ", ".join(f"{name} {version}" for name, version in libraries.items())
    return PolicySource(word, partial(Sb3Policy, path), path, identity)


def _written(word: str, factory: Any) -> PolicySource:
    """Returns the source of a user-defined class or function."""
    if not callable(factory):
        raise ValueError(f"{word} is not a policy: it is neither a class nor a function")
    return PolicySource(word, factory, *identify(factory))
