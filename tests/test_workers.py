"""Episodes over several processes: killed, broken, and always the same."""

import sqlite3
import subprocess
import sys
import time

import pytest

from baselines.evaluate.conditions import Condition
from baselines.evaluate.policy_sources import find
from baselines.evaluate.store import NAME as STORE
from baselines.evaluate.store import Series
from baselines.evaluate.workers import Job, WorkerError
from baselines.evaluate.workers import run as run_jobs
from baselines.rollout.episodes import Label

pytestmark = pytest.mark.usefixtures("no_report")

EPISODES = 40
"""Episodes of a run that is killed again and again."""


def test_a_killed_run_goes_on_and_ends_alike(tmp_path):
    """Killed three times, each time after some more episodes."""
    command = [
        *(sys.executable, "-m", "baselines.evaluate", "--task", "push", "--scenario", "noisy"),
        *("--goal", "0", "-0.45", "0", "--policies", "scripted", "--episodes", str(EPISODES)),
        *("--workers", "2", "--num-envs", "2"),
    ]
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    subprocess.run([*command, "--out", whole], check=True, capture_output=True)
    kept = [0]
    for _ in range(3):
        process = subprocess.Popen(
            [*command, "--out", killed], stderr=subprocess.DEVNULL, start_new_session=True
        )
        until = time.monotonic() + 60.0
        while process.poll() is None and stored(killed) <= kept[-1] and time.monotonic() < until:
            time.sleep(0.02)
        process.kill()
        process.wait()
        kept.append(stored(killed))
        assert kept[-2] < kept[-1] < EPISODES
        assert not (killed / "episodes.csv").exists()
    subprocess.run([*command, "--out", killed], check=True, capture_output=True)
    assert (killed / "episodes.csv").read_bytes() == (whole / "episodes.csv").read_bytes()


def stored(folder):
    """Episodes in the database of a folder, 0 while it cannot be read."""
    try:
        base = sqlite3.connect(f"file:{folder / STORE}?mode=ro&immutable=1", uri=True)
        return base.execute("SELECT count(*) FROM episode").fetchone()[0]
    except sqlite3.Error:
        return 0


def test_episodes_do_not_depend_on_batch_or_workers(network_file, sb3_file):
    condition = Condition("short", task="push", scenario="harsh", options={"time_limit": 1.0})

    def episodes_of(num_envs, workers, words):
        jobs = [
            job(condition, word, seeds, num_envs)
            for word in words
            for seeds in (range(64), range(64, 70))
        ]
        done = [track for _, track in run_jobs(jobs, workers)]
        done.sort(key=lambda track: (track.episode.policy, track.episode.seed))
        return [(track.episode, track.poses.tobytes()) for track in done]

    words = ["scripted", "paper", "random", str(network_file), str(sb3_file)]
    alone = episodes_of(1, 0, words)
    assert len(alone) == 5 * 70
    assert episodes_of(16, 0, words) == alone
    assert episodes_of(64, 2, words) == alone


def job(condition, word, seeds, num_envs=1):
    source, series = find(word, trust_pickles=True), Series(condition.name, word, 0)
    return Job(series, condition, source, source.fingerprint(), Label(word), tuple(seeds), num_envs)


@pytest.mark.usefixtures("own_modules")
def test_a_worker_that_dies_is_noticed():
    condition = Condition("short", task="push", options={"time_limit": 1.0})
    source = find("broken_policies:Dies")
    dying = Job(
        Series("short", "Dies", 0), condition, source, source.fingerprint(), Label("Dies"), (0,), 1
    )
    with pytest.raises(WorkerError, match="exit code -9"):
        list(run_jobs([dying], 1))


def test_a_policy_that_changes_meanwhile_is_not_mixed(network_file, other_network_file, tmp_path):
    condition = Condition("short", task="push", options={"time_limit": 1.0})
    file = tmp_path / "best.npz"
    file.write_bytes(network_file.read_bytes())
    begun = job(condition, str(file), (0,))
    file.write_bytes(other_network_file.read_bytes())
    with pytest.raises(WorkerError, match=r"best\.npz has changed since the run began"):
        list(run_jobs([begun], 1))
