"""Options of ``python -m train``: presets, and what is refused before anything is made."""

import json
import re
import shutil
import sys
from dataclasses import replace

import pytest
import torch
from train_helpers import layers_of, refusal, same, tiny

from asv_env.sensing import observation
from baselines.learned import policy_file
from train import actors
from train.config import PRESETS, SEEDS_PER_RUN, Config, parse
from train.launch import open_run
from train.run import by_name
from train.sb3 import policies
from train.sb3.ppo import Learner
from train.sb3.vec_env import TrainingVecEnv


@pytest.mark.parametrize("task", ["approach", "push", "transport"])
def test_each_task_has_a_preset(task):
    assert parse(["--task", task]).task == task
    assert parse([f"--task={task}", "--gamma", "0.5"]) == PRESETS[task].changed(ppo={"gamma": 0.5})


def test_seeds_of_runs_do_not_meet():
    assert Config(seed=1).first_seed - Config(seed=0).first_seed == SEEDS_PER_RUN


def test_options_go_into_json_by_section():
    options = json.loads(json.dumps(by_name(tiny().learned())))
    assert options["worlds.teams"] == [4]
    assert options["ppo.gamma"] == 0.996
    assert not [name for name in options if name.startswith(("out", "compute", "tracking"))]


# ------------------------------------------------------------------ a folder of another run


def test_changed_options_are_refused(trained):
    message = refusal("--out", trained, "--gamma", 0.9)
    assert "ppo.gamma was 0.996 and is 0.9" in message
    assert "SHORT' and is 'approach'" in refusal("--out", trained, "--task", "approach")


def test_an_option_that_a_run_does_not_know_had_its_default(trained, tmp_path):
    folder = tmp_path / "run"
    shutil.copytree(trained, folder)
    file = folder / "config.json"
    config = json.loads(file.read_text())
    del config["options"]["curriculum"]["near_starts"]
    file.write_text(json.dumps(config))
    open_run(tiny(out=folder))
    with pytest.raises(ValueError, match=re.escape("near_starts was 0.0 and is 0.5")):
        open_run(tiny(out=folder, curriculum={"near_starts": 0.5}))


def test_another_version_of_the_observation_is_refused(trained, monkeypatch):
    monkeypatch.setattr(observation, "VERSION", observation.VERSION + 1)
    assert f"trained on version {observation.VERSION - 1}" in refusal("--out", trained)


def test_a_folder_of_something_else_is_refused(tmp_path):
    (tmp_path / "thesis.tex").write_text("precious")
    assert "something else" in refusal("--out", tmp_path)


@pytest.mark.parametrize("text", ["precious", '{"options": 1}', "[1]"])
def test_overwriting_leaves_what_is_no_run(text, tmp_path):
    (tmp_path / "config.json").write_text(text)
    assert "something else" in refusal("--out", tmp_path, "--overwrite")
    assert (tmp_path / "config.json").read_text() == text


# ------------------------------------------------------------------ options that make no sense


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--task", "pusch"], "Did you mean 'push'"),
        (["--evaluation.seed", "5"], "seed 5 is not for development"),
        (["--teams", "4", "101"], "101"),
        (["--scenarios", "noise"], "Did you mean 'noisy'"),
        (["--decision-rate", "4"], "must divide the control rate 10"),
        (["--num-envs", "1", "--teams", "4", "6"], "needs at least one world"),
        (["--critic", "central", "--teams", "4", "6"], "train one team size"),
        (["--gamma", "1.5"], "gamma = 1.5"),
        (["--num-envs", "1000000000"], "num_envs = 1000000000"),
        (["--num-minibatches", "100000"], "an update has 512 decisions"),
        (["--hidden", "10000000000"], "hidden = (10000000000,)"),
        (["--torch-threads", "100000"], "torch_threads = 100000"),
        (["--total-timesteps", "1000000000000000000000"], "total_timesteps = 1000"),
        (["--learning-rate", "1e30"], "learning_rate = 1e+30"),
        (["--learning-rate", "nan"], "learning_rate = nan"),
        (["--update-epochs", "100000000000"], "update_epochs = 1000"),
        (["--init-from", ".", "--imitation.rounds", "0"], "'.'"),
        (["--residual", "0.2"], "set decision_rate = 10"),
        (["--total-timesteps", "0"], "total_timesteps = 0"),
        (["--adapt-kl", "-1"], "adapt_kl = -1"),
        (["--target-kl", "0"], "target_kl = 0"),
        (["--time-limit", "-5"], "time_limit = -5"),
        (["--hidden", "16", "0"], "hidden = (16, 0)"),
        (["--init-from", "some.npz"], "imitation would undo what the file has learned"),
        (["--init-from", "nowhere.npz", "--imitation.rounds", "0"], "nowhere.npz"),
        (["--imitation.demonstrations", "nowhere"], "no recorded episodes"),
    ],
)
def test_what_makes_no_sense_is_refused_before_anything_is_made(options, message, tmp_path):
    assert message in refusal("--out", tmp_path / "run", *options)
    assert not (tmp_path / "run").exists()


def test_a_missing_extra_is_named(monkeypatch):
    for name in ("train.sb3.training", "train.sb3.ppo", "train.sb3.policies"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    monkeypatch.setitem(sys.modules, "stable_baselines3", None)
    assert "pip install 'asv-env[train]'" in refusal()


def test_a_missing_tracker_is_named(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "wandb", None)
    assert "pip install wandb" in refusal("--track", "--out", tmp_path / "run")
    assert not (tmp_path / "run").exists()


# ------------------------------------------------------------------ initial policies


def refused_init(file, *options):
    """The message with which a training is refused that would begin with a file."""
    folder = file.parent / "refused"
    refused = refusal("--out", folder, "--init-from", file, "--imitation.rounds", 0, *options)
    assert not folder.exists()
    return refused


@pytest.mark.parametrize(
    ("other", "message"),
    [
        ({"activation": "tanh"}, "its activation is 'tanh', that of the training 'relu'"),
        ({"residual": 0.5}, "its residual is 0.5, that of the training 0.0"),
        ({"action_repeat": 5}, "its decision_rate is 2, that of the training 5"),
        ({"observation_version": 0}, "observes by version 0"),
    ],
)
def test_an_initial_policy_of_another_kind_is_refused(other, message, trained, tmp_path):
    layers, metadata, card = policy_file.read(trained / "best.npz")
    policy_file.save(tmp_path / "other.npz", layers, replace(metadata, **other), card)
    assert message in refused_init(tmp_path / "other.npz")


def test_an_initial_policy_of_other_layers_is_refused(trained, learned_file, tmp_path):
    shutil.copy(trained / "best.npz", tmp_path / "wide.npz")
    sizes = f"[{len(observation.NAMES)}, 16, 16, 2]"
    assert f"wide.npz: layers of sizes {sizes} do not fit" in refused_init(
        tmp_path / "wide.npz", "--hidden", 8, 16
    )
    assert "learned.npz is not a policy file of the format" in refused_init(learned_file)


def actor(*hidden):
    config = tiny(network={"hidden": hidden})
    return policies.actor(Learner.create(config, TrainingVecEnv(config)).policy)


def test_an_actor_takes_the_layers_of_a_file(trained):
    layers = layers_of(trained / "best.npz")
    equal = actor(16, 16)
    actors.set_layers(equal, layers)
    assert same(actors.get_layers(equal), layers)
    with pytest.raises(ValueError, match="--hidden"):
        actors.set_layers(equal, layers[1:])


def test_a_wider_actor_begins_by_acting_as_the_file(trained):
    layers = layers_of(trained / "best.npz")
    wider, equal = actor(24, 40), actor(16, 16)
    actors.set_layers(wider, layers)
    actors.set_layers(equal, layers)
    seen = torch.randn(50, len(observation.NAMES), generator=torch.Generator().manual_seed(1))
    torch.testing.assert_close(wider(seen), equal(seen))
    wider(seen).sum().backward()
    *hidden, last = actors.linear_layers(wider)
    assert [layer.out_features for layer in (*hidden, last)] == [24, 40, 2]
    assert (last.weight.grad[:, 16:] != 0).any()  # what is new can learn
    with pytest.raises(ValueError, match="or wider"):
        actors.set_layers(actor(16, 8), layers)
