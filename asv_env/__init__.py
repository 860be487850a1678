"""Small boats grasp a floating vessel and push it to a goal pose.

Importing this package registers its environments: ``asv_env/Approach-v0``, ``asv_env/Push-v0``
and ``asv_env/Transport-v0`` with Gymnasium, and ``asv_env/approach-v0`` ... with PettingZoo.
"""

from importlib import metadata as _metadata

import gymnasium as _gymnasium
import pettingzoo as _pettingzoo

from asv_env.envs.joint import JointEnv
from asv_env.envs.parallel import AsvParallelEnv, parallel_env
from asv_env.envs.vector import AsvVectorEnv
from asv_env.params import EnvParams
from asv_env.presets import DIFFICULTIES, HULLS, OBSTACLES, PRESETS, SCENARIOS, make_params
from asv_env.sensing.observation import FEATURES
from asv_env.simulation import Simulation
from asv_env.tasks import TASKS, Task
from asv_env.types import Sensed, State, TimeStep

__all__ = [
    "DIFFICULTIES", "FEATURES", "HULLS", "OBSTACLES", "PRESETS", "SCENARIOS", "TASKS",
    "AsvParallelEnv", "AsvVectorEnv", "EnvParams", "JointEnv", "Sensed", "Simulation", "State",
    "Task", "TimeStep", "__version__", "make_params", "parallel_env",
]  # fmt: skip

try:
    __version__ = _metadata.version("asv-env")
except _metadata.PackageNotFoundError:  # run from a checkout that was never installed
    __version__ = "0+unknown"


def __getattr__(name: str) -> object:
    """Imports on demand the adapters that need a library of their own."""
    if name == "BoatVecEnv":
        from asv_env.envs.sb3 import BoatVecEnv

        return BoatVecEnv
    if name == "TorchRLEnv":
        from asv_env.envs.torchrl import TorchRLEnv

        return TorchRLEnv
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def _register() -> None:
    """Enters every task into the registries that there are, once."""
    joint, vector = "asv_env.envs.joint:JointEnv", "asv_env.envs.vector:AsvVectorEnv"
    boats = "asv_env.envs.parallel:parallel_env"
    # PettingZoo has a registry from 1.27 on; some libraries need an older one.
    registered = getattr(_pettingzoo, "parallel_registry", None)
    for task in TASKS:
        name, given = f"asv_env/{task.capitalize()}-v0", {"task": task}
        if name not in _gymnasium.registry:
            _gymnasium.register(name, joint, vector_entry_point=vector, kwargs=given)
        name = f"asv_env/{task}-v0"
        if registered is not None and name not in registered:
            _pettingzoo.register("parallel", name, entry_point=boats, kwargs=given)


_register()
