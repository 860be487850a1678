"""Reports to an experiment tracker, where that is asked for."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from train.config import Config


@contextmanager
def tracked(config: Config, folder: Path) -> Iterator[None]:
    """Sends what goes to TensorBoard to Weights & Biases too, while the block runs.

    Raises:
        ImportError: wandb is not installed.
    """
    if not config.track:
        yield
        return
    wandb = tracker()
    run = wandb.init(
        project=config.wandb_project_name,
        entity=config.wandb_entity,
        name=folder.name,
        config=config.learned(),
        sync_tensorboard=True,
        dir=str(folder),
    )
    try:
        yield
    finally:
        run.finish()


def tracker() -> Any:
    """The module.

    Raises:
        ImportError: it is not installed.
    """
    try:
        import wandb
    except ImportError as error:
        raise ImportError("--track needs Weights & Biases: pip install wandb") from error
    return wandb
