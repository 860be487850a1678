"""What a training run is: its options, named as in CleanRL, and what each task presets."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path
from typing import Any, Literal

import tyro

from asv_env.checks import check_numbers, check_whole, choice
from asv_env.params import ClockParams, check_num_boats
from asv_env.presets import SCENARIOS
from asv_env.tasks import TASKS
from baselines.rollout import seeds

Task = Literal["approach", "push", "transport"]
Engine = Literal["sb3", "rllib"]
Activation = Literal["relu", "tanh"]
Critic = Literal["own", "central"]
CONTROL_RATE = ClockParams().control
SEEDS_OF_A_RUN = 10**6
"""Between the first seeds of two runs."""
LEAST_RATE = 0.1
"""Share of the learning rates that is left at the end where they fall."""
BAR: dict[str, Any] = {"unit": " steps", "unit_scale": True, "desc": "PPO", "file": sys.stderr}
"""How a training shows its progress."""
WHERE = (
    *("out", "overwrite", "torch_threads", "num_env_runners", "ray_address"),
    *("track", "wandb_project_name", "wandb_entity"),
)
"""Options by which nothing else is learned, but for rounding."""


@dataclass(frozen=True)
class Config:
    """Train a policy that all boats share; the same command goes on with a run that was stopped.

    Attributes:
        task: what is learned.
        engine: sb3 (stable-baselines3) or rllib (Ray: also several machines).
        seed: of the run, from 0; the seeds of its worlds follow from it.
        out: folder of the run; below runs/train by default.
        overwrite: begin anew where the folder holds a run.
        init_from: policy file (.npz), of any task, with whose weights the actor begins.
        demonstrations: folder of recorded episodes that are imitated too.
        num_envs: worlds side by side, shared out over teams and scenarios.
        teams: numbers of boats, mixed; one that is named twice gets twice the worlds.
        scenarios: what disturbs the worlds, mixed.
        decision_rate: of the policy, Hz.
        time_limit: of an episode in training, s for a vessel of 0.40 m; the task's by default.
        mirror: train with goals ahead of the team alone, and mirror the world where they are not.
        near_goals: share of episodes whose goals are nearer, by a factor drawn uniformly.
        near_starts: share of episodes in which the boats begin beside the hull.
        slot_starts: share of episodes in which the boats begin in their slots, as in Push.
        midway_starts: share of episodes that begin midway in one of the scripted policy.
        hand_over: policy file of several networks; midway starts are then where these have brought
            the vessel into closure and push, time and again.
        narrowest: share of half a turn by which goals lie off the way ahead, and are turned, in
            the beginning; noise and variation begin with that share too.
        widening: what is added to it at a checkpoint where most episodes succeed; 0 begins with
            the task as it is.
        until_wide: end where they have widened to all, at total_timesteps at the latest.
        imitation_rounds: of DAgger on the scripted policy before PPO; 0 learns from scratch.
        imitation_worlds: in which it is watched.
        imitation_time: of a round, s in every world.
        imitation_steps: of gradient descent in a round.
        total_timesteps: of PPO, steps of single boats.
        learning_rate: of the critic when PPO begins.
        actor_learning_rate: of the actor when PPO begins.
        adapt_kl: divergence of an update to which that is adapted; None leaves it.
        anneal_lr: let both fall linearly, to a tenth; with adapt_kl that divergence, and not the
            actor's.
        num_steps: of a world between two updates.
        num_minibatches: of an epoch.
        update_epochs: of an update.
        gamma: discount of a decision.
        gae_lambda: of generalised advantage estimation.
        clip_coef: of the ratio of probabilities.
        ent_coef: weight of the entropy.
        vf_coef: weight of the value loss.
        max_grad_norm: to which gradients are clipped.
        target_kl: divergence at which an update is broken off.
        critic_updates: first updates, in which only the critic learns.
        hidden: sizes of the layers of actor and critic.
        activation: between them.
        log_std_init: of the actions when PPO begins.
        log_std_min: below which that of the actions does not fall while PPO learns.
        residual: share of a full action by which the actor corrects the scripted policy, which
            then acts too; 0 lets it act alone.
        critic: own sees what its boat observes, central the state of its world.
        eval_every: timesteps between evaluations.
        eval_episodes: of each scenario in an evaluation.
        eval_seed: of the first of them; for development.
        checkpoint_every: timesteps between checkpoints.
        torch_threads: of the learner.
        track: report to Weights & Biases too.
        wandb_project_name: the project there.
        wandb_entity: its owner there.
        num_env_runners: processes that sample, of rllib.
        ray_address: of the cluster, of rllib; this machine alone by default.
    """

    task: Task = "push"
    engine: Engine = "sb3"
    seed: int = 0
    out: Path | None = None
    overwrite: bool = False
    init_from: Path | None = None
    demonstrations: Path | None = None

    num_envs: int = 192
    teams: tuple[int, ...] = (4,)
    scenarios: tuple[str, ...] = ("noisy", "nominal")
    decision_rate: int = 5
    time_limit: float | None = None
    mirror: bool = False
    near_goals: float = 0.0
    near_starts: float = 0.0
    slot_starts: float = 0.0
    midway_starts: float = 0.0
    hand_over: Path | None = None
    narrowest: float = 0.2
    widening: float = 0.0
    until_wide: bool = False

    imitation_rounds: int = 8
    imitation_worlds: int = 128
    imitation_time: float = 60.0
    imitation_steps: int = 2000

    total_timesteps: int = 20_000_000
    learning_rate: float = 5e-4
    actor_learning_rate: float = 3e-5
    adapt_kl: float | None = 0.012
    anneal_lr: bool = True
    num_steps: int = 64
    num_minibatches: int = 8
    update_epochs: int = 4
    gamma: float = 0.996
    gae_lambda: float = 0.95
    clip_coef: float = 0.2
    ent_coef: float = 0.0
    vf_coef: float = 0.5
    max_grad_norm: float = 0.5
    target_kl: float | None = None
    critic_updates: int = 20
    hidden: tuple[int, ...] = (128, 128)
    activation: Activation = "relu"
    log_std_init: float = -3.0
    log_std_min: float = -10.0
    residual: float = 0.0
    critic: Critic = "own"

    eval_every: int = 4_000_000
    eval_episodes: int = 100
    eval_seed: int = seeds.DEVELOPMENT.start
    checkpoint_every: int = 1_000_000
    torch_threads: int = 2

    track: bool = False
    wandb_project_name: str = "asv-env"
    wandb_entity: str | None = None
    num_env_runners: int = 2
    ray_address: str | None = None

    def __post_init__(self) -> None:
        choice("task", self.task, TASKS)
        for scenario in self.scenarios:
            choice("scenario", scenario, SCENARIOS)
        for team in self.teams:
            check_num_boats(team)
        positive = "num_envs imitation_worlds imitation_steps total_timesteps num_steps "
        positive += "num_minibatches update_epochs eval_every eval_episodes checkpoint_every "
        positive += "torch_threads decision_rate"
        for name in positive.split():
            check_whole(self, name, 1)
        for name in ["seed", "imitation_rounds", "critic_updates", "num_env_runners"]:
            check_whole(self, name, 0)
        for name in ["time_limit", "adapt_kl", "target_kl"]:
            if getattr(self, name) is not None:
                check_numbers(self, name, 1e-12)
        if not self.hidden or min(self.hidden) < 1:
            raise ValueError(f"hidden = {self.hidden}: give a size of at least 1 for each layer")
        shares = "near_goals near_starts slot_starts midway_starts narrowest widening residual "
        shares += "gamma gae_lambda"
        check_numbers(self, shares, 0.0, 1.0)
        rates = "learning_rate actor_learning_rate clip_coef max_grad_norm imitation_time"
        check_numbers(self, rates, 1e-12)
        check_numbers(self, "ent_coef vf_coef", 0.0)
        check_numbers(self, "log_std_init log_std_min", -10.0, 2.0)
        self._check_together()

    def _check_together(self) -> None:
        """Options that bear on each other."""
        if CONTROL_RATE % self.decision_rate:
            raise ValueError(
                f"decision_rate = {self.decision_rate}: must divide {CONTROL_RATE}, that of control"
            )
        groups = len(self.teams) * len(self.scenarios)
        if not groups or self.num_envs < groups:
            raise ValueError(
                f"num_envs = {self.num_envs}: {groups} combinations of teams and scenarios need "
                "at least a world each, and one at least"
            )
        if self.hand_over is not None and not self.midway_starts:
            raise ValueError(
                f"hand_over = {self.hand_over} with midway_starts = 0: no episode would begin "
                "there; set midway_starts to the share of those that shall"
            )
        if self.init_from is not None and self.imitation_rounds:
            raise ValueError(
                f"init_from = {self.init_from} with imitation_rounds = {self.imitation_rounds}: "
                "imitation would undo what the file has learned; set imitation_rounds = 0"
            )
        if self.until_wide and not self.widening:
            raise ValueError(
                "until_wide with widening = 0: goals are wide from the beginning, and the training "
                "would end there; set widening"
            )
        if self.critic == "central" and len(set(self.teams)) > 1:
            raise ValueError(
                f"critic = 'central' with teams = {self.teams}: the state of a world grows with "
                "its team; train one team size, or use critic = 'own'"
            )
        if self.residual and (self.decision_rate != CONTROL_RATE or self.imitation_rounds):
            raise ValueError(
                f"residual = {self.residual}: the scripted policy decides at {CONTROL_RATE} Hz and "
                f"need not be imitated: set decision_rate = {CONTROL_RATE}, imitation_rounds = 0"
            )
        seeds.check(range(self.eval_seed, self.eval_seed + self.eval_episodes), "development")
        seeds.check(range(self.first_seed, self.first_seed + SEEDS_OF_A_RUN), "training")

    @property
    def first_seed(self) -> int:
        """Of the worlds of this run."""
        return seeds.TRAINING.start + self.seed * SEEDS_OF_A_RUN

    @property
    def first_share(self) -> float:
        """Of half a turn by which goals lie off the way ahead in the beginning."""
        return self.narrowest if self.widening else 1.0

    def shared_out(self, worlds: int) -> Counter[tuple[int, str]]:
        """Number of worlds of each combination of team size and scenario, in their order."""
        named = list(product(self.teams, self.scenarios))
        each, left = divmod(worlds, len(named))
        groups: Counter[tuple[int, str]] = Counter()
        for number, group in enumerate(named):
            groups[group] += each + (number < left)
        return groups

    @property
    def decide_every(self) -> int:
        """Control ticks for which a decision is held."""
        return CONTROL_RATE // self.decision_rate

    @property
    def folder(self) -> Path:
        """Of the run."""
        return self.out or Path("runs/train") / f"{self.task}-{self.engine}-{self.seed}"

    def learned(self) -> dict[str, Any]:
        """The options that bear on what is learned, as JSON knows them."""
        options = asdict(self)
        for name in WHERE:
            del options[name]
        plain = {name: _plain(value) for name, value in options.items()}
        return plain


def _plain(value: Any) -> Any:
    if isinstance(value, tuple):
        return list(value)
    return str(value) if isinstance(value, Path) else value


PRESETS = {
    "approach": Config(task="approach", imitation_time=40.0),
    "push": Config(task="push", imitation_time=90.0, time_limit=90.0),
    "transport": Config(task="transport", imitation_time=120.0, mirror=True),
}
"""Where to begin, by task."""


def parse(arguments: Sequence[str] | None = None) -> Config:
    """Options from a command line; what is not given is the task's preset.

    Exits with a message where something is wrong.
    """
    given = list(sys.argv[1:] if arguments is None else arguments)
    default = PRESETS.get(_task(given), Config())
    return tyro.cli(Config, default=default, args=given, prog="python -m train")


def _task(arguments: Sequence[str]) -> str:
    """The task on a command line."""
    for number, word in enumerate(arguments):
        name, _, value = word.partition("=")
        if name == "--task":
            return value or (list(arguments[number + 1 :]) or [""])[0]
    return Config.task
