"""Fits disturbances to the paper's tank experiment: ``python -m baselines.reproduce.calibrate``.

The paper gives two moments of two errors over twelve trials: the mean and the standard deviation of
the smallest distance to the goal and of the heading error at that instant. Noise, mismatch and bias
of the motors, and latencies are fitted to all four, and then each is tried alone, and left out.
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
from asv_env.presets import NOISE
from asv_env.types import Float
from baselines.evaluate.publish import marks
from baselines.paper.paper_numbers import PAPER_HEADING, PAPER_POSITION, PAPER_TRIALS
from baselines.policy import POLICIES
from baselines.reproduce import paper_page
from baselines.reproduce.artefact import markdown
from baselines.reproduce.comparison_rows import describe
from baselines.reproduce.paper_environments import episodes, experiment
from baselines.rollout import seeds
from baselines.rollout.commands import FilePath, command
from baselines.rollout.cross_entropy import search
from baselines.rollout.lock import locked
from baselines.rollout.score_log import ScoreLog

PROGRAM = "python -m baselines.reproduce.calibrate"
NAME = "calibration"
IN_RANGE = 20.0  #: distance within which a trial counts, cm: the motors are turned off there
UNFIT = 1e3  #: misfit where less than half of the trials count
MOST_TICKS = 10  #: largest latency that is tried, control ticks


@dataclass(frozen=True)
class Disturbances:
    """What may distinguish the tank from the nominal world; the defaults are nominal."""

    noise: float = 0.0  #: noise of the measurement, relative to that of the scenario "noisy"
    mismatch: float = 0.0  #: largest relative difference of each motor's thrust
    bias: float = 0.0  #: relative difference of all right motors, and its opposite of all left ones
    sensing_latency: int = 0  #: control ticks
    actuation_latency: int = 0  #: control ticks

    @classmethod
    def of_vector(cls, vector: Float) -> Self:
        """Returns the disturbances nearest to a vector (5,) of the search, two digits each."""
        noise, mismatch, bias, *latencies = vector.tolist()
        ticks = (min(max(round(latency), 0), MOST_TICKS) for latency in latencies)
        bounded = (max(noise, 0.0), min(max(mismatch, 0.0), 0.9), min(max(bias, -0.5), 0.5))
        return cls(*(round(value, 2) for value in bounded), *ticks)

    def overrides(self) -> dict[str, Any]:
        """Returns the sections of parameters that a preset with them has."""
        sensors = {name: round(self.noise * deviation, 6) for name, deviation in NOISE.items()}
        return {
            "sensors": {**sensors, "latency": self.sensing_latency},
            "variation": {
                "thrust": self.mismatch,
                "thrust_bias": self.bias,
                "actuation_latency": self.actuation_latency,
            },
        }


BEGIN, SPREAD = (0.5, 0.25, 0.0, 1.0, 1.0), (0.3, 0.15, 0.1, 1.5, 1.5)
"""Mean and standard deviation of the first candidates, in the order of ``Disturbances``."""


@dataclass(frozen=True)
class Options:
    """How long is searched, and where the results are written."""

    generations: int = 6  #: generations of the search
    population: int = 10  #: candidates of a generation
    elite: int = 4  #: candidates of a generation to which the next one is fitted
    trials: int = 48  #: trials of a candidate
    checked: int = 96  #: trials of each row of the table
    seed: int = seeds.DEVELOPMENT.start  #: first seed of the trials
    out: FilePath = Path("runs/calibrate")  #: folder of the scores and the table
    page: FilePath | None = None  #: page that receives the table as well, between its marks

    def __post_init__(self) -> None:
        check_whole(self, "generations population trials checked", 1)
        check_whole(self, "elite", 2, self.population - 1)
        count = self.generations * self.trials + self.checked
        seeds.check(range(self.seed, self.seed + count), "development")
        if self.page is not None:
            paper_page.check(marks.read(self.page), [NAME])


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


def misfit(found: Mapping[str, Any]) -> float:
    """Returns the sum of squared deviations from the paper's moments, in its standard errors.

    A mean of n trials has the standard error s / sqrt(n), a standard deviation s that of
    s / sqrt(2 (n - 1)), where errors are normal.
    """
    if found["in range"] < max(2, found["trials"] / 2):
        return UNFIT
    total, n = 0.0, PAPER_TRIALS
    for name, (mean, deviation) in (("distance", PAPER_POSITION), ("heading", PAPER_HEADING)):
        total += ((found[name]["mean"] - mean) / (deviation / math.sqrt(n))) ** 2
        total += ((found[name]["sd"] - deviation) / (deviation / math.sqrt(2 * (n - 1)))) ** 2
    return total


def fitted(options: Options, log: ScoreLog) -> Disturbances:
    """Returns the disturbances whose moments are nearest to the paper's."""
    with tqdm(total=options.generations * options.population, file=sys.stderr) as bar:

        def objective(vector: Float) -> float:
            candidate = Disturbances.of_vector(vector)
            first = options.seed + bar.n // options.population * options.trials
            wanted = range(first, first + options.trials)

            def compute() -> float:
                return -misfit(moments(trials(candidate, wanted, "candidate")))

            score = log.score(f"{candidate} {wanted}", compute)
            bar.update()
            bar.set_postfix(misfit=f"{-score:.1f}")
            return score

        numbers = options.generations, options.population, options.elite
        rng = np.random.default_rng(options.seed)
        found = search(objective, np.array(BEGIN), np.array(SPREAD), rng, *numbers)
    return Disturbances.of_vector(found)


def variants(found: Disturbances) -> dict[str, Disturbances]:
    """Returns the disturbances found, each of them alone, and all but each."""
    names = [name for name, value in asdict(found).items() if value]
    alone = {name: Disturbances(**{name: getattr(found, name)}) for name in names}
    without = {name: replace(found, **{name: 0}) for name in names}
    return {
        "undisturbed": Disturbances(),
        "fitted": found,
        **{f"{_words(name)} alone": one for name, one in alone.items()},
        **{f"without {_words(name)}": one for name, one in without.items()},
    }


def _words(name: str) -> str:
    return name.replace("_", " ")


def table(found: Disturbances, measured: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Returns the rows of the paper and of the variants, by their ``moments``, and notes."""
    printed = {
        "trials": PAPER_TRIALS,
        "in range": None,
        "distance": dict(zip(("mean", "sd"), PAPER_POSITION, strict=True)),
        "heading": dict(zip(("mean", "sd"), PAPER_HEADING, strict=True)),
    }
    rows = [_row("tank experiment (paper)", printed, None)]
    rows += [_row(name, one, misfit(one)) for name, one in measured.items()]
    values = ", ".join(f"{_words(name)} {value:g}" for name, value in asdict(found).items())
    notes = [
        f"Fitted: {values}. Noise is relative to that of the scenario `noisy`, mismatch is the "
        "largest relative difference of each motor's thrust, bias is how much stronger all right "
        "and weaker all left motors are, latencies are in control ticks of 0.1 s. Policy `paper`, "
        f"preset `experiment`; trials that came within {IN_RANGE:g} cm of the goal count. Misfit: "
        "sum of the squared deviations of the four moments, in standard errors of twelve trials; "
        "4 is expected of the truth itself."
    ]
    return {"rows": rows, "notes": notes}


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
        "misfit": error,
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
        first = options.seed + options.generations * options.trials
        wanted = range(first, first + options.checked)
        each = partial(trials, wanted=wanted)
        measured = {n: moments(each(one, what=n)) for n, one in variants(found).items()}
        product = table(found, measured)
        result = {"fitted": asdict(found), "calibrated": found.overrides(), **product}
        write_text(options.out / f"{NAME}.json", json.dumps(result, indent=2) + "\n")
        write_text(options.out / f"{NAME}.md", markdown(product))
        if options.page is not None:
            text = marks.read(options.page)
            write_text(options.page, paper_page.updated(text, options.out, [NAME]))
    print(f"CALIBRATED = {found.overrides()}")


main = command(calibrate, PROGRAM)

if __name__ == "__main__":
    main()
