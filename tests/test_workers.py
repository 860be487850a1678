"""Episodes in several processes: the same ones, whoever dies meanwhile."""

import importlib
import multiprocessing
import os
import signal
import sqlite3
import subprocess
import sys
import textwrap
import threading
import time
import warnings
from collections import deque
from dataclasses import replace
from pathlib import Path

import joblib
import numpy as np
import pytest
from broken_policies import Exits
from command_line import refused, run
from joblib.externals.loky.process_executor import BrokenProcessPool

from asv_env import make_params
from asv_env.tasks import TASKS, Term
from baselines.evaluate import compare, workers
from baselines.evaluate.api import InputError
from baselines.evaluate.conditions import Condition
from baselines.evaluate.policy_sources import PolicySource, find
from baselines.evaluate.store import NAME as STORE
from baselines.evaluate.store import RunKey
from baselines.evaluate.workers import Job, WorkerError
from baselines.policy import POLICIES, Idle
from baselines.rollout import trajectories
from baselines.rollout.commands import steady
from baselines.rollout.episodes import Label

EPISODES = 40
"""Episodes of a run that is killed, so many that it is not at its end then."""


def job(policy, seeds, num_envs=2, **options):
    source = policy if isinstance(policy, PolicySource) else find(policy)
    params = make_params(**{"task": "push", "time_limit": 0.5, **options})
    key = RunKey("short", source.word, 0)
    return Job(key, params, source, source.fingerprint(), Label(source.word), seeds, num_envs)


def rows(jobs, count):
    done = [(key, log.episode) for key, log in workers.run(jobs, count)]
    return sorted(done, key=lambda pair: (pair[0], pair[1].seed))


def local_policy():
    """A policy that other processes cannot import, like that of a notebook."""

    class Local(Idle):
        def act(self, sensed, observation, memory, fresh):
            action, memory = super().act(sensed, observation, memory, fresh)
            return action + 0.5, memory

    return Local


def gone(pids):
    """Whether all processes end within some seconds."""
    until = time.monotonic() + 20.0
    while time.monotonic() < until and any(Path(f"/proc/{pid}").exists() for pid in pids):
        time.sleep(0.05)
    return not any(Path(f"/proc/{pid}").exists() for pid in pids)


def started(folder):
    """Identities of the workers, which they leave in a folder as soon as they act."""
    until = time.monotonic() + 60.0
    while time.monotonic() < until and not list(folder.iterdir()):
        time.sleep(0.05)
    return [int(file.name) for file in folder.iterdir()]


@pytest.fixture
def stuck(tmp_path):
    """A process whose worker is busy for ever, and the identity of the worker."""
    script = textwrap.dedent(
        """
        import os, pathlib, signal, sys, time
        # A background job ignores Ctrl-C, and what it starts does too.
        signal.signal(signal.SIGINT, signal.default_int_handler)
        sys.path.insert(0, sys.argv[1])
        from test_workers import Idle, job, workers

        class Stuck(Idle):
            folder = pathlib.Path(sys.argv[2])

            def act(self, *arguments):
                (self.folder / str(os.getpid())).touch()
                time.sleep(600.0)

        list(workers.run([job(Stuck, range(1))], 1))
        """
    )
    process = subprocess.Popen(
        [sys.executable, "-c", script, Path(__file__).parent, tmp_path],
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    yield process, started(tmp_path)
    process.kill()
    process.communicate()


def test_a_batch_is_what_runs_side_by_side():
    assert [batch.seeds for batch in job(Idle, range(5)).batches(1)] == [
        range(0, 2),
        range(2, 4),
        range(4, 5),
    ]
    assert [len(batch.seeds) for batch in job(Idle, range(5), 64).batches(2)] == [3, 2]


def test_processes_run_the_same_episodes_of_own_policies_and_tasks():
    term = Term("bonus", lambda now: np.full(len(now.relations.position), 7.0))
    task = replace(TASKS["push"], name="own", reward=(term,))
    jobs = [
        job(local_policy(), range(5)),
        job("scripted", range(3), scenario="harsh"),
        job("random", range(4), task=task),
    ]
    here = rows(jobs, 0)
    assert rows(jobs, 2) == here
    assert [row.task for _, row in here].count("own") == 4
    assert len(here) == 12


def test_processes_can_be_started_from_a_thread():
    jobs, found = [job("random", range(2))], []
    thread = threading.Thread(target=lambda: found.extend(rows(jobs, 1)))
    thread.start()
    thread.join()
    assert found == rows(jobs, 0)


def test_processes_import_a_module_as_it_is_now(tmp_path, monkeypatch):
    """A module that is edited between two runs is not the old one in the second."""
    monkeypatch.syspath_prepend(str(tmp_path))
    efforts = []
    for speed in ("0.0", "1.00"):
        text = f"""
        from baselines.policy import Idle
        class Mine(Idle):
            def act(self, *arguments):
                action, memory = super().act(*arguments)
                return action + {speed}, memory
        """
        (tmp_path / "edited.py").write_text(textwrap.dedent(text))
        monkeypatch.delitem(sys.modules, "edited", raising=False)
        importlib.invalidate_caches()
        ((_, row),) = rows([job("edited:Mine", range(1))], 1)
        efforts.append(row.effort)
    assert efforts[0] == 0.0 < efforts[1]


def test_episodes_run_on_a_dask_cluster(tmp_path):
    distributed = pytest.importorskip("distributed")

    class Signs(local_policy()):
        def act(self, *arguments):
            (tmp_path / str(os.getpid())).touch()
            return super().act(*arguments)

    with (
        distributed.LocalCluster(1, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster),
        joblib.parallel_config("dask"),
    ):
        done = rows([job(Signs, range(3))], 1)
    assert os.getpid() not in started(tmp_path)
    assert done == rows([job(Signs, range(3))], 0)


@pytest.mark.parametrize("backend", ["multiprocessing", "threading", "sequential"])
def test_episodes_run_within_other_backends_of_joblib(backend):
    jobs = [job("random", range(3))]
    with joblib.parallel_config(backend):
        assert rows(jobs, 1) == rows(jobs, 0)


def test_trajectories_are_saved_by_workers(tmp_path):
    recording = Job(**{**vars(job("random", range(3))), "record": tmp_path})
    for _, log in workers.run([recording], 1):
        assert log.trajectory is None
        assert trajectories.holds(tmp_path, log.episode)


def test_episodes_do_not_depend_on_batch_or_workers(network_file, sb3_file):
    files = [find(str(file), trust_pickles=True) for file in (network_file, sb3_file)]
    sources = [*map(find, ("scripted", "paper", "random")), *files]

    def episodes_of(num_envs, count):
        jobs = [job(source, range(6), num_envs, scenario="harsh") for source in sources]
        done = [(log.episode, log.poses.tobytes()) for _, log in workers.run(jobs, count)]
        return sorted(done, key=lambda pair: (pair[0].policy, pair[0].seed))

    alone = episodes_of(1, 0)
    assert len(alone) == 5 * 6
    assert episodes_of(4, 0) == alone
    assert episodes_of(2, 1) == alone


def test_a_policy_that_changes_meanwhile_is_not_mixed(network_file, other_network_file, tmp_path):
    file = tmp_path / "best.npz"
    file.write_bytes(network_file.read_bytes())
    begun = job(str(file), range(1))
    file.write_bytes(other_network_file.read_bytes())
    with pytest.raises(WorkerError, match=r"best\.npz has changed since the run began"):
        rows([begun], 1)


@pytest.mark.usefixtures("no_report")
def test_a_killed_run_goes_on_and_ends_alike(tmp_path):
    arguments = [
        *("--task", "push", "--scenario", "noisy", "--goal", "0", "-0.45", "0"),
        *("--policies", "random", "--episodes", str(EPISODES)),
    ]
    whole_batch = ["--workers", 0, "--num-envs", EPISODES]
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    run(*arguments, *whole_batch, "--out", whole)
    command = [sys.executable, "-m", "baselines.evaluate", *arguments, "--num-envs", "1"]
    process = subprocess.Popen(
        [*command, "--workers", "1", "--out", killed],
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    until = time.monotonic() + 60.0
    while process.poll() is None and not stored(killed) and time.monotonic() < until:
        time.sleep(0.02)
    process.kill()
    process.wait()
    assert 0 < stored(killed) < EPISODES
    assert not (killed / "episodes.csv").exists()
    run(*arguments, *whole_batch, "--out", killed)
    assert (killed / "episodes.csv").read_bytes() == (whole / "episodes.csv").read_bytes()


def stored(folder):
    """Number of episodes in the database of a folder, 0 while it cannot be read."""
    try:
        base = sqlite3.connect(f"file:{folder / STORE}?mode=ro&immutable=1", uri=True)
        return base.execute("SELECT count(*) FROM episode").fetchone()[0]
    except sqlite3.Error:
        return 0


@pytest.mark.usefixtures("own_modules")
def test_the_policy_that_kills_its_worker_is_named_and_others_are_finished():
    found = []
    running = workers.run([job(Exits, range(1)), job(Idle, range(1))], 2)
    with pytest.raises(WorkerError, match="Exits, short, seed 0: its process ended with"):
        found.extend(key.policy for key, _ in running)
    assert found == ["Idle"]


@pytest.mark.usefixtures("own_modules")
def test_a_policy_that_ends_its_process_at_once_is_refused_by_name(tmp_path):
    short = Condition("short", task="push", options={"time_limit": 0.5})
    policies = {"idle": "idle", "fatal": Exits}
    with pytest.raises(InputError, match="fatal: its process ended with exit code 7, as it was"):
        compare(policies, short, 1, tmp_path / "none", workers=1, progress=False)
    assert not (tmp_path / "none").exists()


@pytest.mark.parametrize("error", [RuntimeError("at exit"), BlockingIOError(11, "too many")])
def test_where_no_process_can_be_started_the_remedy_is_named(error, tmp_path, monkeypatch):
    def submit(*_):
        raise error

    monkeypatch.setattr(workers.ProcessPoolExecutor, "submit", submit)
    with pytest.raises(InputError, match=r"no worker process can be started \(.*\): use workers=0"):
        compare({"idle": "idle"}, "quick-v2", 1, tmp_path / "none", workers=1, progress=False)
    assert not (tmp_path / "none").exists()


@pytest.mark.parametrize(
    ("codes", "text"),
    [
        ("SIGKILL(-9)", "was killed (SIGKILL); if memory has run out"),
        ("SIGSEGV(-11)", "was ended by the signal SIGSEGV"),
        ("EXIT(3)", "ended with exit code 3"),
        ("EXIT(0)", "ended with exit code 0"),
        ("nothing", "has failed"),
    ],
)
def test_deaths_are_told_apart(codes, text):
    error = BrokenProcessPool(f"The exit codes of the workers are {{{codes}}}")
    assert text in workers._death(error)
    assert ("memory" in workers._death(error)) == ("KILL" in codes)


def test_one_worker_is_a_process_of_its_own():
    """It does not hear Ctrl-C, and gets what it needs where there are no standard streams."""

    class Tells(Idle):
        def act(self, *arguments):
            blocked = signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, [])
            raise ValueError(os.getpid() != parent, blocked)

    parent = os.getpid()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "stdout", None)
        patch.setattr(sys, "stderr", None)
        ((_, row),) = rows([job(Tells, range(1))], 1)
    assert row.error == "ValueError: (True, True)"
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, [])


def test_a_process_that_may_have_no_children_runs_everything_itself(monkeypatch):
    monkeypatch.setitem(multiprocessing.current_process()._config, "daemon", True)
    assert len(rows([job(local_policy(), range(3))], 2)) == 3


def test_two_comparisons_at_once_do_not_disturb_each_other(tmp_path):
    """Each has its workers and its folder; the first to end does not end those of the other."""
    found, short = {}, Condition("short", task="push", options={"time_limit": 0.5})

    def go(number):
        found[number] = compare(
            {"random": "random"}, short, 1 + 4 * number, tmp_path / str(number), workers=1,
            num_envs=2, progress=False,
        )  # fmt: skip

    threads = [threading.Thread(target=go, args=(number,)) for number in (0, 1)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [len(found[number].episodes) for number in (0, 1)] == [1, 5]
    assert found[0].episodes.equals(found[1].episodes.head(1))


@pytest.mark.usefixtures("no_report")
@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP"])
def test_signals_end_a_run_in_a_line_and_are_the_users_afterwards(name, tmp_path, monkeypatch):
    class Ends(Idle):
        def act(self, *arguments):
            os.kill(os.getpid(), getattr(signal, name))
            return super().act(*arguments)

    monkeypatch.setattr(POLICIES, "_entries", {**POLICIES._entries, "ends": Ends})
    arguments = ["--task", "push", "--episodes", 1, "--policies", "ends", "--workers", 0]
    with pytest.raises(SystemExit) as stopped:
        run(*arguments, "--out", tmp_path)
    assert stopped.value.code.splitlines()[1] == f"stopped by {name}"
    assert signal.getsignal(getattr(signal, name)) is signal.SIG_DFL


def test_workers_that_die_between_batches_are_replaced(monkeypatch):
    """As by what a policy has left behind: nobody is to blame, and nothing is lost."""
    really, pools = workers._in_pool, []

    def in_pool(waiting, running, number, packed):
        pools.append(len(waiting))
        if len(pools) == 1:
            yield from really(deque([waiting.popleft()]), running, number, packed)
            raise BrokenProcessPool("A worker has died")
        yield from really(waiting, running, number, packed)

    monkeypatch.setattr(workers, "_in_pool", in_pool)
    assert len(rows([job(local_policy(), range(4))], 2)) == 4
    assert pools == [2, 1]


def test_workers_that_grow_are_kept(tmp_path):
    """As those do that compile."""

    class Grows(Idle):
        def act(self, sensed, *others):
            (tmp_path / str(os.getpid())).touch()
            if not sensed.tick.any():
                vars(sys).setdefault("held", []).append(b"x" * 350_000_000)
                time.sleep(1.1)  # the least time between two checks
            return super().act(sensed, *others)

    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        assert len(rows([job(Grows, range(6))], 1)) == 6
    assert len(started(tmp_path)) == 1
    assert not heard


@pytest.mark.usefixtures("no_report")
def test_a_module_that_begins_an_evaluation_when_it_is_imported_is_refused(
    tmp_path, monkeypatch, capsys
):
    text = """
        from baselines import evaluate
        from baselines.policy import Idle as Bare
        evaluate.main("--task push --episodes 1 --policies bare_script:Bare --workers 1".split())
    """
    (tmp_path / "bare_script.py").write_text(textwrap.dedent(text))
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.chdir(tmp_path)
    arguments = ["--task", "push", "--episodes", 1, "--out", tmp_path / "none"]
    message = refused(capsys, *arguments, "--policies", "bare_script:Bare")
    assert 'if __name__ == "__main__"' in message
    assert not (tmp_path / "none").exists()


def test_a_policy_that_cannot_be_sent_is_named():
    class Locked(Idle):
        lock = threading.Lock()

    message = "Locked, short, seeds 0 to 3: the policy or the task cannot be sent .*lock.*workers=0"
    with pytest.raises(WorkerError, match=message):
        rows([job(Locked, range(4))], 2)
    assert len(rows([job(Locked, range(4))], 0)) == 4


def test_what_cannot_be_made_in_a_worker_fails_its_episodes():
    class Unmade(Idle):
        def __init__(self, params):
            raise ValueError("I only play approach")

    found = [row for _, row in rows([job(Unmade, range(4)), job(Idle, range(2))], 1)]
    assert [row.error for row in found] == [None] * 2 + ["ValueError: I only play approach"] * 4
    assert [row.error for _, row in rows([job(Unmade, range(4))], 0)] == [found[-1].error] * 4


def test_workers_end_with_a_parent_that_is_killed(stuck):
    process, pids = stuck
    process.kill()
    assert pids
    assert gone(pids)


def test_ctrl_c_is_heard_by_the_parent_alone(stuck):
    process, pids = stuck
    os.killpg(process.pid, signal.SIGINT)
    said = process.communicate(timeout=20.0)[1]
    assert said.count("Traceback") == 1
    assert said.rstrip().endswith("KeyboardInterrupt")
    assert gone(pids)


def test_a_policy_is_not_blamed_where_no_process_can_be_started(monkeypatch):
    monkeypatch.setattr(sys, "executable", "/bin/false")
    with pytest.raises(InputError, match="no worker process can be started, it ended with exit"):
        compare({"idle": "idle"}, make_params("push", time_limit=0.5), 1, workers=1)


def test_processes_import_nothing_from_the_current_folder(tmp_path, monkeypatch):
    for name in ("joblib", "numpy", "asv_env"):
        (tmp_path / f"{name}.py").write_text("raise RuntimeError('of the current folder')")
    monkeypatch.chdir(tmp_path)
    ((_, row),) = rows([job("idle", range(1))], 1)
    assert row.error is None


@pytest.mark.parametrize("name", ["SIGTERM", "SIGINT"])
def test_a_signal_that_comes_where_errors_are_lost_is_heard_afterwards(name):
    class Frees:
        def __del__(self):
            os.kill(os.getpid(), getattr(signal, name))

    @steady()
    def waits():
        Frees()
        time.sleep(5.0)

    with pytest.raises(KeyboardInterrupt, match="SIGTERM" if name == "SIGTERM" else "^$"):
        waits()
