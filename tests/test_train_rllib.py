"""``python -m train --engine rllib``: it learns, is killed and resumed; where Ray is installed."""

import doctest
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest

from asv_env import make_params
from baselines.learned import policy_file
from baselines.rollout import runner, seeds

if "ENGINES_MUST_RUN" not in os.environ:
    pytest.importorskip("ray", reason="ray is not installed, see docs/engines.md")

ROOT = Path(__file__).parents[1]
TINY_OPTIONS = """
    --engine rllib --num-env-runners 2 --num-envs 4 --num-steps 16 --num-minibatches 2
    --update-epochs 2 --hidden 16 16 --scenarios noisy --time-limit 5
    --imitation.rounds 1 --imitation.worlds 4
    --imitation.time 3 --imitation.steps 20 --total-timesteps 1024 --checkpoint-every 256
    --evaluation.every 512 --evaluation.episodes 2 --torch-threads 1
"""
TINY = TINY_OPTIONS.split()
"""Options of a training that is over in seconds; 256 timesteps an update."""


@pytest.fixture
def temporary():
    """A folder whose path is short, as Ray's sockets need it."""
    with tempfile.TemporaryDirectory() as folder:
        yield folder


@pytest.fixture
def started(temporary, tmp_path):
    """A function that starts ``python -m train``; what Ray writes is deleted."""
    path = f"{ROOT}{os.pathsep}{ROOT / 'tests'}"
    variables = {**os.environ, "HOME": str(tmp_path), "TMPDIR": temporary, "PYTHONPATH": path}

    def start(*options):
        command = [sys.executable, "-m", "train", *TINY, "--task", "train_helpers:SHORT", *options]
        return subprocess.Popen(command, cwd=ROOT, env=variables, stderr=subprocess.DEVNULL)

    return start


def curve(folder):
    """Timesteps of the evaluations."""
    file = folder / "curve.csv"
    if not file.exists():
        return []
    return [int(line.split(",")[0]) for line in file.read_text().splitlines()[1:]]


def checkpoint(folder):
    """Timesteps of the checkpoint, None without one."""
    last = folder / "checkpoint/last"
    return int(last.read_text().partition("-")[0]) if last.exists() else None


def parsed(*options):
    from train.config import parse

    return parse([*TINY, *map(str, options)])


def test_a_run_that_is_killed_is_resumed(started, tmp_path):
    from train.rllib.engine import train

    folder = tmp_path / "run"
    process = started("--out", str(folder))
    try:
        while not checkpoint(folder):
            assert process.poll() is None
            time.sleep(0.02)
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
    saved, seen = checkpoint(folder), curve(folder)
    assert 256 <= saved < 1024

    assert started("--out", str(folder)).wait() == 0
    now = curve(folder)
    kept = [timesteps for timesteps in seen if timesteps <= saved]
    assert now[: len(kept)] == kept
    assert now[0] == 0
    assert (np.diff(now) > 0).all()
    assert now[-1] == checkpoint(folder) >= 1024
    assert {path.name for path in folder.iterdir()} - {".lock"} == {
        *("config.json", "checkpoint", "curve.csv", "best.npz", "policy.npz", "tensorboard"),
    }
    assert json.loads((folder / "config.json").read_text())["libraries"]["ray"]
    assert len(list((folder / "checkpoint").iterdir())) == 2
    assert not (tmp_path / ".ray").exists()  # the token

    before = {path: path.stat().st_mtime_ns for path in folder.rglob("*")}
    train(parsed("--task", "train_helpers:SHORT", "--out", folder))  # is over
    assert {path: path.stat().st_mtime_ns for path in folder.rglob("*")} == before

    params = make_params("push")
    policy = policy_file.load(folder / "best.npz", params)
    (track,) = runner.run(lambda _: policy, params, [seeds.DEVELOPMENT.start], 1)
    assert track.episode.error is None


def test_every_process_begins_with_the_weights_of_the_learner(temporary, tmp_path, monkeypatch):
    from train.rllib.checkpoints import distribute_weights, module_of
    from train.rllib.engine import begin
    from train.rllib.settings import connected, settings

    monkeypatch.setenv("RAY_TMPDIR", temporary)
    monkeypatch.setattr("ray.tune.trainable.trainable.DEFAULT_STORAGE_PATH", str(tmp_path))
    config = parsed("--num-env-runners", 1, "--imitation.rounds", 0)

    def of_actor(module):
        layers = {name: value.numpy() for name, value in module.state_dict().items()}
        return {name: layers[name] for name in layers if "pi." in name or "actor" in name}

    with connected(config):
        algorithm = settings(config, 0).build_algo()
        begin(algorithm, config, None)
        distribute_weights(algorithm)
        mine = of_actor(module_of(algorithm))
        (theirs,) = algorithm.env_runner_group.foreach_env_runner(
            lambda runner: of_actor(runner.module["boat"]), local_env_runner=False
        )
        algorithm.stop()
    assert (mine["pi.log_std"] == config.network.log_std_init).all()
    assert theirs.keys() == mine.keys()
    assert all(np.array_equal(theirs[name], mine[name]) for name in mine)


def process_of(config, number, done=0):
    """The worlds of a process that samples, and the episodes of its first steps."""
    from ray.rllib.env.multi_agent_env_runner import MultiAgentEnvRunner

    from train.rllib.settings import settings

    runner = MultiAgentEnvRunner(config=settings(config, done), worker_index=number)
    episodes = runner.sample(num_timesteps=30 * 2 * 4, random_actions=True)
    return [env.unwrapped.par_env for env in runner.env.envs], episodes


def test_worlds_have_seeds_of_training_and_scenarios_of_their_own():
    config = parsed("--scenarios", "noisy", "nominal", "--seed", 3)
    worlds = [world for number in (1, 2) for world in process_of(config, number)[0]]
    given = [world.simulation._rngs[0].bit_generator.seed_seq.entropy for world in worlds]
    assert given == [1_003_000_000 + number for number in range(4)]
    assert [world.params.sensors.position_noise > 0 for world in worlds] == [True, False] * 2
    (later, _), _ = process_of(config, 1, done=512)
    assert later.simulation._rngs[0].bit_generator.seed_seq.entropy == 1_003_000_512


def test_the_end_of_the_time_is_a_truncation_and_not_the_same_for_all():
    _, episodes = process_of(parsed(), 2)
    over = [episode for episode in episodes if episode.is_done]
    lengths = [len(boat) for episode in over for boat in episode.agent_episodes.values()]
    assert lengths[:8] == [19] * 4 + [25] * 4  # 3 and 4 quarters of 5 s, 5 decisions each
    for episode in over:
        for boat in episode.agent_episodes.values():
            assert (boat.is_terminated, boat.is_truncated) == (False, True)


def test_worlds_are_numbered_over_processes_as_the_example_says():
    from train.rllib import env

    assert doctest.testmod(env).attempted == 2
    assert doctest.testmod(env).failed == 0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ("--teams 4 6", "teams = (4, 6) with engine = 'rllib': it trains one team size"),
        ("--critic central", "critic = 'central' with engine = 'rllib'"),
        ("--curriculum.step 0.5", "step = 0.5 with engine = 'rllib': only sb3 knows that"),
        ("--curriculum.rollout-starts 0.5", "rollout_starts = 0.5 with engine = 'rllib'"),
        ("--log-std-min -1", "log_std_min = -1.0 with engine = 'rllib'"),
        (
            "--residual 0.5 --decision-rate 10 --imitation.rounds 0",
            "residual = 0.5 with engine = 'rllib'",
        ),
    ],
)
def test_what_only_sb3_can_do_is_refused(options, message, tmp_path):
    from train.__main__ import main

    with pytest.raises(SystemExit) as refusal:
        main([*TINY, "--out", str(tmp_path / "run"), *options.split()])
    assert message in str(refusal.value)
    assert "engine = 'sb3'" in str(refusal.value)
    assert not (tmp_path / "run").exists()
