"""The recipe of the policies that are part of this package: ``python -m train.recipe``.

Several trainings, some of which begin with what the one before them has learned. At the end
networks that approach the vessel and networks that push it are put together: ``transport.npz`` is
a policy for Push and Transport, with two networks for every team and two for teams of four;
``approach.npz`` is one for Approach. Each training is a run as ``python -m train`` makes it, with a
folder of its own; the same command goes on where it was stopped.
"""

from __future__ import annotations

import argparse
import shutil
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from baselines.learned import policy_file
from baselines.learned.policy_file import SUFFIX
from baselines.rollout.files import write
from train.config import PRESETS, Config
from train.run import BEST
from train.sb3 import export, ppo


@dataclass(frozen=True)
class Training:
    """One training of the recipe.

    Attributes:
        config: of the run, but for its seed, its folder and where it begins.
        after: name of the training with whose best policy it begins; None for one that has none.
        takes_over: name of an approach; pushes then begin where that and the training before
            have brought the vessel into closure.
    """

    config: Config
    after: str | None = None
    takes_over: str | None = None


APPROACH, OF_FOUR = "approach", "approach-four"
"""The trainings that approach: that of ``approach.npz``, of all teams, and that of four boats."""
PAIRS = ((APPROACH, "push-teams", None), (OF_FOUR, "push-finely", 4))
"""Trainings of the networks of ``transport.npz``, and the team that has them for itself."""
PATIENCE = 34.0
"""Time after which a push is given up, s for a vessel of 0.40 m."""
FIRST = replace(
    PRESETS["push"],
    mirror=True,
    near_goals=0.15,
    widening=0.03,
    time_limit=45.0,
    imitation_rounds=0,
    critic_updates=0,
    num_envs=64,
    num_steps=128,
    update_epochs=3,
    gamma=0.99,
    actor_learning_rate=3e-4,
    anneal_lr=False,
    log_std_init=-0.7,
    log_std_min=-1.7,
    ent_coef=0.002,
    until_wide=True,
    total_timesteps=200_000_000,
)
"""Of a push, from nothing: until it comes to all goals, which the others do not teach."""
LATER = replace(
    FIRST,
    scenarios=("noisy", "nominal", "mismatch", "gyre"),
    midway_starts=0.5,
    near_goals=0.25,
    widening=0.0,
    until_wide=False,
    critic_updates=10,
    ent_coef=0.001,
)
"""Of one that has been learned."""
TO_SLOTS = replace(
    PRESETS["approach"],
    near_starts=0.25,
    slot_starts=0.15,
    time_limit=60.0,
    gamma=0.98,
    log_std_init=-2.7,
    total_timesteps=10_000_000,
)
"""Of an approach."""
TRAININGS = {
    APPROACH: Training(
        replace(
            TO_SLOTS,
            teams=(2, 3, 4, 4, 6, 8, 12),
            scenarios=("noisy", "nominal", "failure"),
            total_timesteps=12_000_000,
            eval_episodes=40,
        )
    ),
    OF_FOUR: Training(TO_SLOTS),
    "push": Training(FIRST),
    "push-on": Training(
        replace(LATER, log_std_init=-2.1, log_std_min=-2.4, total_timesteps=14_000_000),
        after="push",
        takes_over=OF_FOUR,
    ),
    "push-exactly": Training(
        replace(LATER, log_std_init=-2.6, log_std_min=-3.0, total_timesteps=18_000_000),
        after="push-on",
        takes_over=OF_FOUR,
    ),
    "push-finely": Training(
        replace(
            LATER,
            scenarios=("noisy", "noisy", "noisy", "nominal", "mismatch"),
            midway_starts=0.6,
            log_std_init=-3.3,
            log_std_min=-3.5,
            adapt_kl=0.006,
            num_minibatches=4,
            total_timesteps=8_000_000,
        ),
        after="push-exactly",
        takes_over=OF_FOUR,
    ),
    "push-teams": Training(
        replace(
            LATER,
            teams=(3, 4, 4, 4, 6, 6, 8, 8, 12),
            scenarios=("noisy", "noisy", "mismatch", "failure"),
            hidden=(256, 256),
            num_envs=324,
            num_steps=20,
            time_limit=40.0,
            gamma=0.994,
            log_std_init=-2.4,
            log_std_min=-3.0,
            adapt_kl=0.01,
            total_timesteps=70_000_000,
            eval_every=20_000_000,
            eval_episodes=10,
        ),
        after="push-finely",
        takes_over=APPROACH,
    ),
}
"""The recipe, in the order in which it is followed."""


def follow(seed: int, out: Path, threads: int) -> None:
    """Trains all that is not trained yet, and puts the policy files together.

    Args:
        seed: of the trainings.
        out: folder in which each training has its own.
        threads: of the learner.

    Raises:
        ValueError, OSError: a folder holds something else; see ``train.run.opened``.
    """
    for name, training in TRAININGS.items():
        print(f"{name}: {out / name}", file=sys.stderr)
        config = replace(training.config, seed=seed, out=out / name, torch_threads=threads)
        if training.after is not None:
            config = replace(config, init_from=best(out / training.after))
        if training.after and training.takes_over:
            before = out / f"{training.after}-joined{SUFFIX}"
            if not before.exists():
                join(out, [(training.takes_over, training.after, None)], before)
            config = replace(config, hand_over=before)
        ppo.train(config)
        if config.init_from and not policy_file.read(best(out / name))[1]["timesteps"]:
            print(f"{name}: nothing better than where it began", file=sys.stderr)
    shutil.copyfile(checked(out / APPROACH), out / f"approach{SUFFIX}")
    join(out, PAIRS, out / f"transport{SUFFIX}")


def join(out: Path, pairs: Sequence[tuple[str, str, int | None]], file: Path) -> None:
    """Puts networks that approach and networks that push together.

    Args:
        out: folder of the recipe.
        pairs: names of the training of one of each, and the team that has them for itself.
        file: policy file to be written.

    Raises:
        ValueError: a policy file differs from the network that was trained.
    """
    phases, model_cards = [], []
    for approach, push, team_size in pairs:
        for name, patience in ((approach, None), (push, PATIENCE)):
            phase, model_card = policy_file.read_single(checked(out / name))
            phases.append(replace(phase, patience=patience, team_size=team_size))
            model_cards.append(model_card)
    write(file, lambda part: policy_file.save(part, phases, {"phases": model_cards}))


def checked(run: Path) -> Path:
    """Policy file of the best policy of a run, held against the network that was trained.

    Raises:
        ValueError: it differs.
    """
    export.check(best(run), export.trained(run))
    return best(run)


def best(run: Path) -> Path:
    """Policy file of the best policy of a run."""
    return run / f"{BEST}{SUFFIX}"


def main(arguments: Sequence[str] | None = None) -> None:
    """Follows the recipe as a command line says; exits with a message where it does not go."""
    parser = argparse.ArgumentParser(prog="python -m train.recipe", description=__doc__)
    parser.add_argument("--seed", type=int, default=0, help="of the trainings (%(default)s)")
    parser.add_argument("--out", type=Path, help="folder (runs/train/recipe-SEED)")
    parser.add_argument("--torch-threads", type=int, default=2, help="(%(default)s)")
    options = parser.parse_args(arguments)
    out = options.out or Path(f"runs/train/recipe-{options.seed}")
    try:
        follow(options.seed, out, options.torch_threads)
    except (ValueError, OSError) as error:
        parser.error(str(error))
    except KeyboardInterrupt:
        sys.exit(f"{parser.prog}: stopped; the same command goes on from the last checkpoint")


if __name__ == "__main__":
    main()
