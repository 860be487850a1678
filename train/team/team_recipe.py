"""Trains one policy for all teams, hulls and waters: ``python -m train.team --seed 0``.

Its only stage is imitation, see ``team_imitation``. The same command resumes where it was stopped,
and ends with the same policy. The folder holds ``policy.npz``, the policy with averaged weights;
``curve.csv``, its success on development seeds; and ``checkpoint.pt``, with what was seen in each
round until the end.
"""

import sys
import time
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import torch
import tyro
from tqdm import tqdm

from asv_env.checks import check_whole
from asv_env.files import write
from baselines.learned import team_policy
from baselines.learned.team_policy import TeamPolicy
from baselines.rollout import runner, seeds
from baselines.rollout.commands import FilePath, command
from baselines.rollout.lock import locked
from train import evaluation
from train.evaluation import Score
from train.team.team_imitation import Block, Imitation, Kind, Rounds

SEEDS_PER_RUN = 10**6  #: number of training seeds that each run has for itself
POLICY, CURVE, CHECKPOINT, ROUND = "policy.npz", "curve.csv", "checkpoint.pt", "round-{}.pt"
EVALUATED = (
    Kind(),
    Kind(scenario="nominal"),
    Kind(scenario="gyre"),
    Kind(num_boats=3),
    Kind(num_boats=8),
    Kind(vessel="square"),
    Kind(vessel="L"),
    Kind("approach"),
)
"""Kinds of worlds of the curve, as far as the run has them."""


@dataclass(frozen=True)
class Options:
    """Trains one policy for all teams, hulls and waters; the same command resumes."""

    seed: int = 0  #: of the run; the seeds of its worlds follow from it
    out: FilePath | None = None  #: folder of the run; by default runs/train/team-SEED
    imitation: Annotated[Rounds, tyro.conf.arg(name="")] = field(default_factory=Rounds)
    every: int = 4  #: rounds between evaluations
    episodes: int = 50  #: episodes of each kind of worlds in an evaluation
    torch_threads: int = 1  #: threads of the learner

    def __post_init__(self) -> None:
        check_whole(self, "seed", 0)
        check_whole(self, "every episodes torch_threads", 1, 10**6)


def follow(options: Annotated[Options, tyro.conf.arg(name="")]) -> None:
    """Trains, from the beginning or from the last round of the run.

    Raises:
        ValueError, OSError: the folder holds a run of other options, or cannot be used.
    """
    first = seeds.TRAINING.start + options.seed * SEEDS_PER_RUN
    seeds.check(range(first, first + SEEDS_PER_RUN), "training")
    out = options.out or Path(f"runs/train/team-{options.seed}")
    torch.set_num_threads(options.torch_threads)
    with locked(out):
        imitation, seconds = Imitation(options.imitation, first), 0.0
        if (out / CHECKPOINT).exists():
            seconds = _resume(imitation, out)
        rounds = options.imitation.rounds
        with tqdm(total=rounds, initial=imitation.round, unit=" round", file=sys.stderr) as bar:
            while imitation.round < rounds:
                began = time.monotonic()
                loss = imitation.advance()
                seconds += time.monotonic() - began
                bar.set_postfix_str(f"loss {loss:.4f}", refresh=False)
                bar.update()
                _keep(imitation, seconds, out)
                if imitation.round % options.every == 0:
                    _evaluate(imitation, seconds, options, out)
        _evaluate(imitation, seconds, options, out)
        for file in out.glob(ROUND.format("*")):
            file.unlink()


def _keep(imitation: Imitation, seconds: float, out: Path) -> None:
    """Writes what the round has seen, then the checkpoint."""
    new = [tuple(block) for block in imitation.blocks[-imitation.options.kinds :]]
    write(out / ROUND.format(imitation.round), partial(torch.save, new))
    kept = {"options": _asked(imitation), "seconds": seconds, **imitation.state()}
    write(out / CHECKPOINT, partial(torch.save, kept))


def _asked(imitation: Imitation) -> dict[str, Any]:
    """Returns all that decides what is learned."""
    return {"first seed": imitation.first_seed, **asdict(imitation.options)}


def _resume(imitation: Imitation, out: Path) -> float:
    """Continues a run; returns the seconds that it took so far."""
    kept = torch.load(out / CHECKPOINT, weights_only=True)
    if kept["options"] != (asked := _asked(imitation)):
        name = next(name for name in asked if kept["options"].get(name) != asked[name])
        raise ValueError(
            f"{out}: its run has {name} = {kept['options'].get(name)!r}, not {asked[name]!r}: "
            "choose another folder with --out"
        )
    resumes = kept["round"] < imitation.options.rounds
    files = [out / ROUND.format(n + 1) for n in range(kept["round"] if resumes else 0)]
    stored = (block for file in files for block in torch.load(file, weights_only=True))
    imitation.restore(kept, (Block(*block) for block in stored))
    return float(kept["seconds"])


def _evaluate(imitation: Imitation, seconds: float, options: Options, out: Path) -> None:
    """Adds the success of the averaged policy to the curve, and writes it, if it is a new one."""
    decisions = imitation.decisions
    if evaluation.last_timesteps(out / CURVE) >= decisions:
        return
    weights, first = imitation.averaged.weights(), seeds.DEVELOPMENT.start
    scores: list[Score] = []
    for kind in filter(options.imitation.has, EVALUATED):
        params, count = kind.params, options.episodes
        logs = runner.run(partial(TeamPolicy, weights), params, range(first, first + count), count)
        episodes = [log.episode for log in logs]
        name = kind.scenario if kind.vessel == "plank" else f"{kind.scenario}, {kind.vessel}"
        name = name if kind.task == "transport" else f"{kind.task}, {name}"
        scores.append(evaluation.score(episodes, params, name, decisions, seconds))
    card = {"options": asdict(options.imitation), "development": [vars(one) for one in scores]}
    team_policy.save(out / POLICY, weights, card)
    evaluation.append_to_curve(out / CURVE, scores)


main = command(follow, "python -m train.team")
