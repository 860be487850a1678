"""The policies of a comparison: sources, names, fingerprints, and whether they fit a suite."""

import hashlib
import inspect
import linecache
import os
import pickle
import sys
import uuid
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, fields, is_dataclass
from functools import partial
from pathlib import Path
from typing import Any, cast

import numpy as np

from asv_env.numerics import numerics
from asv_env.params import EnvParams
from asv_env.simulation import Simulation
from asv_env.text import described, shown
from baselines.evaluate.conditions import Condition, Suite
from baselines.evaluate.names import check_distinct, check_policy_name
from baselines.learned import policy_file
from baselines.learned.sb3_policy import Sb3Policy
from baselines.policy import POLICIES, MakePolicy
from baselines.rollout import provenance
from baselines.rollout.guard import decision, is_ctrl_c
from baselines.rollout.process_state import restored

EXPORTED = policy_file.SUFFIX  #: ending of the names of policy files
SB3 = ".zip"  #: ending of the names of models that stable-baselines3 has saved
SB3_NEEDS = ("stable-baselines3", "torch")
PACKAGES = ("asv_env", "baselines")  #: packages whose code ``provenance.code`` covers
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
        decided = policy.act(*arguments)
    except BaseException as error:
        if is_ctrl_c(error):
            raise
        return  # It fails its episodes, one by one, and each is named.
    decision(decided, (1, params.num_boats, 2))


def digest(data: bytes) -> str:
    """Returns a short digest of bytes."""
    return hashlib.sha256(data).hexdigest()[:16]


def fingerprint(file: Path | None, identity: str) -> str:
    """Returns a fingerprint of the present contents of a file, if any, and of an identity."""
    contents = "" if file is None else digest(file.read_bytes())
    return " with ".join(filter(None, (contents, identity)))


def identify(function: Any) -> tuple[Path | None, str]:
    """Returns the file of a class or function, and its identity within that file.

    In a notebook the file is None, and the identity covers the cell. It also covers the values that
    are ``bound`` to it, but nothing that it imports. Where these cannot be compared, the identity
    is random: no two are taken for the same.
    """
    whole = function
    while isinstance(function, partial):
        function = function.func
    file = getattr(sys.modules.get(function.__module__), "__file__", None)
    if file and not os.path.isfile(file):  # as of a program that is read from standard input
        file = None
    cell = "" if file else _notebook_cell(function)
    if not file and not cell:
        return None, uuid.uuid4().hex
    name = getattr(function, "__qualname__", type(function).__qualname__)
    try:
        values = bound(whole)
        more = digest(cell.encode() + pickle.dumps(values)) if cell or values else ""
    except Exception:  # of whatever is bound
        more = uuid.uuid4().hex
    return Path(file) if file else None, f"{name} {more}".strip()


def bound(thing: Any, owner: type | None = None) -> list[Any]:
    """Returns the values that are bound to a class or function, which its file does not tell.

    They are the arguments of a ``partial``, the object of a method or one that can be called, and
    what a class or function that another function has made knows of it. The class ``owner``, to
    which a function belongs, is left out.
    """
    if isinstance(thing, partial):
        return [thing.args, thing.keywords, *bound(thing.func)]
    if inspect.ismethod(thing):
        return [thing.__self__]
    if not _is_code(thing):
        return [] if inspect.isbuiltin(thing) else [thing]
    if getattr(sys.modules.get(thing.__module__), thing.__name__, None) is thing:
        return []
    values: list[Any]
    if inspect.isclass(thing):
        parts = {name: getattr(part, "__func__", part) for name, part in vars(thing).items()}
        kept = (n for n in parts if _is_code(parts[n]) or not n.startswith(("__", "_abc_")))
        owner, values = thing, [*thing.__bases__, *map(parts.__getitem__, kept)]
    else:
        cells = [cell.cell_contents for cell in thing.__closure__ or ()]
        values = [*cells, *(thing.__defaults__ or ()), *(thing.__kwdefaults__ or {}).values()]
    values = [value for value in values if value is not owner]
    return [one for v in values for one in (bound(v, owner) if _is_code(v) else [v])]


def _is_code(thing: Any) -> bool:
    return inspect.isfunction(thing) or inspect.isclass(thing)


def is_own(function: Any) -> bool:
    """Returns whether a class or function is user-defined, not of this package."""
    while isinstance(function, partial):
        function = function.func
    return str(function.__module__).partition(".")[0] not in PACKAGES


def own_functions(record: Any) -> Iterator[Callable[..., Any]]:
    """Yields the user-defined functions in a record, such as a Task or a list of Features."""
    if is_dataclass(record) and not isinstance(record, type):
        record = [getattr(record, f.name) for f in fields(record)]
    if isinstance(record, list | tuple):
        for part in record:
            yield from own_functions(part)
    elif callable(record) and is_own(record):
        yield record


def _notebook_cell(function: Any) -> str:
    """Returns the text of the cell in which a class or function is written, "" if unknown."""
    parts = vars(function).values() if inspect.isclass(function) else [function]
    names = [part.__code__.co_filename for part in parts if inspect.isfunction(part)]
    return "".join(linecache.getlines(names[0])) if names else ""
