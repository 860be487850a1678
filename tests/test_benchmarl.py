"""BenchMARL knows the tasks in each tier, and its algorithms train on them."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

if "ENGINES_MUST_RUN" not in os.environ:
    pytest.importorskip("benchmarl", reason="BenchMARL is not installed, see docs/engines.md")

import torch
from benchmarl.algorithms import MaddpgConfig, MappoConfig, QmixConfig
from benchmarl.environments import task_config_registry
from benchmarl.experiment import Experiment, ExperimentConfig
from benchmarl.models import MlpConfig

import asv_env
from asv_env.envs.benchmarl import CONF, AsvTask, register

PAGE = (Path(__file__).parents[1] / "docs/engines.md").read_text()
NAMES = [f"{task}_{tier}" for task in asv_env.TASKS for tier in asv_env.DIFFICULTIES]


@pytest.fixture(scope="module", autouse=True)
def _one_thread():
    torch.set_num_threads(1)


def test_every_task_in_every_tier_is_a_task():
    for _ in range(2):
        register()
    assert sorted(task.name.lower() for task in AsvTask) == sorted(NAMES)
    files = {path.stem for path in (CONF / "task" / "asv").iterdir()}
    assert files == set(NAMES)
    for name in NAMES:
        task = task_config_registry[f"asv/{name}"].get_from_yaml()
        env = task.get_env_fun(2, True, 10**8, "cpu")()
        assert f"{env.params.task.name}_{task.config['difficulty']}" == name
        expected = asv_env.make_params(*name.split("_")[:1], difficulty=name.split("_")[1])
        assert env.params == expected
        assert task.max_steps(env) == expected.time_limit_ticks


def test_the_configuration_are_options_of_the_environment():
    task = AsvTask.PUSH_EASY.get_task({"task": "push", "num_boats": 3, "goal": [0, -0.5, 0]})
    env = task.get_env_fun(2, False, 7, "cpu")()
    assert (env.params.num_boats, env.params.action_mode) == (3, "discrete")
    first = env.reset()
    same = asv_env.TorchRLEnv("push", 2, 3, seed=7, goal=(0, -0.5, 0)).reset()
    assert first["state"].equal(same["state"])
    with pytest.raises(ValueError, match=r"'puhs'.*'push'"):
        AsvTask.PUSH_EASY.get_task({"task": "puhs"}).get_env_fun(2, True, 0, "cpu")()


@pytest.mark.parametrize("algorithm", [MappoConfig, MaddpgConfig, QmixConfig])
@pytest.mark.filterwarnings("ignore")
def test_an_algorithm_trains(algorithm, tmp_path):
    """Two batches of 2 worlds and 8 steps, with evaluation; critics see the global state."""
    config = ExperimentConfig.get_from_yaml()
    for field, value in {
        **{"save_folder": str(tmp_path), "loggers": ["csv"], "create_json": False, "render": False},
        **{"max_n_frames": 32, "evaluation_interval": 16, "evaluation_episodes": 2},
        **{"on_policy_collected_frames_per_batch": 16, "on_policy_n_envs_per_worker": 2},
        **{"on_policy_minibatch_size": 8, "on_policy_n_minibatch_iters": 1},
        **{"off_policy_collected_frames_per_batch": 16, "off_policy_n_envs_per_worker": 2},
        **{"off_policy_n_optimizer_steps": 2, "off_policy_train_batch_size": 8},
    }.items():
        setattr(config, field, value)
    task = AsvTask.PUSH_EASY.get_from_yaml()
    task.config["max_episode_steps"] = 4
    small = MlpConfig(num_cells=[8], activation_class=torch.nn.Tanh, layer_class=torch.nn.Linear)
    experiment = Experiment(
        task, algorithm.get_from_yaml(), small, seed=10**8, config=config, critic_model_config=small
    )
    experiment.run()
    assert experiment.total_frames == 32
    (success,) = tmp_path.rglob("collection_asv_success.csv")
    assert [float(line.split(",")[1]) for line in success.read_text().split()] == [0.0, 0.0]


def test_the_program_of_the_page_makes_an_experiment(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (program,) = re.findall(r"```python\n(from asv_env.envs.benchmarl.*?)```", PAGE, re.DOTALL)
    made, _, run = program.partition("experiment.run()")
    assert run == "\n"
    names = {}
    exec(made, names)
    assert names["experiment"].task == AsvTask.PUSH_EASY.get_from_yaml()
    names["experiment"].close()


def test_the_command_of_the_page_runs(tmp_path):
    (line,) = re.findall(r"python (-m asv_env\.envs\.benchmarl (?:[^\n]*\\\n)*[^\n]*)", PAGE)
    shorter = {
        "max_n_frames": 512,
        "on_policy_collected_frames_per_batch": 512,
        "on_policy_minibatch_size": 256,
        "on_policy_n_minibatch_iters": 1,
        "evaluation_episodes": 1,
        "evaluation_interval": 512,
    }
    words = shlex.split(line.replace("\\\n", " "))
    assert "task.max_episode_steps=300" in words
    words[words.index("task.max_episode_steps=300")] = "task.max_episode_steps=20"
    words += [f"experiment.{name}={value}" for name, value in shorter.items()]
    subprocess.run([sys.executable, *words], cwd=tmp_path, check=True, capture_output=True)
    (shares,) = tmp_path.rglob("eval_asv_success.csv")
    assert 0.0 <= float(shares.read_text().split(",")[1]) <= 1.0
