"""The policies of a comparison: sources, names, and whether they fit a suite."""

import inspect
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, cast

import numpy as np

from asv_env.numerics import numerics
from asv_env.params import EnvParams
from asv_env.simulation import Simulation
from asv_env.text import described, shown
from baselines.distributed import distributed
from baselines.evaluate.conditions import Condition, Suite
from baselines.evaluate.fingerprints import fingerprint, identify, is_own
from baselines.evaluate.names import check_distinct, check_policy_name
from baselines.learned import policy_file
from baselines.learned.sb3_policy import Sb3Policy
from baselines.policy import POLICIES, MakePolicy, decision
from baselines.rollout import provenance
from baselines.rollout.guard import is_ctrl_c
from baselines.rollout.process_state import restored

EXPORTED = policy_file.SUFFIX  #: ending of the names of policy files
SB3 = ".zip"  #: ending of the names of models that stable-baselines3 has saved
SB3_NEEDS = ("stable-baselines3", "torch")
LONGEST = 500  #: largest number of characters of an error of a policy that is refused
_IMPORTING: ContextVar[bool] = ContextVar("importing", default=False)
PolicyLike = str | Path | MakePolicy | Sequence[str | Path | MakePolicy]
"""A policy as ``find`` takes it, or several trainings of one."""


@dataclass(frozen=True)
class PolicySource:
    """A policy, or one training of it, before it is made for an environment.

    It can be sent to another process.
    """

    word: str  #: name in messages
    factory: MakePolicy  #: function that makes the policy
    file: Path | None = None  #: where it is stored or defined; None in this package or a notebook
    identity: str = ""  #: part of the fingerprint that does not depend on the file

    def fingerprint(self) -> str:
        """Returns a digest of the policy; the name of a scripted policy of this package.

        A class is covered by the file in which it is written, not by what that imports.
        """
        return fingerprint(self.file, self.identity)


@contextmanager
def importing() -> Iterator[None]:
    """Marks that modules of policies are imported, which must not begin an evaluation."""
    mark = _IMPORTING.set(True)
    try:
        yield
    finally:
        _IMPORTING.reset(mark)


def check_not_importing() -> None:
    """Refuses an evaluation that begins while the module of a policy is imported."""
    if _IMPORTING.get():
        raise ValueError(
            "a module that holds a policy begins an evaluation while it is imported: put the call "
            'below `if __name__ == "__main__":`'
        )


def is_file(word: str) -> bool:
    """Returns whether a word is the path of a policy file or of a model, by its ending."""
    return Path(word).suffix in (EXPORTED, SB3)


def find(given: str | Path | MakePolicy, trust_pickles: bool = False) -> PolicySource:
    """Returns the source of a policy.

    It is given as a registered name, as the path of a policy file (``.npz``) or, if files may be
    read that run code, of a stable-baselines3 model (``.zip``), as "module:Class", or as a class or
    another function ``EnvParams -> Policy``.

    Raises:
        ValueError: an unknown name, or a file that must not be read.
        FileNotFoundError, ImportError: there is no such file or module.
        TypeError: something else.
    """
    if callable(given):
        return _written(getattr(given, "__name__", type(given).__name__), given)
    if not isinstance(given, str | Path):
        raise TypeError(
            f"{shown(given)} is not a policy: give a name, a path, a class or a function"
        )
    word, path = str(given), Path(os.path.expanduser(given)).absolute()
    if word in POLICIES and not is_own(POLICIES[word]):
        identity = policy_file.fingerprint() if word == "learned" else word
        return PolicySource(word, POLICIES[word], None, identity)
    if is_file(word) and word not in POLICIES:
        return _stored(word, path, trust_pickles)
    if word and word not in POLICIES and os.path.isdir(path):
        raise ValueError(f"{word} is a folder: give a policy file or a model in it")
    with importing():
        return _written(word, POLICIES.find(word))


def _stored(word: str, path: Path, trust_pickles: bool) -> PolicySource:
    """Returns the source of a policy in a file that training has left."""
    if not os.path.isfile(path):
        raise FileNotFoundError(f"{word}: there is no such file")
    if path.suffix == EXPORTED:
        return PolicySource(word, partial(policy_file.load, path), path)
    if not trust_pickles:
        raise ValueError(
            f"{word} holds pickled objects, and reading it runs whatever code is in it: "
            "add trust_pickles=True if you trust its source"
        )
    libraries = map(" ".join, provenance.versions(SB3_NEEDS).items())
    return PolicySource(word, partial(Sb3Policy, path), path, ", ".join(libraries))


def _written(word: str, factory: Any) -> PolicySource:
    """Returns the source of a user-defined class or function."""
    if not callable(factory):
        raise ValueError(f"{word} is not a policy: it is neither a class nor a function")
    return PolicySource(word, factory, *identify(factory))


def named(
    policies: Mapping[str, PolicyLike], trust_pickles: bool
) -> dict[str, tuple[PolicySource, ...]]:
    """Returns the sources of the trainings of each policy by its name, found but not yet made.

    Raises:
        ValueError, TypeError: a name or trainings that cannot be; other errors as ``find``.
    """
    if not isinstance(policies, Mapping) or not policies:
        raise TypeError(
            f"policies={shown(policies)}: give at least one, by name: {{'mine': MyPolicy}}"
        )
    found = {}
    for name, given in policies.items():
        several = isinstance(given, Sequence) and not isinstance(given, str)
        trainings: list[Any] = list(cast(Any, given)) if several else [given]
        registered = any(isinstance(each, str) and each in POLICIES for each in trainings)
        if not trainings or (registered and len(trainings) > 1):
            raise ValueError(
                f"policies: {name}={','.join(map(str, trainings))}: several trainings of one "
                "policy are files or classes of their own; different policies need a name each"
            )
        sources = tuple(find(training, trust_pickles) for training in trainings)
        check_policy_name(name)
        found[name] = sources
    check_distinct("policies", found)
    return found


def check_fit(policies: Mapping[str, Sequence[PolicySource]], suite: Suite) -> None:
    """Begins an episode of every condition, makes every policy for it and lets it decide once.

    A policy that cannot be made for some conditions, or raises, fails its episodes there.

    Raises:
        ValueError: a condition whose task or observation fails; a policy that can be made for no
            condition, or does not act as ``Policy`` says.
    """
    for condition in suite.conditions:
        try:
            simulation = Simulation(condition.params)
            simulation.reset(seeds=[suite.seed])
            simulation.step(np.zeros((1, condition.params.num_boats, 2)))
            simulation.summary()
        except (ValueError, TypeError) as error:
            raise ValueError(f"condition {condition.name!r}: {error}") from error
    for name, trainings in policies.items():
        for source in trainings:
            with restored(), numerics():
                wrong = [_wrong(name, source, each, suite.seed) for each in suite.conditions]
            if all(wrong):
                raise ValueError(wrong[0])


def _wrong(name: str, source: PolicySource, condition: Condition, seed: int) -> str:
    """Returns why a policy cannot be made for a condition, "" if it can.

    Raises:
        ValueError: it can, and does not act as ``Policy`` says.
    """
    place = f"{name} in condition {condition.name!r}: "
    try:
        policy = source.factory(condition.params)
    except BaseException as error:
        if is_ctrl_c(error):
            raise
        return f"{place}{source.word}: {described(error, LONGEST)}"
    try:
        _check_decision(policy, condition.params, seed)
    except BaseException as error:
        if is_ctrl_c(error):
            raise
        raise ValueError(f"{place}{source.word}: {described(error, LONGEST)}") from error
    return ""


def _check_decision(policy: Any, params: EnvParams, seed: int) -> None:
    """Refuses what has no method ``act`` of the right form, or returns something else by it."""
    if not callable(getattr(policy, "act", None)):
        raise TypeError("not a policy: it has no method act")
    simulation = Simulation(params)
    observation = simulation.reset(seeds=[seed])
    arguments = (simulation.sensed, observation, None, np.ones(1, dtype=np.bool_))
    try:
        signature = inspect.signature(policy.act)
    except ValueError:  # of compiled code
        signature = None
    try:
        if signature is not None:
            signature.bind(*arguments)
    except TypeError as error:
        raise TypeError(f"act must take (sensed, observation, memory, fresh): {error}") from error
    try:
        decided = distributed(policy, params).act(*arguments)
    except BaseException as error:
        if is_ctrl_c(error):
            raise
        return  # It fails its episodes, one by one, and each is named.
    decision(decided, (1, params.num_boats, 2))
