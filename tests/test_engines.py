"""The examples of docs/engines.md run, each where its engine is installed."""

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest
import torch

import asv_env

PAGE = (Path(__file__).parents[1] / "docs/engines.md").read_text()
SINGLE_FILE, TORCHRL, _, RLLIB = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
EXAMPLES = {
    "cleanrl": (
        "torch",
        SINGLE_FILE,
        {"num_envs=64": "num_envs=4", "steps=128": "steps=16", "updates=150": "updates=2"},
    ),
    "torchrl": ("torchrl", TORCHRL, {"8192": "1024", "1_228_800": "2048"}),
    "rllib": ("ray", RLLIB, {"4096": "128", "1024": "128", "range(50)": "range(2)"}),
}
"""{engine: (the library it needs, its example, {what is long: what is short})}."""


def shortened(engine):
    """The engine's example, with episodes and a training of a few steps; skips without it."""
    library, example, numbers = EXAMPLES[engine]
    if "ENGINES_MUST_RUN" not in os.environ:
        pytest.importorskip(library, reason=f"{library} is not installed, see docs/engines.md")
    for long, short in {"time_limit=30": "time_limit=1", **numbers}.items():
        assert long in example
        example = example.replace(long, short)
    return example


@pytest.mark.parametrize("engine", EXAMPLES)
def test_the_example_runs(engine, tmp_path):
    (tmp_path / "example.py").write_text(shortened(engine))
    with tempfile.TemporaryDirectory() as sockets:  # Ray's, whose paths must be short
        exported = {"RAY_AUTH_MODE": "disabled", "RAY_TMPDIR": sockets, "OMP_NUM_THREADS": "1"}
        exported["HOME"] = str(tmp_path)  # where Ray writes its results
        run = subprocess.run(
            [sys.executable, "example.py"],
            cwd=tmp_path,
            env={**os.environ, **exported},
            stdout=subprocess.PIPE,
            text=True,
            check=True,
        )
    assert np.isfinite(float(run.stdout.split()[-1]))


def test_rllib_takes_the_time_limit_for_a_truncation():
    definitions = {}
    exec(shortened("rllib").partition("\nray.init")[0], definitions)
    from ray.rllib.env.multi_agent_env_runner import MultiAgentEnvRunner

    runner = MultiAgentEnvRunner(config=definitions["config"])
    for episode in runner.sample(num_episodes=1, random_actions=True):
        boats = episode.agent_episodes.values()
        assert [(boat.is_terminated, boat.is_truncated) for boat in boats] == [(False, True)] * 4


class OneEachStep(asv_env.AsvVectorEnv):
    """Reward 1 each step, and never an end but the time limit of ten steps."""

    def __init__(self):
        super().__init__(8, "push", 2, autoreset_mode="SameStep", time_limit=1, goal=(1, 0, 0))

    def step(self, actions):
        observation, reward, *rest = super().step(actions)
        return observation, np.ones_like(reward), *rest


class WithoutTruncation(OneEachStep):
    """A wrong environment: it passes the time limit off as a termination."""

    def step(self, actions):
        observation, reward, terminated, truncated, infos = super().step(actions)
        return observation, reward, terminated | truncated, np.zeros_like(truncated), infos


def learned_value(envs):
    """Mean over an episode of the value that the single file learns with gamma 0.9."""
    torch.set_num_threads(1)
    definitions = {}
    exec(SINGLE_FILE.partition("\nenvs = ")[0], definitions)
    boat = definitions["train"](envs, updates=20, steps=20, gamma=0.9)
    idle = np.zeros(envs.action_space.shape)
    seen = [envs.reset()[0], *(envs.step(idle)[0] for _ in range(9))]
    with torch.no_grad():
        return boat(torch.from_numpy(np.stack(seen)))[1].mean().item()


def test_the_single_file_values_a_constant_reward_at_ten_whatever_the_time_limit():
    assert learned_value(OneEachStep()) == pytest.approx(10.0, abs=0.5)
    assert learned_value(WithoutTruncation()) < 5.5, "the probe notices a time limit that ends"
