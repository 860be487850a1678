"""BenchMARL's command with the tasks of this package: ``python -m asv_env.envs.benchmarl``."""

import sys

from benchmarl.run import hydra_experiment

from asv_env.envs.benchmarl import register


def main() -> None:
    """Runs an experiment that the command line describes in Hydra's way."""
    register()
    sys.argv.append("hydra.searchpath=[pkg://asv_env.envs.benchmarl.conf]")
    hydra_experiment()


if __name__ == "__main__":
    main()
