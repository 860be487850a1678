"""BenchMARL's command with the tasks of this package: ``python -m asv_env.envs.benchmarl``."""

import sys
from typing import Any

import hydra
from benchmarl.hydra_config import load_experiment_from_hydra
from hydra.core.hydra_config import HydraConfig

from asv_env.envs.benchmarl import DeliveryLog, register


@hydra.main(version_base=None, config_path="pkg://benchmarl.conf", config_name="config")
def run(config: Any) -> None:
    """Runs the experiment that the command line describes in Hydra's way."""
    task = HydraConfig.get().runtime.choices.task
    load_experiment_from_hydra(config, task, callbacks=[DeliveryLog()]).run()


def main() -> None:
    """Makes the tasks known, and runs an experiment."""
    register()
    sys.argv.append("hydra.searchpath=[pkg://asv_env.envs.benchmarl.conf]")
    run()


if __name__ == "__main__":
    main()
