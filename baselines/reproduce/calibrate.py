"""Fits disturbances to the paper's tank experiment: ``python -m baselines.reproduce.calibrate``.

The paper gives two moments of two errors over twelve trials: the mean and the standard deviation of
the smallest distance to the goal and of the heading error at that instant. Noise, mismatch and bias
of the motors, and latencies are fitted to all four. Then each is tried alone in several strengths,
and each is left out of the fit.

The fit is by successive halving (Jamieson and Talwalkar, AISTATS 2016): candidates, most of them
drawn at random, are tried a few times each, and the best of them oftener, on other seeds.
"""

import json
import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
import tyro
from tqdm import tqdm

from asv_env.checks import check_whole
from asv_env.files import write_text
from asv_env.presets import NOISE, PRESETS
from baselines.evaluate.publish import marks
from baselines.paper.paper_numbers import PAPER_HEADING, PAPER_POSITION, PAPER_TRIALS
from baselines.policy import POLICIES
from baselines.reproduce import paper_page
from baselines.reproduce.artefact import markdown
from baselines.reproduce.comparison_rows import describe
from baselines.reproduce.paper_environments import episodes, experiment
from baselines.rollout import seeds
from baselines.rollout.commands import FilePath, command
from baselines.rollout.lock import locked
from baselines.rollout.score_log import ScoreLog

PROGRAM = "python -m baselines.reproduce.calibrate"
NAME = "calibration"
PRINTED = {"distance": PAPER_POSITION, "heading": PAPER_HEADING}  #: cm, rad
WITHIN = 2.0  #: standard errors within which a moment fits the paper's
IN_RANGE = 20.0  #: distance within which a trial counts, cm: the motors are turned off there
HZ = PRESETS["experiment"]["clock"]["control"]  #: control ticks a second
UNFIT = 1e3  #: misfit where less than half of the trials count


@dataclass(frozen=True)
class Disturbances:
    """What may distinguish the tank from the nominal world; the defaults are nominal."""

    noise: float = 0.0  #: noise of the measurement, relative to that of the scenario "noisy"
    mismatch: float = 0.0  #: largest relative difference of each motor's thrust
    bias: float = 0.0  #: relative difference of all right motors, and its opposite of all left ones
    sensing_latency: int = 0  #: control ticks
    actuation_latency: int = 0  #: control ticks

    @classmethod
    def sample(cls, rng: np.random.Generator) -> Self:
        """Returns random disturbances within ``BOUNDS``, each of them absent in half the cases."""
        noise, mismatch, bias, *latencies = (
            rng.uniform(*bounds) if rng.random() < 0.5 else 0.0 for bounds in BOUNDS.values()
        )
        return cls(round(noise, 2), round(mismatch, 2), round(bias, 2), *map(round, latencies))

    def overrides(self) -> dict[str, Any]:
        """Returns the parameters that differ in a preset with them, by section."""
        sensors = {name: round(self.noise * deviation, 6) for name, deviation in NOISE.items()}
        sections = {
            "sensors": {**sensors, "delay": self.sensing_latency / HZ},
            "variation": {
                "thrust": self.mismatch,
                "thrust_bias": self.bias,
                "actuation_delay": self.actuation_latency / HZ,
            },
        }
        differing = {
            section: {name: value for name, value in values.items() if value}
            for section, values in sections.items()
        }
        return {section: values for section, values in differing.items() if values}


BOUNDS = {
    "noise": (0.0, 2.0),
    "mismatch": (0.0, 0.6),
    "bias": (-0.2, 0.2),
    "sensing_latency": (0.5, 3.5),
    "actuation_latency": (0.5, 3.5),
}
"""Least and largest disturbances that are tried, in the units of ``Disturbances``."""
SWEEP: dict[str, tuple[Any, ...]] = {
    "noise": (0.5, 1.0, 2.0),
    "mismatch": (0.15, 0.3, 0.5),
    "bias": (-0.2, -0.1, 0.1, 0.2),
    "sensing_latency": (1, 3),
    "actuation_latency": (1, 3),
}
"""Strengths in which each is tried alone."""
KEEP = 4  #: one in so many candidates is tried again, as many times as often


@dataclass(frozen=True)
class Options:
    """How long is searched, and where the results are written."""

    random: int = 48  #: number of random candidates, besides each disturbance alone
    trials: int = 12  #: trials of each candidate in the first round
    checked: int = 64  #: trials of each row of the table
    seed: int = seeds.DEVELOPMENT.start  #: first seed of the trials
    out: FilePath = Path("runs/calibrate")  #: folder of the scores and the table
    page: FilePath | None = None  #: page that receives the table as well, between its marks

    def __post_init__(self) -> None:
        check_whole(self, "random trials checked", 1)
        seeds.check(range(self.seed, self.rounds[-1][1].stop + self.checked), "development")
        if self.page is not None:
            paper_page.check(marks.read(self.page), [NAME])

    @property
    def rounds(self) -> list[tuple[int, range]]:
        """Number of candidates of each round, and the seeds of their trials."""
        found: list[tuple[int, range]] = []
        number, count, first = len(alone()) + self.random, self.trials, self.seed
        while number > 1 or not found:
            found.append((number, range(first, first + count)))
            first, number, count = first + count, number // KEEP, count * KEEP
        return found


def trials(disturbances: Disturbances, wanted: Sequence[int], what: str) -> list[dict[str, Any]]:
    """Returns trials of the experiment with these disturbances."""
    params = experiment(**disturbances.overrides())
    return episodes(POLICIES["paper"], params, wanted, what)


def moments(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Returns number and moments of the trials that count: those that came in range.

    Distances in cm, headings in rad; moments are None where too few count.
    """
    errors = [
        (100 * row["min_position_error"], row["heading_error_at_min"])
        for row in rows
        if row["time_to_closure"] is not None and 100 * row["min_position_error"] < IN_RANGE
    ]
    distance, heading = (describe([error[k] for error in errors]) for k in (0, 1))
    return {"trials": len(rows), "in range": len(errors), "distance": distance, "heading": heading}


def deviations(found: Mapping[str, Any], name: str) -> tuple[float, float]:
    """Returns by how much two moments differ from the paper's, in the tank's standard errors.

    A mean of n trials has the standard error s / sqrt(n), a standard deviation s that of
    s / sqrt(2 (n - 1)), where errors are normal. ``name`` is "distance" or "heading".
    """
    (mean, deviation), n = PRINTED[name], PAPER_TRIALS
    off_mean = (found[name]["mean"] - mean) / (deviation / math.sqrt(n))
    off_deviation = (found[name]["sd"] - deviation) / (deviation / math.sqrt(2 * (n - 1)))
    return off_mean, off_deviation


def counts(found: Mapping[str, Any]) -> bool:
    """Returns whether at least half of the trials came in range."""
    return bool(found["in range"] >= max(2, found["trials"] / 2))


def misfit(found: Mapping[str, Any]) -> float:
    """Returns the sum of the four squared deviations from the paper's moments."""
    if not counts(found):
        return UNFIT
    return sum(off**2 for name in PRINTED for off in deviations(found, name))


def yields(found: Mapping[str, Any], name: str) -> bool:
    """Returns whether both moments of an error lie within two standard errors of the paper's."""
    return counts(found) and all(abs(off) <= WITHIN for off in deviations(found, name))


def fitted(options: Options, log: ScoreLog) -> Disturbances:
    """Returns the disturbances whose moments are nearest to the paper's."""
    rng = np.random.default_rng(options.seed)
    candidates = [*alone().values(), *(Disturbances.sample(rng) for _ in range(options.random))]
    total = sum(number for number, _ in options.rounds)
    with tqdm(total=total, unit="candidate", file=sys.stderr) as bar:
        for number, wanted in options.rounds:
            scores = {}
            for one in candidates[:number]:
                scores[one] = log.score(f"{one} {wanted}", partial(_score, one, wanted))
                bar.update()
            candidates = sorted(scores, key=lambda one: -scores[one])
            bar.set_postfix(misfit=f"{-scores[candidates[0]]:.1f}")
    return candidates[0]


def _score(candidate: Disturbances, wanted: Sequence[int]) -> float:
    return -misfit(moments(trials(candidate, wanted, "trials")))


def alone() -> dict[str, Disturbances]:
    """Returns each disturbance alone in several strengths."""
    return {
        f"{_words(name)} {strength:g} alone": Disturbances(**{name: strength})
        for name, strengths in SWEEP.items()
        for strength in strengths
    }


def variants(found: Disturbances) -> dict[str, Disturbances]:
    """Returns no disturbances, those found, all but each of them, and each alone."""
    names = [name for name, value in asdict(found).items() if value]
    if len(names) == 1:  # without it there is none left
        names = []
    without = {f"fitted without {_words(name)}": replace(found, **{name: 0}) for name in names}
    return {"undisturbed": Disturbances(), "fitted": found, **without, **alone()}


def _words(name: str) -> str:
    return name.replace("_", " ")


def table(found: Disturbances, measured: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Returns the rows of the paper and of the variants, by their ``moments``, and notes."""
    printed: dict[str, Any] = {"trials": PAPER_TRIALS, "in range": None}
    printed |= {name: {"mean": mean, "sd": sd} for name, (mean, sd) in PRINTED.items()}
    rows = [_row("tank experiment (paper)", printed, None)]
    rows += [_row(name, one, misfit(one)) for name, one in measured.items()]
    values = ", ".join(f"{_words(name)} {value:g}" for name, value in asdict(found).items())
    mean, deviation = PAPER_HEADING
    able = [name for name, one in measured.items() if yields(one, "heading")]
    both = [name for name in able if yields(measured[name], "distance")]
    notes = [
        f"Fitted: {values}. Noise is relative to that of the scenario `noisy`, mismatch is the "
        "largest relative difference of each motor's thrust, bias is how much stronger all right "
        "and weaker all left motors are, latencies are in control ticks of 0.1 s. Policy `paper`, "
        f"preset `experiment`; trials that came within {IN_RANGE:g} cm of the goal count. Misfit: "
        "sum of the squared deviations of the four moments, in standard errors of twelve trials; "
        "4 is expected of the truth itself. A dash: less than half of the trials count.",
        f"A heading error of {mean:g} ± {deviation:g} rad, both moments within {WITHIN:g} standard "
        f"errors, comes with: {_listed(able)}. The distance fits as well with: {_listed(both)}. "
        "All other rows do not yield it.",
    ]
    return {"rows": rows, "notes": notes}


def _listed(names: Sequence[str]) -> str:
    return "; ".join(names) if names else "none of them"


def _row(name: str, found: Mapping[str, Any], error: float | None) -> dict[str, Any]:
    def spread(moment: Mapping[str, Any]) -> str | None:
        parts = (moment["mean"], moment["sd"])
        return None if None in parts else " ± ".join(f"{part:.2f}" for part in parts)

    return {
        "world": name,
        "trials": found["trials"],
        "in range": found["in range"],
        "distance (cm)": spread(found["distance"]),
        "heading (rad)": spread(found["heading"]),
        "misfit": None if error == UNFIT else error,
    }


def calibrate(options: Annotated[Options, tyro.conf.arg(name="")]) -> None:
    """Fit disturbances to the paper's tank experiment, and show which of them its errors need.

    Repeat the command to continue a search that was stopped. The fit is to be entered as
    ``CALIBRATED`` in ``asv_env.presets``, as printed.

    Raises:
        ValueError, OSError: seeds for another purpose, or a file cannot be used.
    """
    with locked(options.out):
        log = ScoreLog(options.out / "scores.jsonl", "baselines.reproduce.calibrate")
        found = fitted(options, log)
        first = options.rounds[-1][1].stop
        wanted = range(first, first + options.checked)
        each = partial(trials, wanted=wanted)
        measured = {n: moments(each(one, what=n)) for n, one in variants(found).items()}
        product = table(found, measured)
        tried = {"random": options.random, "trials": options.trials, "seed": options.seed}
        fit = {"options": tried, "fitted": asdict(found), "calibrated": found.overrides()}
        result = {**fit, "measured": measured, **product}
        write_text(options.out / f"{NAME}.json", json.dumps(result, indent=2) + "\n")
        write_text(options.out / f"{NAME}.md", markdown(product))
        if options.page is not None:
            text = marks.read(options.page)
            write_text(options.page, paper_page.updated(text, options.out, [NAME]))
    print(f"CALIBRATED = {found.overrides()}")


main = command(calibrate, PROGRAM)

if __name__ == "__main__":
    main()
