"""The engine rllib: a warm start by imitation, then PPO of Ray RLlib.

The processes that sample are on this machine, or on those of a Ray cluster, each of which needs
this package. All boats share one policy. Options mean what they mean to the engine sb3, but for
``adapt_kl`` and ``target_kl``, which have no effect: the actor's learning rate does not follow the
divergence of the updates.

A run that goes on from a checkpoint begins new episodes. It does not repeat to the bit what it
would have done if nobody had stopped it.
"""

from __future__ import annotations

import json
import logging
import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import ray
import torch
from ray.rllib.algorithms.ppo import PPO, PPOConfig
from ray.rllib.algorithms.ppo.torch.ppo_torch_learner import PPOTorchLearner
from ray.rllib.core.columns import Columns
from ray.rllib.env.wrappers.pettingzoo_env import ParallelPettingZooEnv
from tensorboardX import SummaryWriter  # type: ignore[import-not-found]
from torch import nn
from tqdm import tqdm

from asv_env.envs.parallel import AsvParallelEnv
from asv_env.presets import make_params
from asv_env.sensing import observation
from baselines.learned.metadata import Layers
from baselines.learned.network import NetworkPolicy
from baselines.rollout.files import write_text
from train import actors, evaluation, tracking
from train.config import BAR, LEAST_RATE, SEEDS_OF_A_RUN, Config
from train.curriculum import Starts, training_params
from train.run import TENSORBOARD, Run, opened

BOAT = "boat"
"""Name of the policy that all boats share."""
SEEDS = 2**31
"""Seeds that RLlib takes are below."""
TOLERANCE = 1e-5
"""Largest difference between the actions of a policy file and those of the network."""
COMPARED = 256
"""Observations on which they are compared."""
PROGRESS = "progress.json"
LONGEST = 36
"""Letters of a folder for temporary files in which Ray's sockets have room."""


class Boats(ParallelPettingZooEnv):
    """A world of the training, as RLlib wants it.

    RLlib 2.60 takes an episode for terminated when each of its agents is truncated, and values
    its end at nothing: so the end of the time is told by ``__all__`` alone. Its seeds count up
    from process to process as from world to world, which would make twins: the worlds are
    numbered anew. The number says which scenario a world has, and how long its first episode is,
    so that not all worlds end in the same step.

    Args:
        context: an ``EnvContext`` with ``config`` of the run and ``seed`` of its first world.
    """

    par_env: AsvParallelEnv

    def __init__(self, context: Any) -> None:
        self._context = context
        self._left = -1
        super().__init__(self._made(0))

    def _made(self, number: int) -> AsvParallelEnv:
        config = self._context["config"]
        scenario = config.scenarios[number % len(config.scenarios)]
        params = training_params(config, config.teams[0], scenario)
        return AsvParallelEnv(
            config.task,
            config.teams[0],
            scenario=scenario,
            initial_states=Starts(config),
            clock=params.clock,
            task_params=params.task,
        )

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        """Begins an episode; with a seed the first one of the world that has it."""
        self._left = -1
        if seed is not None:
            config, first = self._context["config"], self._context["seed"]
            process = self._context.worker_index
            number = seed - first % SEEDS - process + max(0, process - 1) * worlds_each(config)
            self.par_env.close()
            self.par_env = self._made(number)
            share = (number + 1) / (worlds_each(config) * processes(config))
            self._left = int(np.ceil(share * self.par_env.params.time_limit_ticks))
            seed = first + number
        return super().reset(seed=seed, options=options)

    def step(self, action_dict: dict[str, Any]) -> Any:
        """Advances the world by a decision of each boat."""
        *step, truncated, infos = super().step(action_dict)
        self._left -= 1
        return *step, {"__all__": truncated["__all__"] or self._left == 0}, infos


class Learner(PPOTorchLearner):
    """PPO whose actor and critic have optimizers and learning rates of their own."""

    def configure_optimizers_for_module(self, module_id: str, config: Any = None) -> None:
        """Makes them; RLlib calls it."""
        module = self.module[module_id]
        parts = {
            "actor": (module.encoder.actor_encoder, module.pi),
            "critic": (module.encoder.critic_encoder, module.vf),
        }
        for name, some in parts.items():
            weights = [one for part in some for one in self.get_parameters(part)]
            self.register_optimizer(
                module_id=module_id,
                optimizer_name=name,
                optimizer=torch.optim.Adam(weights, eps=1e-5),
                params=weights,
                lr_or_lr_schedule=config.learner_config_dict[name],
            )


def processes(config: Config) -> int:
    """That sample; without any others this one does."""
    return max(1, config.num_env_runners)


def worlds_each(config: Config) -> int:
    """Worlds of a process."""
    return -(-config.num_envs // processes(config))


def rollout(config: Config) -> int:
    """Timesteps between two updates, about: RLlib adds what is left of its last step."""
    return config.num_steps * worlds_each(config) * processes(config) * config.teams[0]


def schedule(config: Config, rate: float, waits: int = 0) -> list[list[float]]:
    """Of a learning rate: when, in steps of worlds, which RLlib counts here, and what it is then.

    Args:
        config: of the run.
        rate: to begin with.
        waits: first updates, in which it is 0.
    """
    team = config.teams[0]
    begins = max(2, round((waits - 0.5) * rollout(config) / team)) if waits else 0
    ends = max(begins + 1, round((1 - LEAST_RATE) * config.total_timesteps / team))
    least = LEAST_RATE if config.anneal_lr else 1.0
    left = max(least, 1 - begins * team / config.total_timesteps)
    falls = [[begins, rate * left], [ends, rate * least]]
    return [[0, 0.0], [begins - 1, 0.0], *falls] if waits else falls


def settings(config: Config, done: int) -> PPOConfig:
    """What RLlib is asked for.

    Steps are those of single boats. Each world's part of a batch has one row more than steps, the
    state after the last of them, of which the minibatches have their share.

    Args:
        config: of the run.
        done: timesteps of the training so far.
    """
    worlds = worlds_each(config) * processes(config)
    seed = config.first_seed + done % (SEEDS_OF_A_RUN - worlds)
    rows = rollout(config) * (config.num_steps + 1) // config.num_steps
    ppo = PPOConfig()
    ppo.environment(Boats, env_config={"config": config, "seed": seed}, disable_env_checking=True)
    ppo.env_runners(
        num_env_runners=config.num_env_runners, num_envs_per_env_runner=worlds_each(config)
    )
    ppo.learners(
        learner_class=Learner,
        learner_config_dict={
            "actor": schedule(config, config.actor_learning_rate, config.critic_updates),
            "critic": schedule(config, config.learning_rate),
        },
    )
    ppo.multi_agent(
        policies={BOAT},
        policy_mapping_fn=lambda agent, episode, **_: BOAT,
        count_steps_by="agent_steps",
    )
    ppo.rl_module(
        model_config={
            "fcnet_hiddens": list(config.hidden),
            "fcnet_activation": config.activation,
            "vf_share_layers": False,
            "free_log_std": True,
        }
    )
    ppo.training(
        gamma=config.gamma,
        lambda_=config.gae_lambda,
        train_batch_size_per_learner=rollout(config),
        minibatch_size=min(rollout(config), -(-rows // config.num_minibatches)),
        num_epochs=config.update_epochs,
        clip_param=config.clip_coef,
        entropy_coeff=config.ent_coef,
        vf_loss_coeff=config.vf_coef,
        vf_clip_param=float("inf"),  # else large errors of the value teach nothing
        grad_clip=config.max_grad_norm,
        use_kl_loss=False,
    )
    ppo.debugging(seed=seed % SEEDS)
    ppo.fault_tolerance(restart_failed_env_runners=config.ray_address is not None)
    return ppo


def check(config: Config) -> None:
    """Refuses what only the engine sb3 can do.

    Raises:
        ValueError: there is something of that.
    """
    if len(set(config.teams)) > 1:
        raise ValueError(
            f"teams = {config.teams} with engine = 'rllib': it trains one team size; choose one, "
            "or use engine = 'sb3'"
        )
    if config.critic == "central":
        raise ValueError(
            "critic = 'central' with engine = 'rllib': RLlib has no critic that sees the state of "
            "a world; use critic = 'own', or engine = 'sb3'"
        )
    for name in ("widening", "midway_starts", "residual"):
        if getattr(config, name):
            raise ValueError(
                f"{name} = {getattr(config, name)} with engine = 'rllib': only sb3 knows that; "
                f"use {name} = 0, or engine = 'sb3'"
            )
    if config.log_std_min != Config.log_std_min:
        raise ValueError(
            f"log_std_min = {config.log_std_min} with engine = 'rllib': only sb3 keeps the noise "
            "up; leave it out, or use engine = 'sb3'"
        )


@contextmanager
def connected(config: Config) -> Iterator[None]:
    """Ray, while the block runs: the cluster that is asked for, or this machine alone.

    Raises:
        ConnectionError: there is no such cluster.
    """
    logging.getLogger("ray.rllib").setLevel(logging.ERROR)
    folder = None
    if config.ray_address is not None:
        ray.init(config.ray_address, logging_level=logging.ERROR)
    else:
        os.environ.setdefault("RAY_AUTH_MODE", "disabled")  # else it writes a token at home
        if "RAY_TMPDIR" not in os.environ and len(tempfile.gettempdir()) > LONGEST:
            folder = tempfile.mkdtemp(prefix="ray-", dir="/tmp")
        alone = {"num_cpus": processes(config), "include_dashboard": False, "_temp_dir": folder}
        ray.init("local", logging_level=logging.ERROR, **alone)
    try:
        yield
    finally:
        ray.shutdown()
        if folder is not None:
            shutil.rmtree(folder, ignore_errors=True)


@dataclass
class Progress:
    """How far a training has come.

    Attributes:
        timesteps: of single boats.
        seconds: over all parts of the run.
        best: merit of the best policy, s.
    """

    timesteps: int = 0
    seconds: float = 0.0
    best: float = float("inf")


class Checkpoints:
    """Those of a run: a folder each, and a file that names the last.

    Whenever a run is killed, the file names one that is whole.

    Args:
        folder: of the run.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder / "checkpoint"
        self._last = self._folder / "last"

    def last(self) -> tuple[Path | None, Progress]:
        """Folder of the last and how far the training had come; without one None, and not far."""
        if not self._last.exists():
            return None, Progress()
        found = self._folder / self._last.read_text(encoding="utf-8")
        return found, Progress(**json.loads((found / PROGRESS).read_text(encoding="utf-8")))

    def save(self, algorithm: PPO, progress: Progress) -> None:
        """Writes one, then deletes all others."""
        self._folder.mkdir(exist_ok=True)
        new = Path(tempfile.mkdtemp(prefix=f"{progress.timesteps}-", dir=self._folder))
        algorithm.save_to_path(new.absolute())
        (new / PROGRESS).write_text(json.dumps(asdict(progress)), encoding="utf-8")
        write_text(self._last, new.name)
        for other in self._folder.iterdir():
            if other.is_dir() and other != new:
                shutil.rmtree(other)


class Training:
    """Samples, learns, evaluates and saves.

    Args:
        run: with the folder.
        algorithm: of RLlib.
        progress: of the training so far.
        bar: of the timesteps.
    """

    def __init__(self, run: Run, algorithm: PPO, progress: Progress, bar: tqdm) -> None:
        self._run, self._algorithm, self._progress, self._bar = run, algorithm, progress, bar
        self._log = SummaryWriter(str(run.folder / TENSORBOARD))
        self._since = time.monotonic()

    def go_on(self) -> None:
        """Trains until all timesteps are done."""
        config = self._run.config
        while self._progress.timesteps < config.total_timesteps:
            before = self._progress.timesteps
            self._update()
            now = self._progress.timesteps
            over = now >= config.total_timesteps
            evaluates = over or now // config.eval_every > before // config.eval_every
            if evaluates:
                self.evaluate()
            if evaluates or now // config.checkpoint_every > before // config.checkpoint_every:
                self.save()

    def _update(self) -> None:
        """Samples and learns from it."""
        result = self._algorithm.train()
        sampled = result["env_runners"]
        steps = int(sampled["num_module_steps_sampled"][BOAT])
        self._progress.timesteps += steps
        self._bar.update(steps)
        told = {f"train/{name}": value for name, value in result["learners"][BOAT].items()}
        told["rollout/ep_rew_mean"] = sampled.get("episode_return_mean")
        for name, value in told.items():
            self._tell(name, value)
        self._log.flush()

    def evaluate(self) -> None:
        """Scores the policy as it is, and keeps it if it is the best so far."""
        run, progress = self._run, self._progress
        layers = exported(module_of(self._algorithm), run)
        self._count_time()
        now = (progress.timesteps, progress.seconds)
        scores = evaluation.evaluate(layers, run.metadata, run.config, now)
        self._count_time()
        evaluation.keep(run, layers, scores, evaluation.merit(scores) < progress.best)
        progress.best = min(progress.best, evaluation.merit(scores))
        for name, value in evaluation.told(scores).items():
            self._tell(name, value)
        self._bar.set_postfix_str(evaluation.headline(scores))

    def _tell(self, name: str, value: object) -> None:
        """Logs a number; what is none, or not finite, is left out."""
        if isinstance(value, float | int) and np.isfinite(value):
            self._log.add_scalar(name, value, self._progress.timesteps)

    def save(self) -> None:
        """Writes the checkpoint."""
        self._count_time()
        Checkpoints(self._run.folder).save(self._algorithm, self._progress)

    def _count_time(self) -> None:
        now = time.monotonic()
        self._progress.seconds += now - self._since
        self._since = now


def module_of(algorithm: PPO) -> Any:
    """Actor and critic of the learner."""
    (found,) = algorithm.learner_group.foreach_learner(lambda learner: learner.module[BOAT])
    return found.get()


def actor(module: Any) -> nn.Sequential:
    """From observations to mean actions; shares its weights with RLlib's module."""
    return nn.Sequential(module.encoder.actor_encoder.net, module.pi.net)


def exported(module: Any, run: Run) -> Layers:
    """The actor as a policy file wants it.

    Args:
        module: of RLlib.
        run: for whose task it is.

    Raises:
        RuntimeError: the policy file would not do what the module does.
    """
    layers = actors.layers_of(actor(module))
    policy = NetworkPolicy(layers, run.metadata, make_params(run.config.task))
    size = (COMPARED, len(observation.NAMES))
    seen = np.random.default_rng(0).standard_normal(size, dtype=np.float32)
    told = module.forward_inference({Columns.OBS: torch.from_numpy(seen)})
    distribution = module.get_inference_action_dist_cls().from_logits(
        told[Columns.ACTION_DIST_INPUTS]
    )
    wanted = distribution.to_deterministic().sample().numpy().clip(-1.0, 1.0)
    difference = float(np.abs(policy.forward(seen) - wanted).max())
    if difference > TOLERANCE:
        raise RuntimeError(
            f"the exported policy differs by {difference:.1e} from the one that was trained"
        )
    return layers


def begin(algorithm: PPO, config: Config, start: Layers | None) -> None:
    """Gives an untrained learner its noise, and its actor what it begins with."""
    module = module_of(algorithm)
    with torch.no_grad():
        module.pi.log_std.fill_(config.log_std_init)
    actors.begin(actor(module), config, start)


def hand_out(algorithm: PPO) -> None:
    """Gives the learner's weights to all processes and waits until they have them.

    RLlib's own ``sync_weights`` drops what is for a process that has not yet answered the last
    time, as it is with those that have just been made: after its ``restore_from_path`` too, the
    first steps would come from untrained weights.
    """
    state = algorithm.learner_group.get_state("learner/rl_module", inference_only=True)["learner"]
    algorithm.env_runner_group.foreach_env_runner(lambda runner: runner.set_state(state))


def train(config: Config) -> None:
    """Trains, from the beginning or from the checkpoint that is there.

    Raises:
        ValueError, OSError: something of what was asked for does not go; see ``check`` and
            ``opened``.
    """
    check(config)
    torch.set_num_threads(config.torch_threads)
    run, start = opened(config)
    last, progress = Checkpoints(run.folder).last()
    done, total = progress.timesteps, config.total_timesteps
    if done >= total:
        return
    with tracking.tracked(config, run.folder, run.id), connected(config):
        algorithm, began = settings(config, done).build_algo(), time.monotonic()
        if last is None:
            begin(algorithm, config, start)
        else:
            run.note_code()
            algorithm.restore_from_path(last.absolute())
        hand_out(algorithm)
        progress.seconds += time.monotonic() - began
        evaluation.cut(run.curve, -1 if last is None else done)
        with tqdm(total=total, initial=done, **BAR) as bar:
            training = Training(run, algorithm, progress, bar)
            if last is None:
                training.evaluate()
                training.save()
            training.go_on()
        algorithm.stop()
