"""A recipe of learned policies: ``python -m train.recipe``.

Several trainings, some of which begin with what the one before them has learned. At the end
networks that approach the vessel and networks that push it are joined: ``transport.npz`` is a
policy for Push and Transport, with two networks for every team and two for teams of four;
``approach.npz`` is one for Approach. Each training is a run of ``python -m train`` with a folder of
its own; the same command resumes where it was stopped.
"""

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from asv_env.files import write_bytes
from baselines.learned import policy_file
from baselines.learned.policy_file import SUFFIX
from baselines.rollout.commands import FilePath, command
from baselines.rollout.lock import locked
from train.config import PRESETS, Config
from train.run import BEST


@dataclass(frozen=True)
class Training:
    """One training of the recipe."""

    config: Config  #: options of the run, but for its seed, its folder and its initial policy
    after: str | None = None  #: name of the training with whose best policy it begins
    approach: str | None = None
    """Name of a training of Approach: pushes then begin where its policy reaches closure."""


APPROACH = "approach"  #: name of the training of ``approach.npz``, for all teams
APPROACH_FOUR = "approach-four"  #: name of the training that approaches with four boats
PAIRS = ((APPROACH, "push-teams", None), (APPROACH_FOUR, "push-finely", 4))
"""Trainings of Approach and Push that make ``transport.npz``, and the only team size of each."""
PATIENCE = 34.0  #: time after which a push is given up, s for a vessel of 0.40 m
FIRST_PUSH = PRESETS["push"].changed(
    worlds={"mirror": True, "time_limit": 45.0, "num_envs": 64},
    curriculum={"near_goals": 0.15, "step": 0.03, "until_complete": True},
    imitation={"rounds": 0},
    ppo={
        "critic_updates": 0,
        "num_steps": 128,
        "update_epochs": 3,
        "gamma": 0.99,
        "actor_learning_rate": 3e-4,
        "anneal_lr": False,
        "ent_coef": 0.002,
        "total_timesteps": 200_000_000,
    },
    network={"log_std_init": -0.7, "log_std_min": -1.7},
)
"""Options of a push that is learned from scratch, until goals lie in all directions: the later
trainings do not teach those that this one has not learned."""
LATER_PUSH = FIRST_PUSH.changed(
    worlds={"scenarios": ("noisy", "nominal", "mismatch", "gyre")},
    curriculum={"rollout_starts": 0.5, "near_goals": 0.25, "step": 0.0, "until_complete": False},
    ppo={"critic_updates": 10, "ent_coef": 0.001},
)
"""Options of a push that begins with one that has been learned."""
FINE_PUSH = LATER_PUSH.changed(
    worlds={"scenarios": ("noisy", "noisy", "noisy", "nominal", "mismatch")},
    curriculum={"rollout_starts": 0.6},
    ppo={"adapt_kl": 0.006, "num_minibatches": 4},
)
"""Options of the last push for four boats."""
TEAM_PUSH = LATER_PUSH.changed(
    worlds={
        "teams": (3, 4, 4, 4, 6, 6, 8, 8, 12),
        "scenarios": ("noisy", "noisy", "mismatch", "failure"),
        "num_envs": 324,
        "time_limit": 40.0,
    },
    ppo={"num_steps": 20, "gamma": 0.994, "adapt_kl": 0.01},
    network={"hidden": (256, 256)},
    evaluation={"every": 20_000_000, "episodes": 10},
)
"""Options of a push for all teams."""
TO_SLOTS = PRESETS["approach"].changed(
    worlds={"time_limit": 60.0},
    curriculum={"near_starts": 0.25, "slot_starts": 0.15},
    ppo={"gamma": 0.98, "total_timesteps": 10_000_000},
    network={"log_std_init": -2.7},
)
"""Options of an approach for four boats."""
TO_SLOTS_TEAMS = TO_SLOTS.changed(
    worlds={"teams": (2, 3, 4, 4, 6, 8, 12), "scenarios": ("noisy", "nominal", "failure")},
    ppo={"total_timesteps": 12_000_000},
    evaluation={"episodes": 40},
)
"""Options of an approach for all teams."""


def _push(after: str, timesteps: int, log_std: Sequence[float], config: Config) -> Training:
    """Returns a push after another one; ``log_std`` are the initial and the least."""
    noise = dict(zip(("log_std_init", "log_std_min"), log_std, strict=True))
    config = config.changed(ppo={"total_timesteps": timesteps}, network=noise)
    return Training(config, after, APPROACH if len(config.worlds.teams) > 1 else APPROACH_FOUR)


TRAININGS = {
    APPROACH: Training(TO_SLOTS_TEAMS),
    APPROACH_FOUR: Training(TO_SLOTS),
    "push": Training(FIRST_PUSH),
    "push-on": _push("push", 14_000_000, (-2.1, -2.4), LATER_PUSH),
    "push-exactly": _push("push-on", 18_000_000, (-2.6, -3.0), LATER_PUSH),
    "push-finely": _push("push-exactly", 8_000_000, (-3.3, -3.5), FINE_PUSH),
    "push-teams": _push("push-finely", 70_000_000, (-2.4, -3.0), TEAM_PUSH),
}
"""The recipe, in the order in which it is followed."""


def follow(seed: int = 0, out: FilePath | None = None, torch_threads: int = 2) -> None:
    """Train policies like those of this package, but for what is trained already.

    Args:
        seed: Seed of the trainings.
        out: Folder; by default runs/train/recipe-SEED.
        torch_threads: Threads of the learner.

    Raises:
        ValueError, OSError: a folder holds something else; see ``train.launch.open_run``.
    """
    from train.sb3 import training  # needs torch, which takes its time

    out = out or Path(f"runs/train/recipe-{seed}")
    with locked(out):
        _follow(seed, out, torch_threads, training.train)


def _follow(seed: int, out: Path, torch_threads: int, train: Callable[[Config], None]) -> None:
    """Trains what is not trained yet, and joins the networks."""
    for name in TRAININGS:
        print(f"{name}: {out / name}", file=sys.stderr)
        config = config_of(name, out).changed(seed=seed, compute={"torch_threads": torch_threads})
        train(config)
        if config.init_from and not policy_file.read(out / name / BEST)[1]["timesteps"]:
            print(f"{name}: nothing better than its initial policy", file=sys.stderr)
    write_bytes(out / f"approach{SUFFIX}", _checked(out / APPROACH).read_bytes())
    join(out, PAIRS, out / f"transport{SUFFIX}")


def config_of(name: str, out: Path) -> Config:
    """Returns the options of a training with its folder and initial policy, of those before it."""
    step = TRAININGS[name]
    config = step.config.changed(out=out / name)
    if step.after is None:
        return config
    config = config.changed(init_from=out / step.after / BEST)
    if step.approach is None:
        return config
    joined = out / f"{step.after}-joined{SUFFIX}"
    if not joined.exists():
        join(out, [(step.approach, step.after, None)], joined)
    return config.changed(curriculum={"rollout_policy": joined})


def join(out: Path, pairs: Sequence[tuple[str, str, int | None]], file: Path) -> None:
    """Writes a policy file of networks that approach and networks that push.

    Args:
        out: folder of the recipe.
        pairs: names of the training of one of each, and the only team size that uses them.
        file: to be written.

    Raises:
        ValueError: a policy file differs from the network that was trained.
    """
    phases, model_cards = [], []
    for approach, push, team_size in pairs:
        for name, patience in ((approach, None), (push, PATIENCE)):
            phase, model_card = policy_file.read_single(_checked(out / name))
            phases.append(replace(phase, patience=patience, team_size=team_size))
            model_cards.append(model_card)
    policy_file.save(file, phases, {"phases": model_cards})


def _checked(run: Path) -> Path:
    """Returns the best policy file of a run, compared with the network that was trained."""
    from train.sb3 import export

    export.check(run)
    return run / BEST


main = command(follow, "python -m train.recipe")

if __name__ == "__main__":
    main()
