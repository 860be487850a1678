"""``python -m asv_env``: what is installed, what there is to make, and a picture of one."""

from __future__ import annotations

import argparse
import platform
from collections.abc import Sequence
from importlib import metadata
from pathlib import Path

import asv_env
from asv_env import PRESETS, SCENARIOS, TASKS
from asv_env.params import ACTION_MODES

NEEDED = ("asv-env", "numpy", "scipy", "gymnasium", "pettingzoo", "pymunk")
EXTRAS = {
    "eval": ("matplotlib", "tqdm", "pygame-ce", "imageio"),
    "train": ("stable-baselines3", "torch", "tensorboard"),
    "rllib": ("ray",),
}


def main(arguments: Sequence[str] | None = None) -> None:
    """Prints the report, and writes a picture if one is asked for."""
    parser = _parser()
    options = parser.parse_args(arguments)
    if options.picture is None:
        print(report())
        return
    try:
        _picture(options)
    except (ValueError, TypeError, ImportError, OSError) as error:
        parser.error(str(error))
    print(f"wrote {options.picture}")


def report() -> str:
    """Versions, environments, and the names that options take."""
    lines = [f"asv-env {asv_env.__version__}, Python {platform.python_version()}", ""]
    lines += ["Installed"]
    lines += [f"  {name:18} {_version(name)}" for name in NEEDED]
    for extra, names in EXTRAS.items():
        missing = f"not installed: pip install 'asv-env[{extra}]'"
        lines += [f"  {name:18} {_version(name) or missing}" for name in names]
    lines += ["", "Environments                 Gymnasium                PettingZoo"]
    for task in TASKS:
        gym_id, zoo_id = f"asv_env/{task.capitalize()}-v0", f"asv_env/{task}-v0"
        lines += [f"  {task:26} {gym_id:24} {zoo_id}"]
    lines += [
        "",
        f"Scenarios     {', '.join(SCENARIOS)}",
        f"Presets       {', '.join(PRESETS)}",
        f"Action modes  {', '.join(ACTION_MODES)}",
        "",
        'One agent for all boats   gymnasium.make("asv_env/Transport-v0", num_boats=4)',
        'Many worlds at once       gymnasium.make_vec("asv_env/Transport-v0", num_envs=64)',
        'Every boat an agent       asv_env.parallel_env("transport", num_boats=4)',
        'stable-baselines3         asv_env.envs.sb3.BoatVecEnv("transport", num_envs=64)',
        "A picture                 python -m asv_env --picture start.png",
    ]
    return "\n".join(lines)


def _version(name: str) -> str:
    """Installed version of a distribution, empty if there is none."""
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return ""


def _picture(options: argparse.Namespace) -> None:
    """Writes a picture of the first instant of an episode."""
    path = Path(options.picture)
    if path.exists() and not options.overwrite:
        raise FileExistsError(f"{path} exists; choose another name or add --overwrite")
    import imageio.v3 as imageio  # an extra

    env = asv_env.JointEnv(
        options.task,
        options.num_boats,
        options.scenario,
        render_mode="rgb_array",
        preset=options.preset,
    )
    env.reset(seed=options.seed)
    imageio.imwrite(path, env.render())
    env.close()


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m asv_env", description=__doc__)
    parser.add_argument("--picture", metavar="FILE", help="write a picture instead (.png)")
    parser.add_argument("--overwrite", action="store_true", help="replace FILE if it exists")
    parser.add_argument("--task", default="transport", help=f"of {', '.join(TASKS)}")
    parser.add_argument("--num-boats", type=int, help="2 to 100")
    parser.add_argument("--scenario", default="nominal", help=f"of {', '.join(SCENARIOS)}")
    parser.add_argument("--preset", default="nominal", help=f"of {', '.join(PRESETS)}")
    parser.add_argument("--seed", type=int, default=0, help="of the episode")
    return parser


if __name__ == "__main__":
    main()
