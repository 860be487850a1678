"""``python -m asv_env``: installed versions, environments and names, or a picture of one."""

import os
import platform
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

import pettingzoo
import tyro

import asv_env
from asv_env import DIFFICULTIES, OBSTACLES, PRESETS, SCENARIOS, TASKS, files
from asv_env.checks import choice
from asv_env.params import ACTION_MODES
from asv_env.text import one_line

LIBRARIES = {
    "": ("asv-env", "numpy", "scipy", "gymnasium", "pettingzoo", "pymunk", "numba", "tyro"),
    "eval": (
        *("filelock", "joblib", "jinja2", "matplotlib", "pandas", "tqdm", "pygame-ce", "pillow"),
        *("imageio", "imageio-ffmpeg", "cloudpickle"),
    ),
    "train": ("stable-baselines3", "torch", "tensorboard", "rich"),
    "torchrl": ("torchrl",),
    "benchmarl": ("benchmarl",),
    "rllib": ("ray",),
    "bench": ("vmas",),
}  #: what is reported, by the extra that installs it
LONGEST = 1000  #: largest number of characters of a message
PICTURES = (".png",)  #: suffixes of pictures
USES = """
One agent for all boats   gymnasium.make("asv_env/Transport-v0", num_boats=4)
Many worlds at once       gymnasium.make_vec("asv_env/Transport-v0", num_envs=64)
Every boat an agent       asv_env.parallel_env("transport", num_boats=4)
stable-baselines3         asv_env.envs.sb3.BoatVecEnv("transport", num_envs=64)
A picture                 python -m asv_env --picture start.png"""


@dataclass(frozen=True)
class Options:
    """Prints installed versions, environments and names, or draws an initial state."""

    picture: Path | None = None  #: file (.png) to write a picture to, instead of printing
    overwrite: bool = False  #: whether to replace the picture if it exists
    task: str = "transport"  #: task of the picture
    num_boats: int | None = None  #: number of boats, 2 to 100; by default the preset's
    scenario: str = "nominal"  #: disturbances
    preset: str = "nominal"  #: world
    difficulty: str = "standard"  #: how hard the world is
    seed: int = 0  #: seed of the initial state


def main(arguments: Sequence[str] | None = None) -> None:
    """Prints the report, or writes a picture; exits with a message where that fails."""
    options = tyro.cli(Options, args=arguments, prog="python -m asv_env")
    if options.picture is None:
        print(report())
        return
    try:
        draw(options, Path(os.path.expanduser(options.picture)))
    except (ValueError, TypeError, ImportError, OSError) as error:
        sys.exit(f"python -m asv_env: {one_line(str(error), LONGEST)}")
    print(f"wrote {options.picture}")


def report() -> str:
    """Returns versions, environments, and the names that options take."""
    lines = [f"asv-env {asv_env.__version__}, Python {platform.python_version()}", "", "Installed"]
    for extra, names in LIBRARIES.items():
        missing = f"not installed: pip install 'asv-env[{extra}]'"
        lines += [f"  {name:18} {_version(name) or missing}" for name in names]
    lines += ["", "Environments                 Gymnasium                PettingZoo"]
    registered = hasattr(pettingzoo, "make")
    for task in TASKS:
        gym_id = f"asv_env/{task.capitalize()}-v0"
        zoo_id = f"asv_env/{task}-v0" if registered else "needs pettingzoo 1.27"
        lines += [f"  {task:26} {gym_id:24} {zoo_id}"]
    kinds = {
        "Difficulties": DIFFICULTIES,
        "Scenarios": SCENARIOS,
        "Obstacles": OBSTACLES,
        "Presets": PRESETS,
        "Action modes": ACTION_MODES,
    }
    lines += ["", *(f"{kind:13} {', '.join(known)}" for kind, known in kinds.items())]
    return "\n".join([*lines, USES])


def draw(options: Options, path: Path) -> None:
    """Writes a picture of an initial state.

    Raises:
        ValueError: an unknown kind of picture, or something is wrong with the options.
        FileExistsError: that would replace a file.
        OSError: the file cannot be written.
    """
    choice("kind of picture", path.suffix.lower(), PICTURES)
    if os.path.exists(path) and not options.overwrite:
        raise FileExistsError(f"{path} exists; choose another name or add --overwrite")
    import imageio.v3 as imageio  # an extra

    world = options.task, options.num_boats, options.scenario
    named: dict[str, Any] = {"preset": options.preset, "difficulty": options.difficulty}
    env = asv_env.JointEnv(*world, render_mode="rgb_array", **named)
    env.reset(seed=options.seed)
    picture = env.render()
    env.close()
    files.write(path, lambda part: imageio.imwrite(part, picture))


def _version(name: str) -> str:
    """Returns the installed version of a distribution, empty if there is none."""
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return ""


if __name__ == "__main__":
    main()
