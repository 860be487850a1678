"""Recorded episodes that are imitated beside the scripted policy."""

from collections.abc import Iterator
from pathlib import Path

from asv_env.sensing import observation
from asv_env.types import Action, Observation
from baselines.rollout import trajectories
from train.config import Config

Pairs = tuple[Observation, Action]
"""Observations (n, K) and the actions (n, 2) that were taken on them."""


def demonstrations(config: Config) -> Iterator[Pairs]:
    """Yields observations and actions of each recorded episode."""
    for file in _files(config):
        trajectory, _ = trajectories.load(file)
        seen, actions = trajectory.observation[:-1], trajectory.action
        yield seen.reshape(-1, seen.shape[-1]), actions.reshape(-1, 2)


def check_demonstrations(config: Config) -> None:
    """Refuses recorded episodes that must not be, or cannot be, learned from.

    Raises:
        FileNotFoundError: there are none in the folder.
        ValueError: an episode that is not for training, of another task, kind of action or
            version of the observation, or a file that is no recorded episode.
    """
    files = _files(config)
    if config.imitation.demonstrations is not None and not files:
        raise FileNotFoundError(
            f"{config.imitation.demonstrations} holds no recorded episodes: make some with "
            "python -m baselines.evaluate --record"
        )
    for file in files:
        _check(file, config)


def _files(config: Config) -> list[Path]:
    folder = config.imitation.demonstrations
    return trajectories.files(folder) if folder else []


def _check(file: Path, config: Config) -> None:
    about = trajectories.about(file)
    episode = about["episode"]
    if about["purpose"] != "training":
        raise ValueError(
            f"{file}: seed {episode['seed']} is for {about['purpose'] or 'nothing'}, not for "
            "training: record episodes with --seed 1000000000 and up"
        )
    fields = {
        "task": (episode["task"], config.definition.name),
        "action mode": (about["action_mode"], "tracking"),
        "observation version": (about["observation_version"], observation.VERSION),
        "observation": (tuple(about["observation_names"]), config.columns),
    }
    for name, (given, wanted) in fields.items():
        if given != wanted:
            raise ValueError(f"{file}: its {name} is {given!r}, that of the training {wanted!r}")
