"""Adapter: the tasks in each tier as tasks of BenchMARL, one for every pair.

``register()`` enters them into BenchMARL's registry as ``asv/push_easy`` and so on. The command
``python -m asv_env.envs.benchmarl`` is BenchMARL's own with these tasks and their configuration.
"""

import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

from asv_env.envs.torchrl import GROUP, TorchRLEnv

try:
    import benchmarl.environments as environments
    from benchmarl.environments.common import Task, TaskClass
    from benchmarl.experiment import Callback
    from benchmarl.utils import _read_yaml_config
    from torchrl.data import Composite
except ImportError as error:
    raise ImportError(
        "asv_env.envs.benchmarl needs BenchMARL: pip install 'asv-env[benchmarl]'"
    ) from error

CONF = Path(__file__).parent / "conf"  #: configuration, in the format of BenchMARL's


class AsvClass(TaskClass):
    """A task of BenchMARL whose configuration are options of ``TorchRLEnv``.

    Discrete learners get ``action_mode="discrete"``. The critics of algorithms that have central
    ones see the global state.
    """

    def get_env_fun(
        self, num_envs: int, continuous_actions: bool, seed: int | None, device: Any
    ) -> Callable[[], TorchRLEnv]:
        """Returns a function that makes the environment."""
        options = copy.deepcopy(self.config)
        if not continuous_actions:
            options["action_mode"] = "discrete"
        return lambda: TorchRLEnv(num_envs=num_envs, seed=seed, device=device, **options)

    def supports_continuous_actions(self) -> bool:
        """Returns True."""
        return True

    def supports_discrete_actions(self) -> bool:
        """Returns True."""
        return True

    def max_steps(self, env: Any) -> int:
        """Returns the number of steps after which an episode is truncated."""
        return env.params.time_limit_ticks

    def has_render(self, env: Any) -> bool:
        """Returns whether the configuration asks for pictures, ``render_mode="rgb_array"``."""
        return env.render_mode == "rgb_array"

    def group_map(self, env: Any) -> dict[str, list[str]]:
        """Returns the names of the boats, which are one group."""
        return env.group_map

    def observation_spec(self, env: Any) -> Any:
        """Returns the description of what the boats see."""
        return _of_boats(env, "observation")

    def info_spec(self, env: Any) -> Any:
        """Returns the description of the infos, None where there are none."""
        return _of_boats(env, "info")

    def state_spec(self, env: Any) -> Any:
        """Returns the description of the global state, None where it is not observed."""
        found = env.full_observation_spec_unbatched.get("state", None)
        return None if found is None else Composite({"state": found})

    def action_spec(self, env: Any) -> Any:
        """Returns the description of the actions."""
        return env.full_action_spec_unbatched

    def action_mask_spec(self, env: Any) -> None:
        """Returns None: every action is always allowed."""
        return

    @staticmethod
    def env_name() -> str:
        """Returns what stands before the names of the tasks."""
        return "asv"

    @staticmethod
    def log_info(batch: Any) -> dict[str, float]:
        """Returns the share of deliveries among the episodes that end in a batch."""
        share = _delivered([batch])
        return {} if share is None else {f"collection/{GROUP}/success": share}


class DeliveryLog(Callback):
    """Logs the share of deliveries in evaluations, which BenchMARL's own log leaves out."""

    def on_evaluation_end(self, rollouts: list[Any]) -> None:
        """Logs the share among the first episodes of the rollouts, one for each world."""
        lengths = [
            1 + int(rollout["next", "done"].flatten().int().argmax()) for rollout in rollouts
        ]
        share = _delivered([one[:steps] for one, steps in zip(rollouts, lengths, strict=True)])
        if share is not None:
            name, step = f"eval/{GROUP}/success", self.experiment.n_iters_performed
            self.experiment.logger.log({name: share}, step=step)


def _delivered(batches: list[Any]) -> float | None:
    """Returns the share of deliveries among the episodes that end, None where that is unknown."""
    found = []
    for batch in batches:
        success = batch.get(("next", GROUP, "info", "is_success"), None)
        if success is not None:
            found += success[batch["next", GROUP, "done"][..., 0]].tolist()
    return sum(found) / len(found) if found else None


def _of_boats(env: Any, name: str) -> Any:
    """Returns the description of an observation of every boat, None where there is none."""
    spec = env.full_observation_spec_unbatched[GROUP]
    found = spec.get(name, None)
    if found is None:
        return None
    return Composite({GROUP: Composite({name: found}, shape=spec.shape)})


class AsvTask(Task):
    """The tasks in each tier; their configuration is in ``conf/task/asv``."""

    APPROACH_EASY = None
    APPROACH_STANDARD = None
    APPROACH_HARD = None
    PUSH_EASY = None
    PUSH_STANDARD = None
    PUSH_HARD = None
    TRANSPORT_EASY = None
    TRANSPORT_STANDARD = None
    TRANSPORT_HARD = None

    @staticmethod
    def associated_class() -> type[AsvClass]:
        """Returns the class of the tasks."""
        return AsvClass

    def get_from_yaml(self, path: str | None = None) -> TaskClass:
        """Returns the task with the configuration of a file, by default that of this package."""
        own = CONF / "task" / AsvClass.env_name() / f"{self.name.lower()}.yaml"
        return self.get_task(config=_read_yaml_config(str(path or own)))


def register() -> None:
    """Enters the tasks into BenchMARL's registry, once."""
    if AsvTask not in environments.tasks:
        environments.tasks.append(AsvTask)
    known: Any = AsvTask
    names = {f"{AsvClass.env_name()}/{task.name.lower()}": task for task in known}
    environments.task_config_registry.update(names)
