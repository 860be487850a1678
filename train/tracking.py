"""Reports to Weights & Biases."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from train.config import Config


@contextmanager
def tracked(config: Config, folder: Path, name: str | None) -> Iterator[None]:
    """Sends what goes to TensorBoard to Weights & Biases too, while the block runs.

    Args:
        config: of the run.
        folder: of the run.
        name: by which a resumed run is recognised.
    """
    if not config.tracking.track:
        yield
        return
    import wandb

    run = wandb.init(
        project=config.tracking.wandb_project_name,
        entity=config.tracking.wandb_entity,
        name=folder.name,
        id=name,
        resume="allow",
        config=config.learned(),
        sync_tensorboard=True,
        dir=str(folder),
    )
    try:
        yield
    finally:
        run.finish()


def check(config: Config) -> None:
    """Refuses to track where Weights & Biases is not installed.

    Raises:
        ImportError: it is not installed.
    """
    if config.tracking.track:
        try:
            import wandb  # noqa: F401
        except ImportError as error:
            raise ImportError("--track needs Weights & Biases: pip install wandb") from error
