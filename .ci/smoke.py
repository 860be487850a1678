"""What an installed package has to do in any folder: ``python smoke.py [--extra eval]``.

It writes to the current folder. The extra has to be installed exactly where it is named.
"""

import argparse
import subprocess
import sys
from pathlib import Path

import gymnasium
import numpy as np
import pettingzoo

import asv_env
import baselines
import train
from baselines.policy import POLICIES

COMMANDS = {"asv-evaluate": "eval", "asv-reproduce": "eval", "asv-train": "train"}
"""Extra that each console script needs."""
REPORT = "report.html", "episodes.csv", "summary.json"


def ran(name: str, *words: str) -> subprocess.CompletedProcess[str]:
    """Runs a console script of this installation."""
    script = Path(sys.executable).with_name(name)
    return subprocess.run([script, *words], capture_output=True, text=True)


def check_place() -> None:
    """Packages are those of the installation, and not of a checkout."""
    for package in (asv_env, baselines, train):
        assert Path(str(package.__file__)).is_relative_to(sys.prefix), package.__file__
    assert asv_env.__version__[0].isdigit(), asv_env.__version__


def check_worlds() -> None:
    """Every task can be made by its names, and stepped."""
    for task in asv_env.TASKS:
        name = f"asv_env/{task.capitalize()}-v0"
        env = gymnasium.make(name)
        seen, _ = env.reset(seed=0)
        assert np.isfinite(seen).all()
        assert env.observation_space.contains(env.step(env.action_space.sample())[0])
        batch = gymnasium.make_vec(name, num_envs=2)
        assert batch.reset(seed=0)[0].shape == (2, *seen.shape)
        boats = [asv_env.parallel_env(task)]
        if hasattr(pettingzoo, "make"):  # from 1.27 on
            boats.append(pettingzoo.make("parallel", f"asv_env/{task}-v0"))
        assert all(len(env.reset(seed=0)[0]) == len(env.possible_agents) for env in boats)


def check_policies() -> None:
    """Every policy of the package decides, the learned ones by the weights that ship."""
    params = asv_env.make_params("transport")
    simulation = asv_env.Simulation(params)
    observation = simulation.reset(seeds=[0])
    for name in POLICIES:
        act = POLICIES.find(name)(params).act
        action, _ = act(simulation.sensed, observation, None, np.ones(1, dtype=bool))
        assert np.isfinite(action).all(), name


def check_commands(extra: str | None) -> None:
    """Console scripts do their work, or name in one line the extra that they need."""
    for name, needed in COMMANDS.items():
        if extra == needed:
            done = ran(name, "--help")
            assert done.returncode == 0, done.stderr
        else:
            done = ran(name, "--task", "push") if name != "asv-reproduce" else ran(name)
            assert f"pip install 'asv-env[{needed}]'" in done.stderr, done.stderr
            assert len(done.stderr.splitlines()) == 1, done.stderr


def check_report() -> None:
    """An evaluation with a worker process leaves its files, the page with its replays."""
    words = "--task approach --episodes 2 --policies scripted learned --workers 1 --out run"
    done = ran("asv-evaluate", *words.split())
    assert done.returncode == 0, done.stderr
    for file in REPORT:
        assert (Path("run") / file).stat().st_size > 100, file


def main() -> None:
    """Checks the installation of the Python that runs this."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--extra", choices=["eval"])
    extra = parser.parse_args().extra
    check_place()
    check_worlds()
    check_policies()
    check_commands(extra)
    if extra:
        check_report()


if __name__ == "__main__":
    main()
