"""All options of a training, the presets of the tasks, and the command line that sets them."""

import json
import re
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import tyro
from tyro.conf import OmitArgPrefixes

from asv_env.checks import check_whole
from asv_env.params import EnvParams
from asv_env.presets import make_params
from asv_env.sensing import observation
from asv_env.tasks import TASKS, Task
from baselines.rollout import seeds
from baselines.rollout.commands import FilePath
from train.sections import (
    CONTROL_RATE,
    MOST_STEPS,
    ComputeOptions,
    CurriculumOptions,
    EvaluationOptions,
    ImitationOptions,
    NetworkOptions,
    PPOOptions,
    TrackingOptions,
    WorldOptions,
)

SEEDS_PER_RUN = 10**6  #: number of training seeds that each run has for itself
NOT_LEARNED = ("out", "overwrite", "tracking", "compute")  #: they change rounding at most


@dataclass(frozen=True)
class Config:
    """Train a policy that all boats share; the same command resumes a run that was stopped."""

    task: str = "push"  #: name of the task, or "module:NAME"
    engine: Literal["sb3", "rllib"] = "sb3"  #: stable-baselines3, or Ray RLlib, also on a cluster
    seed: int = 0  #: seed of the run, from 0; the seeds of its worlds follow from it
    out: FilePath | None = None  #: folder of the run; by default runs/train/TASK-ENGINE-SEED
    overwrite: bool = False  #: start again where the folder holds a run
    init_from: FilePath | None = None  #: policy file (.npz) with whose weights the actor begins
    checkpoint_every: int = 1_000_000  #: timesteps between checkpoints

    worlds: Annotated[WorldOptions, OmitArgPrefixes] = field(default_factory=WorldOptions)
    curriculum: CurriculumOptions = field(default_factory=CurriculumOptions)
    imitation: ImitationOptions = field(default_factory=ImitationOptions)
    ppo: Annotated[PPOOptions, OmitArgPrefixes] = field(default_factory=PPOOptions)
    network: Annotated[NetworkOptions, OmitArgPrefixes] = field(default_factory=NetworkOptions)
    evaluation: EvaluationOptions = field(default_factory=EvaluationOptions)
    tracking: Annotated[TrackingOptions, OmitArgPrefixes] = field(default_factory=TrackingOptions)
    compute: Annotated[ComputeOptions, OmitArgPrefixes] = field(default_factory=ComputeOptions)

    def __post_init__(self) -> None:
        TASKS.find(self.task)
        check_whole(self, "seed", 0)
        check_whole(self, "checkpoint_every", 1, MOST_STEPS)
        seeds.check(range(self.first_seed, self.first_seed + SEEDS_PER_RUN), "training")
        rounds, residual = self.imitation.rounds, self.network.residual
        if self.init_from is not None and rounds:
            raise ValueError(
                f"init_from = {self.init_from} with imitation.rounds = {rounds}: imitation would "
                "undo what the file has learned; set imitation.rounds = 0"
            )
        if self.network.critic == "central" and len(set(self.worlds.teams)) > 1:
            raise ValueError(
                f"critic = 'central' with teams = {self.worlds.teams}: the state of a world grows "
                "with its team; train one team size, or use critic = 'own'"
            )
        rows = sum(team * worlds for (team, _), worlds in self._groups().items())
        if self.ppo.num_minibatches >= rows * self.ppo.num_steps:
            raise ValueError(
                f"num_minibatches = {self.ppo.num_minibatches}: an update has "
                f"{rows * self.ppo.num_steps} decisions, two at least for each minibatch"
            )
        if residual and (self.worlds.decision_rate != CONTROL_RATE or rounds):
            raise ValueError(
                f"residual = {residual}: the scripted policy decides at {CONTROL_RATE} Hz and "
                f"need not be imitated: set decision_rate = {CONTROL_RATE}, imitation.rounds = 0"
            )

    def _groups(self) -> Counter[tuple[int, str]]:
        return self.worlds.groups(self.worlds.num_envs)

    @property
    def definition(self) -> Task:
        """The task."""
        return TASKS.find(self.task)

    @property
    def first_seed(self) -> int:
        """Seed of the first world of this run."""
        return seeds.TRAINING.start + self.seed * SEEDS_PER_RUN

    @property
    def folder(self) -> Path:
        """Folder of the run."""
        if self.out is not None:
            return self.out
        return Path(f"runs/train/{self.definition.name}-{self.engine}-{self.seed}")

    def params(
        self, team: int | None = None, scenario: str = "nominal", **options: Any
    ) -> EnvParams:
        """Returns the parameters of worlds of the task and of what boats observe."""
        options["observation"] = self.worlds.observation or None
        return make_params(self.task, team, scenario, **options)

    @property
    def observed(self) -> tuple[str, ...]:
        """Names of the features that boats observe, or "module:NAME"."""
        return self.worlds.observation or tuple(feature.name for feature in observation.DEFAULT)

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns of what a boat observes."""
        return observation.column_names(observation.features(self.params()))

    def changed(self, **options: Any) -> Self:
        """Returns a copy with other options; a mapping changes these fields of a section."""
        values = {
            name: replace(getattr(self, name), **value) if isinstance(value, Mapping) else value
            for name, value in options.items()
        }
        return replace(self, **values)

    def learned(self) -> dict[str, Any]:
        """Returns the options that bear on what is learned, by section, as JSON knows them."""
        options = json.loads(json.dumps(asdict(self), default=str))
        return {name: value for name, value in options.items() if name not in NOT_LEARNED}


PRESETS = {
    "approach": Config("approach").changed(imitation={"time": 40.0}),
    "push": Config("push").changed(imitation={"time": 90.0}, worlds={"time_limit": 90.0}),
    "transport": Config("transport").changed(imitation={"time": 120.0}),
}
"""Default options of the built-in tasks."""


def preset(task: str) -> Config:
    """Returns the default options of a task: those of the built-in task of its kind."""
    config = Config(task)
    kind = "push" if config.definition.starts_grasped else "transport"
    return PRESETS[kind if config.definition.has_goal else "approach"].changed(task=task)


def parse(arguments: Sequence[str] | None = None) -> Config:
    """Returns the options of a command line; what is not given is the task's preset."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    task = re.search(r"(?:^|\s)--task[= ](\S+)", " ".join(given))
    default = preset(task[1] if task else Config.task)
    return tyro.cli(Config, default=default, args=given, prog="python -m train")
