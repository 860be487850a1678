"""Checks of all that a training needs, before its folder is made, and its report while it runs."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

from asv_env.sensing import observation
from baselines.learned import policy_file
from baselines.learned.network import Layers, NetworkPolicy
from baselines.rollout import trajectories
from train import actors
from train.config import CONTROL_RATE, Config
from train.run import Run


def open_run(config: Config) -> tuple[Run, Layers | None]:
    """Checks the options of a training and opens the folder of its run.

    Returns:
        The run, and the layers with which learning begins where ``init_from`` gives any.

    Raises:
        ValueError, OSError, ImportError: something is wrong, such as a file of a policy or of
            recorded episodes that does not fit the options; then nothing was made.
    """
    layers, model_card = _initial_policy(config)
    _check_demonstrations(config)
    if config.tracking.track:
        try:
            import wandb  # noqa: F401
        except ImportError as error:
            raise ImportError("--track needs Weights & Biases: pip install wandb") from error
    run = Run(config)
    run.open(model_card)
    return run, layers


def _initial_policy(config: Config) -> tuple[Layers, dict[str, Any]] | tuple[None, None]:
    """Returns layers and model card of the policy file with which learning begins, if any."""
    if config.init_from is None:
        return None, None
    layers, metadata, model_card = policy_file.read(config.init_from)
    with _naming(f"--init-from {config.init_from}"):
        as_here = replace(metadata, tasks=(config.definition.name,))
        NetworkPolicy(layers, as_here, config.params())
        actors.check_sizes(layers, (len(config.columns), *config.network.hidden, 2))
        options = {
            "activation": (metadata.activation, config.network.activation),
            "observation": (metadata.observation, config.observed),
            "residual": (metadata.residual, config.network.residual),
            "decision_rate": (CONTROL_RATE // metadata.action_repeat, config.worlds.decision_rate),
        }
        _check_equal(options)
    return layers, model_card


def _check_equal(options: dict[str, tuple[Any, Any]]) -> None:
    """Refuses options (of a file, wanted by the training) that differ."""
    for name, (given, wanted) in options.items():
        if given != wanted:
            raise ValueError(f"its {name} is {given!r}, that of the training {wanted!r}")


def _check_demonstrations(config: Config) -> None:
    """Refuses recorded episodes that must not be, or cannot be, learned from."""
    folder = config.imitation.demonstrations
    if folder is None:
        return
    files = trajectories.files(folder)
    if not files:
        raise FileNotFoundError(
            f"{folder} holds no recorded episodes: make some with python -m baselines.evaluate "
            "--record"
        )
    for file in files:
        about = trajectories.about(file)
        episode = about["episode"]
        if about["purpose"] != "training":
            raise ValueError(
                f"{file}: seed {episode['seed']} is for {about['purpose'] or 'nothing'}, not for "
                "training: record episodes with --seed 1000000000 and up"
            )
        options = {
            "task": (episode["task"], config.definition.name),
            "action mode": (about["action_mode"], "tracking"),
            "observation version": (about["observation_version"], observation.VERSION),
            "observation": (tuple(about["observation_names"]), config.columns),
        }
        with _naming(file):
            _check_equal(options)


@contextmanager
def _naming(file: object) -> Iterator[None]:
    """Begins the message of a ValueError with the file that causes it."""
    try:
        yield
    except ValueError as error:
        raise ValueError(f"{file}: {error}") from error


@contextmanager
def tracked(run: Run) -> Iterator[None]:
    """Sends what goes to TensorBoard to Weights & Biases too, where that is asked for."""
    options = run.config.tracking
    if not options.track:
        yield
        return
    import wandb

    with wandb.init(
        project=options.wandb_project_name,
        entity=options.wandb_entity,
        name=run.folder.name,
        id=run.recorded("id"),
        resume="allow",
        config=run.config.learned(),
        sync_tensorboard=True,
        dir=str(run.folder),
    ):
        yield
