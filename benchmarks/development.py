"""How often policies succeed where they may be tuned: ``python benchmarks/development.py``.

It runs the conditions of a published suite on seeds for development, by either criterion of
delivery. Seeds of the suites themselves are for comparisons alone.
"""

from dataclasses import dataclass, replace
from typing import Annotated, Literal

import tyro

from baselines.evaluate import compare
from baselines.evaluate.conditions import CUSTOM, Suite
from baselines.evaluate.suites import SUITES
from baselines.rollout import seeds
from baselines.rollout.commands import command, say


@dataclass(frozen=True)
class Options:
    """Prints the success of policies in the conditions of a suite, on seeds for development."""

    suite: str = "robust-v2"  #: name of the suite whose conditions are run
    conditions: tuple[str, ...] = ()  #: names of some of them; by default all
    delivery: Literal["holding", "passing"] = "passing"  #: criterion of delivery
    policies: tuple[str, ...] = ("scripted",)  #: registered names
    episodes: int = 100  #: number of episodes of each condition
    seed: int = seeds.DEVELOPMENT.start  #: seed of the first episode
    workers: int = 1  #: number of processes
    num_envs: int = 250  #: number of worlds side by side


def run(options: Annotated[Options, tyro.conf.arg(name="")]) -> None:
    """Runs the conditions and prints their table.

    Raises:
        ValueError: an unknown name, or seeds for another purpose.
    """
    seeds.check(range(options.seed, options.seed + options.episodes), "development")
    known = {one.name: one for one in SUITES.find(options.suite).conditions}
    if unknown := sorted(set(options.conditions) - set(known)):
        raise ValueError(f"condition {unknown[0]!r}: {options.suite} has {', '.join(known)}")
    chosen = tuple(
        replace(one, control=None, options={**one.options, "delivery": options.delivery})
        for name, one in known.items()
        if name in (options.conditions or known)
    )
    suite = Suite(CUSTOM, f"{options.suite}, for development", chosen, options.seed)
    policies = {name: name for name in options.policies}
    shared = {"workers": options.workers, "num_envs": options.num_envs, "replays": 0}
    say(compare(policies, suite, options.episodes, **shared))


main = command(run, "python benchmarks/development.py")

if __name__ == "__main__":
    main()
