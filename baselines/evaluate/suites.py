"""Named, frozen sets of episodes, on which results can be compared for years.

A suite is a table of arms, each a condition and a range of seeds. Arms of one suite with the same
team have the same seeds, and so the same starts and goals: what a disturbance costs is seen beside
its control arm, pair by pair. What a published name means is never changed; ``digest`` notices,
and a changed suite takes a new name.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np

from asv_env import scenarios
from asv_env.params import EnvParams
from asv_env.presets import make_params
from baselines.experiment import PAPER_GOAL

EPISODES = 2000
"""Episodes of an arm that carries a comparison."""
PLANK_AREA = 0.40 * 0.15
"""Of the vessel seen from above, m^2; the same for all shapes, and so is its mass."""
DRAWN = 3
"""Episodes of an arm whose beginnings go into the digest."""


@dataclass(frozen=True)
class Arm:
    """One condition.

    Attributes:
        name: unique in its suite.
        about: what it is, in a few words.
        control: name of the arm without the disturbance; None for one that is such an arm.
        task: "approach", "push" or "transport".
        scenario, preset, num_boats, options: as of ``make_params``.
    """

    name: str
    about: str = ""
    control: str | None = None
    task: str = "transport"
    scenario: str = "nominal"
    preset: str = "nominal"
    num_boats: int | None = None
    options: Mapping[str, Any] = field(default_factory=dict)

    @cached_property
    def params(self) -> EnvParams:
        """The environment's parameters.

        Raises:
            ValueError: an unknown name or a value out of range.
        """
        return make_params(self.task, self.num_boats, self.scenario, self.preset, **self.options)


@dataclass(frozen=True)
class Suite:
    """A set of episodes.

    Attributes:
        name: with its version, such as "plane-v1".
        about: what it is for, in a sentence.
        arms: its conditions.
        seed: of the first episode of every arm.
        episodes: of every arm.
    """

    name: str
    about: str
    arms: tuple[Arm, ...]
    seed: int = 0
    episodes: int = EPISODES

    def of(self, task: str) -> Suite:
        """The same starts and goals with another task."""
        return replace(self, arms=tuple(replace(arm, task=task) for arm in self.arms))

    def first(self, episodes: int) -> Suite:
        """The first episodes of every arm."""
        return replace(self, episodes=episodes)

    @property
    def seeds(self) -> range:
        """Of the episodes of every arm."""
        return range(self.seed, self.seed + self.episodes)

    @property
    def task(self) -> str:
        """Of the arms, joined where they differ."""
        return "+".join(dict.fromkeys(arm.task for arm in self.arms))

    def digest(self) -> str:
        """A fingerprint of what the episodes are, not of how many are taken.

        It covers the parameters of all arms (but for the weights of the reward) and how their
        first episodes begin.
        """
        arms = [[arm.name, _described(arm.params), *_begun(arm, self.seed)] for arm in self.arms]
        text = json.dumps(_rounded(arms), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


def _described(params: EnvParams) -> dict[str, Any]:
    values = asdict(params)
    del values["reward"]
    return values


def _begun(arm: Arm, seed: int) -> list[dict[str, Any]]:
    seeds = range(seed, seed + DRAWN)
    return [vars(scenarios.draw(arm.params, np.random.default_rng(seed))) for seed in seeds]


def _rounded(value: Any) -> Any:
    """Plain values with nine digits of every number: the last ones are the processor's own."""
    if isinstance(value, Mapping):
        return {name: _rounded(item) for name, item in value.items()}
    if isinstance(value, np.ndarray):
        return _rounded(value.tolist())
    if isinstance(value, list | tuple):
        return [_rounded(item) for item in value]
    return f"{value:.9g}" if isinstance(value, float) else value


def custom(
    tasks: Sequence[str],
    disturbances: Sequence[str],
    teams: Sequence[int | None],
    preset: str,
    goal: tuple[float, ...] | None,
    seed: int,
    episodes: int,
) -> Suite:
    """A sweep over tasks, scenarios and team sizes; ``goal`` None draws one for each episode.

    Raises:
        ValueError: an unknown name, a value out of range, or one that is named twice.
    """
    given = {"--task": tasks, "--scenario": disturbances, "--num-boats": teams}
    for flag, values in given.items():
        if len(set(values)) < len(values):
            raise ValueError(f"{flag} {' '.join(map(str, values))}: name each once")
    options: dict[str, Any] = {} if goal is None else {"goal": goal}
    arms = []
    for task, scenario, team in product(tasks, disturbances, teams):
        arm = Arm("", "", None, task, scenario, preset, team, options)
        boats = arm.params.num_boats
        arms.append(replace(arm, name=_arm_name(tasks, disturbances, teams, task, scenario, boats)))
    about = f"{_listed(tasks)}; {_listed(disturbances)}"
    return Suite("custom", about, tuple(arms), seed, episodes)


def _arm_name(
    tasks: Sequence[str],
    disturbances: Sequence[str],
    teams: Sequence[int | None],
    task: str,
    scenario: str,
    boats: int,
) -> str:
    """What sets an arm apart in its sweep."""
    parts = [task] * (len(tasks) > 1)
    parts += [f"{boats} boats"] * (len(teams) > 1)
    parts += [scenario] * (len(disturbances) > 1 or not parts)
    return ", ".join(parts)


def _listed(names: Iterable[str]) -> str:
    return ", ".join(names)


def _water(current: str, speed: float) -> dict[str, Any]:
    return {"water": {"current": current, "current_speed": speed}}


def _noise(factor: float) -> dict[str, Any]:
    noise = {"position": 0.01, "heading": 0.05, "speed": 0.01, "yaw_rate": 0.1}
    return {"sensors": {f"{name}_noise": factor * sd for name, sd in noise.items()}}


def _shaped(aspect: float) -> dict[str, Any]:
    """A plank of the nominal area and mass; its drag follows its length."""
    length = (PLANK_AREA * aspect) ** 0.5
    return {"vessel": {"length": length, "width": PLANK_AREA / length, "mass": 0.60}}


def _robust() -> tuple[Arm, ...]:
    control = Arm("control", "four boats, still water, exact measurement")
    six = Arm("control-6", "the same with six boats", num_boats=6)
    disturbed = {
        "noise-half": ("half the noise of `noisy`", _noise(0.5)),
        "noise": ("the noise of `noisy`", _noise(1.0)),
        "noise-double": ("twice that noise", _noise(2.0)),
        "current-1": ("uniform current of 1 cm/s", _water("uniform", 0.01)),
        "current-2": ("uniform current of 2 cm/s", _water("uniform", 0.02)),
        "gyre-1": ("double gyre, 1 cm/s at its fastest", _water("double_gyre", 0.01)),
        "gyre-2": ("double gyre, 2 cm/s at its fastest", _water("double_gyre", 0.02)),
        "actuators": (
            "thrust of each motor ±15 %, lag 0.05 to 0.3 s",
            {"variation": {"thrust": 0.15, "lag": (0.05, 0.3)}},
        ),
        "hulls": (
            "mass ±20 %, drag ±30 % of each hull",
            {"variation": {"mass": 0.2, "drag": 0.3}},
        ),
        "friction-low": ("contact friction 0.1", {"water": {"contact_friction": 0.1}}),
        "friction-high": ("contact friction 0.6", {"water": {"contact_friction": 0.6}}),
    }
    arms = [
        Arm(name, about, control.name, options=options)
        for name, (about, options) in disturbed.items()
    ]
    return (
        control,
        *arms,
        Arm("harsh", "scenario `harsh`: all at once, a failing boat", "control", scenario="harsh"),
        six,
        Arm("failure-6", "one of six boats fails", six.name, scenario="failure", num_boats=6),
    )


def _teams() -> tuple[Arm, ...]:
    return tuple(
        Arm(f"{team}-boats", f"{team} boats, scenario `noisy`", scenario="noisy", num_boats=team)
        for team in (2, 3, 4, 6, 8, 12, 20, 32)
    )


def _shapes() -> tuple[Arm, ...]:
    aspects = [
        Arm(
            f"aspect-{aspect:g}",
            f"length {aspect:g} times the width, scenario `noisy`",
            "plank",
            scenario="noisy",
            options=_shaped(aspect),
        )
        for aspect in (1.0, 1.5, 2.0, 4.0, 6.0)
    ]
    return (
        Arm("plank", "the nominal plank, 2.67 times as long as wide", scenario="noisy"),
        *aspects,
        Arm(
            "no-fins",
            "the plank without its fins, scenario `noisy`",
            "plank",
            scenario="noisy",
            options={"vessel": {"fins": 0.0}},
        ),
    )


_PLANE = (
    Arm("nominal", "goals over the whole plane"),
    Arm("noisy", "the same, measured with noise", "nominal", scenario="noisy"),
)
_PAPER = (
    Arm("nominal", "the paper's goal, from the pose at closure", preset="experiment"),
    Arm("noisy", "the same, measured with noise", "nominal", scenario="noisy", preset="experiment"),
)
SUITES = {
    suite.name: suite
    for suite in (
        Suite(
            "quick-v1",
            "Two minutes on a laptop: the paper's goal and goals over the plane.",
            (
                Arm("paper-goal", "one goal for all", options={"goal": PAPER_GOAL}),
                Arm("plane", "goals over the whole plane"),
                Arm("noisy", "the same, measured with noise", "plane", scenario="noisy"),
            ),
            seed=1_000_000,
            episodes=60,
        ),
        Suite("paper-v1", "The paper's experiment: one goal pose, four boats.", _PAPER, 2_000_000),
        Suite("plane-v1", "Goals anywhere around the vessel, any heading.", _PLANE, 3_000_000),
        Suite(
            "robust-v1", "Disturbances one by one, each beside its control.", _robust(), 4_000_000
        ),
        Suite(
            "team-v1", "Teams of 2 to 32 boats; the vessel grows with them.", _teams(), 5_000_000
        ),
        Suite("shape-v1", "Vessels of other shapes, and one without fins.", _shapes(), 6_000_000),
    )
}
"""The published suites by name."""
