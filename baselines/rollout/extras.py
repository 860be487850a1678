"""Extras of the package: which of them installs a library whose import has failed."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

EXTRAS = {
    "eval": (
        *("PIL", "cloudpickle", "filelock", "imageio", "imageio_ffmpeg", "jinja2", "joblib"),
        *("matplotlib", "pandas", "pygame", "tqdm"),
    ),
    "train": ("rich", "stable_baselines3", "tensorboard", "torch"),
    "torchrl": ("tensordict", "torchrl"),
    "rllib": ("ray",),
}  #: names of modules, by the extra that installs them


def remedy(error: ImportError) -> str:
    """Returns what installs the library that an import has missed, "" if no extra does."""
    library = (error.name or "").partition(".")[0]
    extras = (extra for extra, names in EXTRAS.items() if library in names)
    return "".join(f"pip install 'asv-env[{extra}]'" for extra in extras)


@contextmanager
def needed(program: str) -> Iterator[None]:
    """Exits with a line where a block imports a library of an extra that is not installed."""
    try:
        yield
    except ImportError as error:
        if not remedy(error):
            raise
        sys.exit(f"{program}: {error}: this needs an extra, {remedy(error)}")
