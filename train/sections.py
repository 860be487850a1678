"""The sections of a training's options, each of which checks itself; names are CleanRL's."""

from collections import Counter
from dataclasses import dataclass
from itertools import cycle, islice, product
from typing import Literal

from asv_env.checks import TINY, check_num_boats, check_numbers, check_whole
from asv_env.params import ClockParams
from asv_env.presets import SCENARIOS
from asv_env.sensing import observation
from baselines.rollout import seeds
from baselines.rollout.commands import FilePath

CONTROL_RATE = ClockParams().control  #: rate at which the scripted policy decides, Hz
MOST_STEPS = 10**15  #: largest number of timesteps
MOST_WORLDS = 100_000  #: largest number of worlds
MOST_UNITS = 2**16  #: largest size of a hidden layer
LARGEST_RATE = 1.0  #: largest learning rate
LEAST_RATE = 0.1  #: fraction of the learning rates that is left at the end where they are annealed


@dataclass(frozen=True)
class WorldOptions:
    """Worlds in which the policy learns."""

    num_envs: int = 192  #: number of worlds, distributed over team sizes and scenarios
    teams: tuple[int, ...] = (4,)  #: team sizes; one that is named twice gets twice the worlds
    scenarios: tuple[str, ...] = ("noisy", "nominal")  #: disturbances: names, or "module:NAME"
    observation: tuple[str, ...] = ()  #: features of an observation, or "module:NAME"; default: all
    decision_rate: int = 5  #: rate of the policy, Hz
    time_limit: float | None = None  #: of an episode, s for a vessel of 0.40 m; default: the task's

    def __post_init__(self) -> None:
        for scenario in self.scenarios:
            SCENARIOS.find(scenario)
        if self.observation:
            observation.chosen(self.observation)
        for team in self.teams:
            check_num_boats(team)
        check_whole(self, "num_envs", 1, MOST_WORLDS)
        check_whole(self, "decision_rate", 1)
        if self.time_limit is not None:
            check_numbers(self, "time_limit", TINY)
        if CONTROL_RATE % self.decision_rate:
            raise ValueError(
                f"decision_rate = {self.decision_rate}: must divide the control rate {CONTROL_RATE}"
            )
        groups = len(self.teams) * len(self.scenarios)
        if not groups or self.num_envs < groups:
            raise ValueError(
                f"num_envs = {self.num_envs}: each of the {groups} combinations of teams and "
                "scenarios needs at least one world, and there must be at least one combination"
            )

    def groups(self, worlds: int) -> Counter[tuple[int, str]]:
        """Returns how many of ``worlds`` each combination (team size, scenario) gets, in order."""
        named = list(product(self.teams, self.scenarios))
        groups = Counter(dict.fromkeys(named, 0))
        groups.update(islice(cycle(named), worlds))
        return groups


@dataclass(frozen=True)
class CurriculumOptions:
    """Easier episodes, some for the whole training and some until the policy succeeds."""

    start: float = 0.2
    """Initial progress of the curriculum, 0 to 1: the bearing and the turn of goals, noise and
    variation are scaled by the progress."""
    step: float = 0.0  #: progress added where most episodes succeed; 0: the full task at once
    near_goals: float = 0.0  #: fraction of episodes with a goal at a random part of its distance
    near_starts: float = 0.0  #: fraction of episodes in which the boats begin close to the hull
    rollout_starts: float = 0.0
    """Fraction of episodes that begin in a state of a rollout of the scripted policy."""

    def __post_init__(self) -> None:
        check_numbers(self, "start step near_goals near_starts rollout_starts", 0, 1)

    @property
    def first_progress(self) -> float:
        """Progress with which a training begins."""
        return self.start if self.step else 1.0


@dataclass(frozen=True)
class ImitationOptions:
    """Imitation of the scripted policy before PPO, by DAgger."""

    rounds: int = 8  #: number of rounds; 0 learns from scratch
    worlds: int = 128  #: number of worlds in a round
    time: float = 60.0  #: simulated time of a round in every world, s
    steps: int = 2000  #: gradient steps in a round
    demonstrations: FilePath | None = None  #: folder of recorded episodes that are imitated too

    def __post_init__(self) -> None:
        check_whole(self, "rounds", 0)
        check_whole(self, "worlds", 1, MOST_WORLDS)
        check_whole(self, "steps", 1)
        check_numbers(self, "time", TINY)


@dataclass(frozen=True)
class PPOOptions:
    """Proximal policy optimisation."""

    total_timesteps: int = 20_000_000  #: number of decisions of single boats
    learning_rate: float = 5e-4  #: initial learning rate of the critic
    actor_learning_rate: float = 3e-5  #: initial learning rate of the actor
    adapt_kl: float | None = 0.012  #: KL divergence to which the actor's learning rate is adapted
    anneal_lr: bool = True
    """Decrease both learning rates linearly to a tenth; with adapt_kl the divergence in place of
    the actor's rate."""
    num_steps: int = 64  #: decisions in each world between two updates
    num_minibatches: int = 8  #: minibatches of an epoch
    update_epochs: int = 4  #: epochs of an update
    gamma: float = 0.996  #: discount factor of a decision
    gae_lambda: float = 0.95  #: parameter lambda of generalised advantage estimation
    clip_coef: float = 0.2  #: clipping range of the probability ratio
    ent_coef: float = 0.0  #: weight of the entropy
    vf_coef: float = 0.5  #: weight of the value loss
    max_grad_norm: float = 0.5  #: norm to which gradients are clipped
    target_kl: float | None = None  #: KL divergence at which an update stops early
    critic_updates: int = 20  #: number of first updates in which only the critic learns

    def __post_init__(self) -> None:
        check_whole(self, "total_timesteps", 1, MOST_STEPS)
        check_whole(self, "num_steps num_minibatches update_epochs", 1, 10**6)
        check_whole(self, "critic_updates", 0, MOST_STEPS)
        for name in ("adapt_kl", "target_kl"):
            if getattr(self, name) is not None:
                check_numbers(self, name, TINY)
        check_numbers(self, "gamma gae_lambda", 0, 1)
        check_numbers(self, "learning_rate actor_learning_rate", TINY, LARGEST_RATE)
        check_numbers(self, "clip_coef max_grad_norm", TINY)
        check_numbers(self, "ent_coef vf_coef", 0)


@dataclass(frozen=True)
class NetworkOptions:
    """Actor and critic."""

    hidden: tuple[int, ...] = (128, 128)  #: sizes of the hidden layers of actor and critic
    activation: Literal["relu", "tanh"] = "relu"  #: activation after each hidden layer
    log_std_init: float = -3.0  #: logarithm of the actions' standard deviation when PPO begins
    log_std_min: float = -10.0  #: smallest logarithm of the actions' standard deviation during PPO
    residual: float = 0.0  #: part of a full action by which the actor corrects the scripted policy
    critic: Literal["own", "central"] = "own"  #: sees what its boat does, or the world's state too

    def __post_init__(self) -> None:
        if not self.hidden or not all(1 <= size <= MOST_UNITS for size in self.hidden):
            raise ValueError(
                f"hidden = {self.hidden}: give a size of 1 to {MOST_UNITS} for each layer"
            )
        check_numbers(self, "log_std_init log_std_min", -10, 2)
        check_numbers(self, "residual", 0, 1)


@dataclass(frozen=True)
class EvaluationOptions:
    """Evaluation on development seeds during a training."""

    every: int = 4_000_000  #: timesteps between evaluations
    episodes: int = 100  #: episodes of each team size and scenario
    seed: int = seeds.DEVELOPMENT.start  #: seed of the first episode, a development seed

    def __post_init__(self) -> None:
        check_whole(self, "every", 1, MOST_STEPS)
        check_whole(self, "episodes", 1)
        seeds.check(self.seeds, "development")

    @property
    def seeds(self) -> range:
        """Seeds of the episodes."""
        return range(self.seed, self.seed + self.episodes)


@dataclass(frozen=True)
class TrackingOptions:
    """Weights & Biases."""

    track: bool = False  #: report to Weights & Biases too
    wandb_project_name: str = "asv-env"  #: project at Weights & Biases
    wandb_entity: str | None = None  #: owner of the project at Weights & Biases


@dataclass(frozen=True)
class ComputeOptions:
    """Threads, processes and machines; they change what is learned by rounding alone."""

    torch_threads: int = 2  #: threads of the learner
    num_env_runners: int = 2  #: processes in which rllib samples; 0: that of the learner
    ray_address: str | None = None  #: of a Ray cluster for rllib; default: this machine alone

    def __post_init__(self) -> None:
        check_whole(self, "torch_threads", 1, 1024)
        check_whole(self, "num_env_runners", 0, 10_000)
