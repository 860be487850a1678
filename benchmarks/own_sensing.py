"""What boats lose that see for themselves: ``python benchmarks/own_sensing.py``.

Each disturbance of the sensors is run with one measurement that the team shares, and with one of
each boat, on the same seeds for development. A study that was stopped resumes where it was.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro

from asv_env.presets import NOISE
from baselines.evaluate import compare
from baselines.evaluate.api import Comparison
from baselines.evaluate.conditions import CUSTOM, Condition, Suite
from baselines.evaluate.publish import marks
from baselines.reproduce.artefact import markdown
from baselines.rollout import seeds
from baselines.rollout.commands import FilePath, command, say

START, END = "<!-- own sensing -->", "<!-- own sensing: up to here -->"
POLICIES = {name: name for name in ("scripted", "allocation", "paper-tuned")}
UNFILTERED = {"unfiltered": "baselines.scripted.scripted_policy:unfiltered"}
"""The scripted policy on the latest measurements as they are; it is run with noise alone."""
RANGES = (1.0, 0.5, 0.3)  #: m
DISTURBANCES: dict[str, dict[str, Any]] = {
    "exact": {},
    "noise": NOISE,
    "double noise": {name: 2 * deviation for name, deviation in NOISE.items()},
    "noise, delay 0.2 s": {**NOISE, "delay": 0.2},
    "noise, delay 0.4 s": {**NOISE, "delay": 0.4},
    "noise, dropout 0.5": {**NOISE, "dropout": 0.5},
    **{f"noise, range {reach:g} m": {**NOISE, "range": reach} for reach in RANGES},
    "noise, range 1 m, delay 0.2 s, dropout 0.1": {
        **NOISE,
        **{"range": 1.0, "delay": 0.2, "dropout": 0.1},
    },
}
"""Sensors by name; the noise is that of the scenario `noisy`."""


@dataclass(frozen=True)
class Options:
    """Writes a table of successes with shared sensors and with those of each boat."""

    out: FilePath = Path("runs/own-sensing")  #: folder of the episodes
    page: FilePath | None = None  #: page whose table is replaced, such as docs/sensing.md
    task: str = "transport"  #: task of all conditions
    time_limit: float = 240.0  #: of an episode, s
    episodes: int = 40  #: number of episodes of each condition
    seed: int = seeds.DEVELOPMENT.start  #: seed of the first episode
    workers: int = 0  #: number of processes besides this one


def conditions(options: Options) -> Iterator[Condition]:
    """Yields the conditions; what has a range is not shared, and what is exact is the same."""
    world = {"delivery": "passing", "time_limit": options.time_limit}
    for name, sensors in DISTURBANCES.items():
        for shared in (True, False):
            if "range" in sensors if shared else not sensors:
                continue
            own = {"sensors": {**sensors, "shared": shared}}
            yield Condition(key(name, shared), name, task=options.task, options={**world, **own})


def key(name: str, shared: bool) -> str:
    """Returns the name of the condition of a disturbance."""
    return f"{name}, {'shared' if shared else 'own'}"


def table(*studies: Comparison) -> str:
    """Returns the successes of several comparisons as Markdown, in percent."""
    found = {
        (condition, policy): one["success"]["value"]
        for study in studies
        for condition, entry in study.summary["conditions"].items()
        for policy, one in entry["policies"].items()
    }
    rows = []
    for name in DISTURBANCES:
        row: dict[str, Any] = {"sensors": name}
        for policy in {**POLICIES, **UNFILTERED}:
            for shared in (True, False):
                share = found.get((key(name, shared), policy))
                text = None if share is None else f"{share:.0%}"
                row[f"{policy}, {'shared' if shared else 'own'}"] = text
        rows.append(row)
    suite = studies[0].results.suite
    note = f"{suite.episodes} episodes each, seeds from {suite.seed} on."
    return markdown({"rows": rows, "notes": [note]})


def study(options: Annotated[Options, tyro.conf.arg(name="")]) -> None:
    """Runs the conditions and writes their table.

    Raises:
        ValueError: seeds for another purpose, or a page without a place for the table.
    """
    seeds.check(range(options.seed, options.seed + options.episodes), "development")
    text = None
    if options.page is not None:
        text = marks.read(options.page)
        marks.check(text, START, END)
    chosen = tuple(conditions(options))
    noisy = tuple(one for one in chosen if one.about == "noise")

    def run(policies: dict[str, str], conditions: tuple[Condition, ...]) -> Comparison:
        suite = Suite(CUSTOM, "Boats that see for themselves.", conditions, options.seed)
        out = options.out / next(iter(policies))
        return compare(policies, suite, options.episodes, out, workers=options.workers, replays=0)

    found = table(run(POLICIES, chosen), run(UNFILTERED, noisy))
    say(found)
    if options.page is not None and text is not None:
        options.page.write_text(marks.replaced(text, START, END, found), encoding="utf-8")


main = command(study, "python benchmarks/own_sensing.py")

if __name__ == "__main__":
    main()
