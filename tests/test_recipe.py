"""The recipe of the learned policies: ``python -m train.recipe``."""

import json
from dataclasses import replace

import pytest
from train_helpers import same

from asv_env import make_params
from asv_env.tasks import APPROACH as APPROACH_TASK
from baselines.evaluate.publish import model_cards
from baselines.learned import policy_file
from baselines.rollout import seeds
from train import recipe
from train.config import PRESETS
from train.recipe import APPROACH, Training
from train.sb3 import export

ORIGINAL, ORIGINAL_PAIRS = recipe.TRAININGS, recipe.PAIRS
"""The recipe of the package, which the other tests replace by a tiny one."""
PUSH = "second"
SHORT_APPROACH = replace(APPROACH_TASK, time_limit=8.0)
TINY = {
    "worlds": {"num_envs": 4, "time_limit": 5.0, "scenarios": ("noisy",)},
    "imitation": {"rounds": 0},
    "ppo": {
        "num_steps": 16, "num_minibatches": 2, "update_epochs": 1, "critic_updates": 0,
        "total_timesteps": 256,
    },
    "network": {"hidden": (16,)},
    "evaluation": {"every": 256, "episodes": 1},
    "checkpoint_every": 256,
}  # fmt: skip


@pytest.fixture(scope="module", autouse=True)
def tiny_recipe():
    """A recipe that is over in seconds."""
    approach = PRESETS["approach"].changed(**TINY, task="test_recipe:SHORT_APPROACH")
    push = PRESETS["push"].changed(**TINY, task="train_helpers:SHORT")
    push = push.changed(worlds={"mirror": True})
    trainings = {
        APPROACH: Training(approach),
        "first": Training(push),
        PUSH: Training(push.changed(network={"hidden": (24,)}), after="first"),
    }
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(export, "SECONDS", 2.0)
        patch.setattr(recipe, "TRAININGS", trainings)
        patch.setattr(recipe, "PAIRS", ((APPROACH, PUSH, None), (APPROACH, "first", 4)))
        yield


@pytest.fixture(scope="module")
def followed(tmp_path_factory):
    """Folder of the recipe, with seed 2."""
    out = tmp_path_factory.mktemp("recipe") / "r"
    recipe.main(["--out", str(out), "--torch-threads", "1", "--seed", "2"])
    return out


def test_the_recipe_leaves_policy_files(followed):
    made, card = policy_file.read(followed / "transport.npz")
    assert [phase.team_size for phase in made] == [None, None, 4, 4]
    for phase, name in zip(made, (APPROACH, PUSH, APPROACH, "first"), strict=True):
        own, own_card = policy_file.read_single(followed / name / "best.npz")
        assert same(phase.layers, own.layers)
        assert phase.metadata == own.metadata
        assert own_card in card["phases"]
        assert own_card["training_seeds"][0] == seeds.TRAINING.start + 2_000_000
    began = [one["options"]["init_from"] for one in model_cards.trainings(card["phases"][1])]
    assert began == [None, "best.npz"]
    (own,) = policy_file.read(followed / "approach.npz")[0]
    assert own.metadata.tasks == ("approach",)
    assert policy_file.load(followed / "transport.npz", make_params("push"))


def test_the_recipe_is_resumed_where_it_was_stopped(followed):
    stamps = {file: file.stat().st_mtime_ns for file in followed.glob("*/checkpoint.zip")}
    (followed / PUSH / "checkpoint.zip").unlink()
    recipe.follow(2, followed, 1)
    changed = {
        file.parent.name for file, stamp in stamps.items() if file.stat().st_mtime_ns > stamp
    }
    assert changed == {PUSH}


def test_a_folder_of_another_recipe_is_refused(followed):
    with pytest.raises(SystemExit, match=r"other options \(seed was 2 and is 1\)"):
        recipe.main(["--out", str(followed), "--seed", "1", "--torch-threads", "1"])


def test_each_training_of_the_recipe_follows_those_it_needs():
    assert json.dumps({name: step.config.learned() for name, step in ORIGINAL.items()})
    names = list(ORIGINAL)
    for name, step in ORIGINAL.items():
        for needed in {step.after, step.approach} - {None}:
            assert names.index(needed) < names.index(name)
    joined = {name for approach, push, _ in ORIGINAL_PAIRS for name in (approach, push)}
    assert {APPROACH, *joined} <= set(names)
