"""Checks of all that a training needs, before its folder is made, and its report while it runs."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

from asv_env.presets import make_params
from baselines.learned import policy_file
from baselines.learned.network import Layers, Metadata, NetworkPolicy
from baselines.learned.phases import PhasedPolicy
from train import actors
from train.config import CONTROL_RATE, Config
from train.imitation import check_demonstrations
from train.run import Run


def open_run(config: Config) -> tuple[Run, Layers | None]:
    """Checks the options of a training and opens the folder of its run.

    Returns:
        The run, and the layers with which learning begins where ``init_from`` gives any.

    Raises:
        ValueError, OSError, ImportError: something is wrong; then nothing was made.
    """
    layers, model_card = _initial_policy(config)
    check_demonstrations(config)
    _check_rollout_policy(config)
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
    phase, model_card = policy_file.read_single(config.init_from)
    layers, metadata = phase.layers, phase.metadata
    try:
        as_here = replace(metadata, tasks=(config.definition.name,))
        NetworkPolicy(layers, as_here, config.params())
        actors.check_sizes(layers, (len(config.columns), *config.network.hidden, 2))
        _check_options(metadata, config)
    except ValueError as error:
        raise ValueError(f"--init-from {config.init_from}: {error}") from error
    return layers, model_card


def _check_options(metadata: Metadata, config: Config) -> None:
    """Refuses a policy that acts otherwise than the training."""
    options = {
        "activation": (metadata.activation, config.network.activation),
        "observation": (metadata.observation, config.observed),
        "mirror": (metadata.mirrors, config.worlds.mirror),
        "residual": (metadata.residual, config.network.residual),
        "decision_rate": (CONTROL_RATE // metadata.action_repeat, config.worlds.decision_rate),
    }
    for option, (given, asked) in options.items():
        if given != asked:
            raise ValueError(
                f"its {option} is {given!r}, that of the training {asked!r}; train with that of "
                "the file"
            )


def _check_rollout_policy(config: Config) -> None:
    """Refuses a policy file that cannot be rolled out with every team."""
    file = config.curriculum.rollout_policy
    if file is None:
        return
    phases, _ = policy_file.read(file)
    try:
        for team in config.worlds.teams:
            PhasedPolicy(phases, make_params("transport", team))
    except ValueError as error:
        raise ValueError(f"--curriculum.rollout-policy {file}: {error}") from error


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
