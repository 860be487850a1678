"""How often policies succeed where they may be tuned: ``python benchmarks/development.py``.

It runs the conditions of published suites on seeds for development, by either criterion of
delivery. Seeds of the suites themselves are for comparisons alone. A study that was stopped resumes
where it was.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from baselines.evaluate import compare
from baselines.evaluate.api import Comparison
from baselines.evaluate.conditions import CUSTOM, Suite
from baselines.evaluate.publish import marks
from baselines.evaluate.suites import SUITES
from baselines.reproduce.artefact import markdown
from baselines.rollout import seeds
from baselines.rollout.commands import FilePath, command, say

COLUMNS = ("success", "success_low", "success_high", "time_to_goal")
START, END = "<!-- development {} -->", "<!-- development {}: up to here -->"


@dataclass(frozen=True)
class Options:
    """Prints the success of policies in the conditions of suites, on seeds for development."""

    suites: tuple[str, ...] = ("robust-v2",)  #: names of the suites whose conditions are run
    conditions: tuple[str, ...] = ()  #: names of some of their conditions; by default all
    delivery: Literal["holding", "passing"] = "holding"  #: criterion of delivery
    policies: tuple[str, ...] = ("scripted", "allocation")  #: registered names
    episodes: int = 100  #: number of episodes of each condition
    seed: int = seeds.DEVELOPMENT.start  #: seed of the first episode
    workers: int = 1  #: number of processes
    num_envs: int = 250  #: number of worlds side by side
    out: FilePath = Path("runs/development")  #: folder of the episodes
    overwrite: bool = False  #: replace episodes of other code
    page: FilePath | None = None  #: page with their tables, such as docs/baselines.md


def run(options: Annotated[Options, tyro.conf.arg(name="")]) -> None:
    """Runs the conditions and writes their tables.

    Raises:
        ValueError: an unknown name, seeds for another purpose, or a page without a place for the
            tables.
    """
    seeds.check(range(options.seed, options.seed + options.episodes), "development")
    wanted = list(chosen(options))
    if options.page is not None:
        text = marks.read(options.page)
        for suite in wanted:
            marks.check(text, *marked(suite.about))
    for suite in wanted:
        policies = {name: name for name in options.policies}
        study = compare(
            policies,
            suite,
            options.episodes,
            options.out / suite.about,
            workers=options.workers,
            num_envs=options.num_envs,
            replays=0,
            overwrite=options.overwrite,
        )
        note = f"{options.episodes} episodes each, seeds from {options.seed} on."
        found = f"{table(study)}\n\n{note}"
        say(found)
        if options.page is not None:
            text = marks.replaced(marks.read(options.page), *marked(suite.about), found)
            options.page.write_text(text, encoding="utf-8")


def marked(suite: str) -> tuple[str, str]:
    """Returns the lines between which a page has the table of a suite."""
    return START.format(suite), END.format(suite)


def chosen(options: Options) -> Iterator[Suite]:
    """Yields the conditions of each suite with the criterion of delivery.

    Raises:
        ValueError: an unknown name of a suite or of a condition.
    """
    published = {name: SUITES.find(name) for name in options.suites}
    known = {one.name for suite in published.values() for one in suite.conditions}
    if unknown := sorted(set(options.conditions) - known):
        raise ValueError(f"condition {unknown[0]!r}: there are {', '.join(sorted(known))}")
    for name, suite in published.items():
        conditions = tuple(
            replace(
                one,
                control=None,
                task=one.task or suite.task,
                options={**one.options, "delivery": options.delivery},
            )
            for one in suite.conditions
            if one.name in (options.conditions or known)
        )
        if conditions:
            yield Suite(CUSTOM, name, conditions, options.seed)


def table(study: Comparison) -> str:
    """Returns success with its interval and median time of policies as Markdown.

    The policy with the most deliveries is set in bold, of several the fastest one.
    """
    suite, rows = study.results.suite, []
    found = study.table().reindex(columns=list(COLUMNS))
    for condition in suite.conditions:
        row: dict[str, Any] = {suite.about: condition.name}
        policies = found.loc[condition.name]
        better = policies.sort_values(["success", "time_to_goal"], ascending=[False, True]).index[0]
        for policy, one in policies.iterrows():
            low, high = one.success_low, one.success_high
            share = f"{100 * one.success:.3g} [{100 * low:.3g}, {100 * high:.3g}] %"
            row[str(policy)] = f"**{share}**" if policy == better and one.success else share
            row[f"{policy}, median time"] = f"{one.time_to_goal:.1f} s" if one.success else None
        rows.append(row)
    return markdown({"rows": rows, "notes": []}).strip()


main = command(run, "python benchmarks/development.py")

if __name__ == "__main__":
    main()
