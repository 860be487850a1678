"""Paths, numbers and names that a shell user may type: taken, or refused with the reason."""

import os
from pathlib import Path

import pytest
from command_line import SHORT, refused, rows, run
from hypothesis import given
from hypothesis import strategies as st

from baselines.evaluate import command
from baselines.evaluate.api import compare
from baselines.evaluate.command import Options, as_flags, folder_name

pytestmark = pytest.mark.usefixtures("no_report")
IDLE = [*SHORT, "--policies", "idle", "--episodes", 1]
TYPED = st.one_of(
    st.sampled_from(
        ["idle", "scripted", "a=idle", "=idle", "a=", "a=b=idle", "idle,", ",", "a,b", "", " ", ".",
         "..", "/", "~", "./x.npz", "~/x.npz", "x.zip", ".npz", "idle:", ":idle", "os:getcwd",
         "os:nothing", "os:path:join", "..x:y", "a b", "-", "--", "con=idle", "A=idle", "x" * 300,
         "٣", "${HOME}", "*", "\\", "a\nb", "<b>=idle"]
    ),
    st.text(max_size=12),
)  # fmt: skip


class Asked(Exception):  # noqa: N818
    """The comparison would begin."""


@given(
    policies=st.lists(TYPED, min_size=1, max_size=3),
    numbers=st.tuples(*[st.sampled_from([-1, 0, 1, 7, 10**6, 10**7, 10**30])] * 4),
    out=st.sampled_from(["", ".", "new", "a b", "ü", "n/", "/dev/null", "x" * 300, "a/" * 2000]),
    goal=st.sampled_from([None, (0.5, 0.1, 0.0), (float("nan"), 0.0, 0.0), (9e99, 0.0, 0.0)]),
    boats=st.sampled_from([(), (4,), (0,), (4, 4), (10**30,)]),
    words=st.tuples(TYPED, TYPED, TYPED),
)
def test_whatever_is_typed_is_taken_or_refused_in_one_line(
    policies, numbers, out, goal, boats, words
):
    """Up to the point where the first episode would run."""
    episodes, seed, workers, replays = numbers
    suite, task, scenario = words
    options = Options(
        policies=tuple(policies), episodes=episodes, seed=seed, workers=workers, out=out,
        replays=replays, goal=goal, num_boats=boats, num_envs=abs(seed),
    )  # fmt: skip
    if len(suite) % 3 == 0:
        options = Options(**{**vars(options), "suite": suite, "task": (task,)})
    elif len(suite) % 3 == 1:
        options = Options(**{**vars(options), "scenario": (scenario,)})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(command.tyro, "cli", lambda *_, **__: options)
        patch.setattr("baselines.evaluate.api.Store", lambda *_: (_ for _ in ()).throw(Asked))
        patch.setattr("baselines.evaluate.workers.check_fit", lambda *_: None)
        patch.setattr("sys.stderr", printed := Printed())
        with pytest.raises((SystemExit, Asked)) as stopped:
            command.main([])
    if stopped.type is SystemExit:
        assert stopped.value.code == 2
        assert printed.text.startswith("python -m baselines.evaluate: error: ")
        assert printed.text.count("\n") == 1
        assert printed.text.rstrip("\n").isprintable()
    assert not Path("new").exists()


class Printed:
    """A stream that keeps what is printed."""

    def __init__(self):
        self.text = ""

    def write(self, text):
        self.text += text

    def flush(self):
        pass


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--episodes", "9999999999999"], "--episodes 9999999999999: must be a whole number"),
        (["--workers", "100000"], "--workers 100000: must be a whole number, 0 to 1024"),
        (["--seed", str(10**30)], "must lie below"),
        (["--out", ""], "name a folder"),
        (["--out", "/dev/null"], "is no folder"),
        (["--out", "z" * 400], "cannot be used: file name too long; choose a shorter name"),
        (["--policies", "="], "unknown policy ''"),
        (["--policies", "z" * 4000], "unknown policy 'zzz"),
        (["--policies", "PPO=idle", "ppo=random"], "more than upper and lower case"),
        (["--policies", "con=idle"], "cannot be a name"),
        (["--policies", "mine=idle,"], "need a name each"),
        (["--policies", "."], "is a folder"),
        (["--video", "/nowhere/film.gif"], "folder that exists"),
    ],
)
def test_what_cannot_be_is_refused(arguments, message, capsys, tmp_path):
    out = [] if "--out" in arguments else ["--out", tmp_path / "none"]
    assert message in refused(capsys, *IDLE, *out, *arguments)
    assert not (tmp_path / "none").exists()


@pytest.mark.parametrize("episodes", ["1e3", "1.0", "many", "0x10"])
def test_what_is_no_number_is_refused_by_the_parser(episodes):
    with pytest.raises(SystemExit) as stopped:
        run(*IDLE, "--episodes", episodes)
    assert stopped.value.code == 2


@pytest.mark.parametrize(
    "name", ["with space", "ünïcode 船", "slash/", "a/b/c", "-dash", "$HOME", "~not-home"]
)
def test_folders_of_any_name_are_taken(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run(*IDLE, "--episodes", "١", f"--out={name}")
    assert len(rows(tmp_path / name)) == 1


def test_the_home_folder_is_meant_by_a_tilde(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("USERPROFILE", str(tmp_path))
    run(*IDLE, "--out=~/mine")
    assert len(rows(tmp_path / "mine")) == 1


def test_a_link_to_nowhere_is_refused(tmp_path, capsys):
    (tmp_path / "link").symlink_to(tmp_path / "nowhere")
    assert "is no folder" in refused(capsys, *IDLE, "--out", tmp_path / "link")


def test_results_are_where_the_command_said_though_a_policy_moves(tmp_path, monkeypatch, capsys):
    from broken_policies import Idle

    class Moves(Idle):
        def act(self, *arguments):
            os.chdir("/")
            return super().act(*arguments)

    monkeypatch.chdir(tmp_path)
    quiet = {"workers": 0, "progress": False, "record": True}
    found = compare({"moves": Moves, "idle": "idle"}, "quick-v2", 1, "here", task="push", **quiet)
    assert os.getcwd() == str(tmp_path)
    assert (tmp_path / "here" / "episodes.csv").exists()
    assert len(list((tmp_path / "here").rglob("*.npz"))) == len(found.episodes)


def test_the_default_folder_of_a_task_with_an_odd_name_is_below_runs():
    from dataclasses import replace

    from asv_env.tasks import PUSH
    from baselines.evaluate.suites import sweep

    suite = sweep(task=(replace(PUSH, name="../../x " + "y" * 200),))
    name = folder_name(suite)
    assert Path(name).name == name
    assert len(name) < 120


def test_messages_speak_of_options():
    assert as_flags("num_envs=0: or trust_pickles=True") == "--num-envs 0: or --trust-pickles"
