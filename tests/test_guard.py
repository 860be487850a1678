"""The guard round a policy: whatever goes wrong in it is a line of text, and of one episode."""

import asyncio
import decimal
import os
import signal
import sys
import unicodedata
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from asv_env import Simulation, make_params
from asv_env.text import LONGEST, described, one_line
from baselines.policy import Idle, Random, checked_action
from baselines.rollout import film, runner
from baselines.rollout.commands import steady
from baselines.rollout.guard import Guard, PolicyError
from baselines.rollout.loop import rollout
from baselines.rollout.process_state import Terminated, neutral, restored

PARAMS = make_params("push", time_limit=0.5)
FINE = np.zeros((1, 4, 2), dtype=np.float32)


def acting(act, made=lambda: None):
    """Factory of a policy whose ``act`` calls a function; ``made`` is called where it is made."""

    class Policy(Idle):
        def __init__(self, params):
            made()

        def act(self, sensed, observation, memory, fresh):
            return act(sensed, observation, memory, fresh)

    return Policy


def giving(action):
    return acting(lambda *_: (action, None))


def raising(error):
    def act(*_):
        raise error

    return acting(act)


def error_of(factory, seeds=(0,)):
    """The error of the first episode of a policy."""
    return next(runner.run(factory, PARAMS, list(seeds), 1)).episode.error


# Kinds of errors


class MuteError(Exception):
    def __str__(self):
        raise SystemExit("cannot say")


class NoTextError(Exception):
    def __str__(self):
        return None


class Sly(str):
    """A text that lies about itself."""

    __slots__ = ()

    def split(self, *_):
        raise RuntimeError("no")

    __getitem__ = __len__ = __iter__ = isprintable = split


class LiesError(Exception):
    def __str__(self):
        return Sly("as\nit is")


class Meta(type):
    @property
    def __name__(cls):
        raise KeyError("nameless")


class NamelessError(Exception, metaclass=Meta):
    pass


class UnpicklableError(Exception):
    def __init__(self):
        super().__init__(lambda: 0)

    def __reduce__(self):
        raise TypeError("stays here")


def deep():
    return deep()


class Endless(BaseException):
    pass


@pytest.mark.parametrize(
    ("error", "text"),
    [
        (SystemExit("no weights"), "SystemExit: no weights"),
        (SystemExit(), "SystemExit"),
        (GeneratorExit(), "GeneratorExit"),
        (asyncio.CancelledError(), "CancelledError"),
        (StopIteration(3), "StopIteration: 3"),
        (Endless("own"), "Endless: own"),
        (MemoryError(), "MemoryError"),
        (MuteError(), "MuteError: its text cannot be read"),
        (NoTextError(), "NoTextError: its text cannot be read"),
        (LiesError(), "LiesError: as it is"),
        (NamelessError("x"), "error: x"),
        (type("Odd\nname\x1b", (Exception,), {})(), "Odd name\\x1b"),
        (ExceptionGroup("two", [ValueError("a"), KeyError("b")]), "sub-exceptions): ValueError: a"),
        (BaseExceptionGroup("b", [SystemExit(1)]), "SystemExit: 1"),
        (FileNotFoundError(os.fsdecode(b"weights-\xff.npz")), "weights-\\udcff.npz"),
        (ValueError("\x1b[31mred\x07\x00"), "ValueError: \\x1b[31mred\\x07\\x00"),
        (ValueError("a\u202eb\u2028c\r\nd"), "ValueError: a\\u202eb c d"),
    ],
)
def test_any_error_is_a_line(error, text):
    found = error_of(raising(error))
    assert text in found
    assert found.isprintable()
    assert len(found) <= LONGEST


def test_an_error_that_is_huge_is_cut():
    found = error_of(raising(ValueError("x" * 2_000_000)))
    assert found.startswith("ValueError: xxx")
    assert found.endswith("...")
    assert len(found) == LONGEST


def test_a_recursion_without_end_is_an_error():
    assert "RecursionError" in error_of(acting(lambda *_: deep()))


def test_an_error_that_cannot_be_sent_fails_its_episodes_in_workers_too():
    assert error_of(raising(UnpicklableError())).startswith("UnpicklableError: <function")


def test_ctrl_c_gets_through():
    with pytest.raises(KeyboardInterrupt):
        error_of(raising(KeyboardInterrupt()))


def test_what_looks_like_ctrl_c_is_an_error_where_ctrl_c_is_ignored():
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        assert error_of(raising(KeyboardInterrupt("me"))) == "KeyboardInterrupt: me"
    finally:
        signal.signal(signal.SIGINT, before)


def test_another_signal_ends_a_command_in_the_background_while_a_policy_acts():
    """A shell starts it with Ctrl-C ignored."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with steady(), pytest.raises(Terminated):
            error_of(acting(lambda *_: signal.raise_signal(signal.SIGTERM)))
    finally:
        signal.signal(signal.SIGINT, before)


@given(st.text(st.characters(codec=None), max_size=300))
def test_any_text_is_one_printable_line(text):
    line = one_line(text)
    assert line.isprintable()
    assert len(line) <= LONGEST
    assert not any(unicodedata.category(c) in ("Cc", "Cs", "Cf") for c in line)
    assert one_line(line) == line
    assert described(ValueError(text)).isprintable()


# What a policy returns


class Hostile:
    """Has an array, it says."""

    def __array__(self, *_, **__):
        raise SystemExit("no array")


class Pair(tuple):
    __slots__ = ()

    def __iter__(self):
        raise OSError("not today")


@pytest.mark.parametrize(
    ("action", "text"),
    [
        (Hostile(), "SystemExit: no array"),
        (FINE + 0j, "dtype complex64: give real numbers"),
        (FINE.astype(object), "dtype object: give real numbers"),
        ([[[decimal.Decimal(0)] * 2] * 4], "dtype object"),
        ([[[None, 0.0]] * 4], "dtype object"),
        (FINE.astype("<U3"), "give real numbers"),
        (FINE.astype("M8[s]"), "give real numbers"),
        (np.zeros((1, 4), dtype=[("a", "f4"), ("b", "f4")]), "give real numbers"),
        ([[[0.0] * 2] * 3 + [[0.0]]], "cannot be read"),
        (np.ma.masked_array(FINE, FINE == 0), "masked"),
        (FINE[0], "must be (1, 4, 2)"),
        (FINE[..., None], "must be (1, 4, 2)"),
        (0.0, "must be (1, 4, 2)"),
        (None, "dtype object"),
        (FINE + np.nan, "action not finite at tick 0"),
        (FINE.astype(np.longdouble) - np.inf, "action not finite at tick 0"),
    ],
)
def test_what_is_no_action_is_named(action, text):
    assert text in error_of(giving(action))


@pytest.mark.parametrize(
    "decided", [None, FINE, [FINE, None], (FINE,), (FINE, None, None), Pair((FINE, None))]
)
def test_what_is_no_pair_is_named(decided):
    found = error_of(acting(lambda *_: decided))
    assert "return (action, memory)" in found or "OSError: not today" in found


@pytest.mark.parametrize(
    "action",
    [
        FINE.astype(np.float16), FINE.astype(np.int8), FINE.astype(np.uint64), FINE > 0,
        FINE.astype(">f8"), FINE.tolist(), np.ma.masked_array(FINE), FINE.astype(np.longdouble),
    ],
)  # fmt: skip
def test_all_real_numbers_are_an_action(action):
    assert error_of(giving(action)) is None


def test_numbers_of_any_size_are_clipped():
    huge = np.array([1e300, -1e300, 0.25, 2.0, -0.5, 1.0, -1.0, 0.0]).reshape(1, 4, 2)
    wanted = np.clip(huge, -1, 1).astype(np.float32)
    with np.errstate(all="raise"):
        np.testing.assert_array_equal(checked_action(huge, huge.shape), wanted)
    assert checked_action(FINE + 255, FINE.shape).max() == 1.0


def test_a_tensor_that_requires_grad_is_named_with_the_remedy():
    torch = pytest.importorskip("torch")
    found = error_of(giving(torch.zeros(1, 4, 2, requires_grad=True)))
    assert "Use tensor.detach().numpy()" in found


# Where it goes wrong


def test_a_policy_that_cannot_be_made_fails_every_episode_alone():
    def made():
        raise GeneratorExit("never")

    logs = list(runner.run(acting(None, made), PARAMS, [1, 2, 3], 2))
    assert [log.episode.error for log in logs] == ["GeneratorExit: never"] * 3


@pytest.mark.parametrize("num_envs", [1, 3])
def test_a_failed_episode_leaves_nothing_to_the_next(num_envs):
    """A policy that counts its decisions, which it must not, fails once in every second episode."""

    class Counts(Idle):
        def __init__(self, params):
            self.number = 0

        def act(self, sensed, observation, memory, fresh):
            self.number += 1
            if self.number == 3 and int(observation[0, 0, 0] * 1e6) >= 0:
                raise SystemExit(self.number)
            return super().act(sensed, observation, memory, fresh)

    logs = list(runner.run(Counts, PARAMS, [1, 2, 3], num_envs))
    assert {log.episode.error for log in logs} == {"SystemExit: 3"}
    assert {log.episode.duration for log in logs} == {0.3}


def test_several_worlds_fail_together_with_the_text():
    simulation = Simulation(PARAMS, 2)
    guard = Guard(raising(OSError("full")), PARAMS)
    with pytest.raises(PolicyError, match="OSError: full"):
        next(rollout(simulation, guard.act, [0, 1]))


def test_a_film_ends_where_the_policy_fails():
    def act(sensed, observation, memory, fresh):
        if sensed.tick[0] == 2:
            raise SystemExit
        return FINE, None

    assert len(list(film.frames(acting(act), PARAMS, 0))) == 1 + film.LAST


# What a policy writes to


@pytest.mark.parametrize("record", [False, True])
def test_what_is_written_to_ones_own_copies_changes_nothing(record):
    def scribbling(sensed, observation, memory, fresh):
        action, memory = Random(PARAMS).act(sensed, observation, memory, fresh)
        observation[...] = np.nan
        fresh[...] = True
        for array in vars(sensed).values():
            array[...] = 0
        return action, (memory, action)

    def remembering(sensed, observation, memory, fresh):
        if memory is not None:
            memory[1][...] = 7.0  # the action of the last tick
        return scribbling(sensed, observation, memory and memory[0], fresh)

    runs = [
        list(runner.run(each, PARAMS, [3, 4], 2, record=record))
        for each in (Random, acting(remembering))
    ]
    for plain, written in zip(*runs, strict=True):
        assert plain.episode == written.episode
        np.testing.assert_array_equal(plain.poses, written.poses)
        if record:
            for name in ("observation", "action", "goal"):
                one, other = (getattr(log.trajectory, name) for log in (plain, written))
                np.testing.assert_array_equal(one, other)


# What a policy changes in the process


def test_errors_of_numbers_are_not_what_the_user_or_a_policy_has_set():
    def act(sensed, observation, memory, fresh):
        assert np.geterr()["under"] == "ignore"
        np.float64(1e-300) * np.float64(1e-300)
        np.seterr(all="raise")
        return Random(PARAMS).act(sensed, observation, memory, fresh)

    plain = list(runner.run(Random, PARAMS, [5], 1))
    with np.errstate(all="raise"):
        found = list(runner.run(acting(act), PARAMS, [5], 1))
        assert np.geterr()["under"] == "raise"
    assert found[0].episode == plain[0].episode


def test_what_a_policy_changes_is_put_back(tmp_path, monkeypatch):
    torch = pytest.importorskip("torch")
    monkeypatch.chdir(tmp_path)
    folder, streams, filters = os.getcwd(), (sys.stdout, sys.stderr), list(warnings.filters)
    (tmp_path / "other").mkdir()
    with restored():
        os.chdir("other")
        sys.stdout = sys.stderr = None
        warnings.simplefilter("error")
        torch.set_default_dtype(torch.float64)
    assert os.getcwd() == folder
    assert (sys.stdout, sys.stderr) == streams
    assert list(warnings.filters) == filters
    assert torch.get_default_dtype() == torch.float32


@pytest.mark.parametrize("alarm", [0.0, 100.0])
def test_what_a_policy_does_with_signals_and_recursion_is_put_back(alarm):
    """An alarm that the user has set is still to come."""
    limit, handler = sys.getrecursionlimit(), signal.getsignal(signal.SIGALRM)
    signal.setitimer(signal.ITIMER_REAL, alarm)
    try:
        with restored():
            sys.setrecursionlimit(limit + 1)
            signal.signal(signal.SIGALRM, signal.SIG_IGN)
            signal.setitimer(signal.ITIMER_REAL, 50.0)
            signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        assert bool(signal.getitimer(signal.ITIMER_REAL)[0]) == bool(alarm)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
    assert (sys.getrecursionlimit(), signal.getsignal(signal.SIGALRM)) == (limit, handler)
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, [])


def test_warnings_that_are_errors_of_the_user_end_nothing():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with neutral():
            warnings.warn("by the way", DeprecationWarning, stacklevel=1)
        with pytest.raises(UserWarning, match="by the way"):
            warnings.warn("by the way", stacklevel=1)
