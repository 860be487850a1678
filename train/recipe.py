"""Trains the policy `learned`: ``python -m train.recipe --seed 0``.

One policy for all teams, hulls, waters and tasks. Its only stage is imitation, see
``train.team.team_imitation``. The same command resumes where it was stopped, and ends with the same
policy. The folder holds ``policy.npz``, the policy with averaged weights and its model card;
``curve.csv``, its success on development seeds; and ``checkpoint.pt``, with what was seen in each
round until the end.
"""

import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, fields
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import tyro

from asv_env.checks import check_whole
from asv_env.files import write
from baselines.learned import team_policy
from baselines.learned.team_policy import TeamPolicy
from baselines.rollout import extras, seeds
from baselines.rollout.commands import FilePath, command

PROGRAM = "python -m train.recipe"
with extras.needed(PROGRAM):
    import torch
    from tqdm import tqdm

    from baselines.rollout import runner
    from baselines.rollout.lock import locked
    from train import evaluation
    from train.config import SEEDS_PER_RUN
    from train.evaluation import Score
    from train.run import COMMON, software
    from train.team.team_imitation import Block, Imitation, Kind, Rounds

POLICY, CURVE, CHECKPOINT, ROUND = "policy.npz", "curve.csv", "checkpoint.pt", "round-{}.pt"
EVALUATED = (
    Kind(),
    Kind(scenario="nominal"),
    Kind(scenario="gyre"),
    Kind(num_boats=3),
    Kind(num_boats=8),
    Kind(vessel="square"),
    Kind(vessel="L"),
    Kind("push"),
    Kind("approach"),
)
"""Kinds of worlds of the curve, as far as the run has them."""


@dataclass(frozen=True)
class Options:
    """Trains one policy for all teams, hulls, waters and tasks; the same command resumes."""

    seed: int = 0  #: of the run; the seeds of its worlds follow from it
    out: FilePath | None = None  #: folder of the run; by default runs/train/recipe-SEED
    imitation: Annotated[Rounds, tyro.conf.arg(name="")] = field(default_factory=Rounds)
    every: int = 4  #: rounds between evaluations
    episodes: int = 50  #: episodes of each kind of worlds in an evaluation
    torch_threads: int = 1  #: threads of the learner

    def __post_init__(self) -> None:
        check_whole(self, "seed", 0)
        check_whole(self, "every episodes torch_threads", 1, 10**6)
        seeds.check(self.seeds, "training")
        rounds, kinds, boats = (getattr(self.imitation, n) for n in ("rounds", "kinds", "boats"))
        if rounds * kinds * boats > SEEDS_PER_RUN:
            raise ValueError(
                f"rounds = {rounds} of {kinds} kinds of worlds with {boats} boats each need "
                f"{rounds * kinds * boats:,} seeds, a run has {SEEDS_PER_RUN:,}: take fewer of them"
            )

    @property
    def seeds(self) -> range:
        """Seeds of the worlds of the run."""
        first = seeds.TRAINING.start + self.seed * SEEDS_PER_RUN
        return range(first, first + SEEDS_PER_RUN)

    @property
    def folder(self) -> Path:
        """Folder of the run."""
        return self.out or Path(f"runs/train/recipe-{self.seed}")

    @property
    def command(self) -> str:
        """The command that trains the same policy."""
        words = [PROGRAM, "--seed", str(self.seed)]
        for option in fields(Rounds):
            value = getattr(self.imitation, option.name)
            if value != option.default:
                listed = value if isinstance(value, tuple) else (value,)
                words += [f"--{option.name.replace('_', '-')}", *map(str, listed)]
        return " ".join(words)


@dataclass
class Progress:
    """What a run keeps beside what it has learned."""

    seconds: float = 0.0  #: time of the training until then, evaluations included, s
    software: list[dict[str, Any]] = field(default_factory=list)
    """Code, libraries and machine; several where a run was resumed with others."""

    def note(self, now: dict[str, Any]) -> None:
        """Notes the software of now, where its code or libraries are others than before."""
        known = [(one["code"], one["libraries"]) for one in self.software]
        if (now["code"], now["libraries"]) not in known:
            self.software.append(now)


def follow(options: Annotated[Options, tyro.conf.arg(name="")]) -> None:
    """Trains, from the beginning or from the last round of the run.

    Raises:
        ValueError, OSError: the folder holds a run of other options, or cannot be used.
    """
    out, progress = options.folder, Progress()
    torch.set_num_threads(options.torch_threads)
    with locked(out):
        imitation = Imitation(options.imitation, options.seeds.start)
        if (out / CHECKPOINT).exists():
            progress = _resume(imitation, out)
        _train(imitation, progress, options)
        for file in out.glob(ROUND.format("*")):
            file.unlink()


def _train(imitation: Imitation, progress: Progress, options: Options) -> None:
    """Trains to the last round."""
    out, rounds = options.folder, options.imitation.rounds
    began = time.monotonic() - progress.seconds
    if imitation.round < rounds:
        progress.note(software(COMMON))
    with tqdm(total=rounds, initial=imitation.round, unit=" round", file=sys.stderr) as bar:
        while imitation.round < rounds:
            loss = imitation.advance()
            progress.seconds = time.monotonic() - began
            bar.set_postfix_str(f"loss {loss:.4f}", refresh=False)
            bar.update()
            _keep(imitation, progress, out)
            if imitation.round % options.every == 0:
                _evaluate(imitation, progress, options)
    _evaluate(imitation, progress, options)


def _keep(imitation: Imitation, progress: Progress, out: Path) -> None:
    """Writes what the round has seen, then the checkpoint."""
    new = [tuple(block) for block in imitation.blocks[-imitation.options.kinds :]]
    write(out / ROUND.format(imitation.round), partial(torch.save, new))
    kept = {"options": _asked(imitation), **vars(progress), **imitation.state()}
    write(out / CHECKPOINT, partial(torch.save, kept))


def _asked(imitation: Imitation) -> dict[str, Any]:
    """Returns all that decides what is learned."""
    return {"first seed": imitation.first_seed, **asdict(imitation.options)}


def _resume(imitation: Imitation, out: Path) -> Progress:
    """Continues a run; returns its progress."""
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
    return Progress(kept["seconds"], kept["software"])


def _evaluate(imitation: Imitation, progress: Progress, options: Options) -> None:
    """Adds the success of the averaged policy to the curve, and writes it, if it is a new one."""
    curve, decisions = options.folder / CURVE, imitation.decisions
    if evaluation.last_timesteps(curve) >= decisions:
        return
    weights, first = imitation.averaged.weights(), seeds.DEVELOPMENT.start
    kinds = list(filter(options.imitation.has, EVALUATED))
    scores: list[Score] = []
    for kind in kinds:
        params, count = kind.params, options.episodes
        logs = runner.run(partial(TeamPolicy, weights), params, range(first, first + count), count)
        episodes = [log.episode for log in logs]
        scores.append(evaluation.score(episodes, params, _named(kind), decisions, progress.seconds))
    card = _model_card(imitation, progress, options, kinds, scores)
    team_policy.save(options.folder / POLICY, weights, card)
    evaluation.append_to_curve(curve, scores)


def _named(kind: Kind) -> str:
    """Returns the name of a kind of worlds in the curve, which has the team beside it."""
    usual = Kind()
    words = [(kind.task, usual.task), (kind.scenario, None), (kind.vessel, usual.vessel)]
    return ", ".join(word for word, default in words if word != default)


def _model_card(
    imitation: Imitation,
    progress: Progress,
    options: Options,
    kinds: Sequence[Kind],
    scores: Sequence[Score],
) -> dict[str, Any]:
    """Returns where the policy comes from, and its scores."""
    pairs = zip(kinds, scores, strict=True)
    return {
        "command": options.command,
        "options": asdict(options.imitation),
        "rounds": imitation.round,
        "decisions": imitation.decisions,
        "training_seeds": [options.seeds.start, options.seeds.stop - 1],
        **asdict(progress),
        "development": [vars(score) | vars(kind) for kind, score in pairs],
    }


main = command(follow, PROGRAM)

if __name__ == "__main__":
    main()
