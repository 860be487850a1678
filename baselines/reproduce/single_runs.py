"""The single runs that Figs. 6 to 9 show."""

from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from asv_env.geometry import wrap
from asv_env.params import EnvParams
from asv_env.types import Action, Bool, Float, Observation, Sensed
from baselines.paper import two_arc
from baselines.paper.arcs import ArcPath
from baselines.paper.paper_numbers import IN_RANGE, PAPER_GOAL
from baselines.policy import POLICIES, MakePolicy, Policy
from baselines.reproduce.artefact import Job
from baselines.reproduce.fig1_2_definitions import ALPHA1
from baselines.reproduce.paper_environments import experiment, run, simulation
from baselines.rollout.episodes import POSE_LOG_EVERY, PoseLog

VARIANCE = 0.05  #: of the paper's noise, without a unit there: rad^2 for angles, cm^2 for x and y
GOALS = (PAPER_GOAL, (0.6, 0.7, -1.6))  #: of Fig. 7, m, m, rad: one below the vessel, one in y > 0
PER_SECOND = 5  #: number of poses that are kept of a log in each second


class NoisyPoses:
    """A policy whose boats see their own poses with white noise, fresh at each tick.

    The paper disturbs the boats' angular positions and their x and y. Eq. (3) depends on the
    difference of heading and angular position, and so the noise of the angle is put on the heading.
    """

    def __init__(self, policy: Policy, seed: int) -> None:
        self._policy = policy
        self._rng = np.random.default_rng(seed)
        self._deviation = np.sqrt(VARIANCE) * np.array([0.01, 0.01, 1.0])

    def act(
        self, sensed: Sensed, observation: Observation, memory: Any, fresh: Bool
    ) -> tuple[Action, Any]:
        """See ``Policy.act``."""
        seen = sensed.estimate.copy()
        boats = seen[:, 1:, :3]
        boats += self._deviation * self._rng.standard_normal(boats.shape)
        boats[..., 2] = wrap(boats[..., 2])
        return self._policy.act(replace(sensed, estimate=seen), observation, memory, fresh)


def noisy_paper(seed: int) -> MakePolicy:
    """Returns the paper's policy with the noise of its simulation."""
    return lambda params: NoisyPoses(POLICIES["paper"](params), seed)


def noisy_simulation(job: Job) -> dict[str, Any]:
    """Returns a run of the paper's simulation: ten boats, with noise on their own poses."""
    return typical_run(noisy_paper(job.seed), simulation(), job, "fig6")


def simulations(job: Job) -> list[dict[str, Any]]:
    """Returns a run of eight boats without noise in simulation for each goal of Fig. 7."""
    return [
        typical_run(POLICIES["paper"], simulation(num_boats=8, goal=goal), job, f"fig7 {goal}")
        for goal in GOALS
    ]


def experimental_run(job: Job) -> dict[str, Any]:
    """Returns a run of the paper's experiment with four boats."""
    return typical_run(POLICIES["paper"], experiment(), job, "figs 8, 9")


def typical_run(make_policy: MakePolicy, params: EnvParams, job: Job, what: str) -> dict[str, Any]:
    """Returns the run of median smallest distance among the trials with closure, as plain values.

    Returns:
        ``seed``; number of ``trials`` and of those with closure, ``closed``; ``closure``, its time
        in s or None; ``times`` (T,) s and ``poses`` (T, B, 3) m, m, rad, boats in the order of
        their slots; ``goal`` (3,).
    """
    logs = run(make_policy, params, job.seeds(job.trials), what)
    closed = [log for log in logs if log.episode.time_to_closure is not None]
    chosen = sorted(closed or logs, key=_smallest_distance)[len(closed or logs) // 2]
    step = POSE_LOG_EVERY / params.clock.control
    every = max(1, round(1 / (PER_SECOND * step)))
    times, poses = np.arange(len(chosen.poses))[::every] * step, chosen.poses[::every]
    closure = chosen.episode.time_to_closure
    index = -1 if closure is None else int(np.searchsorted(times, closure))
    order = [0, *(1 + np.argsort(in_frame(poses[index, 1:], poses[index, 0])[:, 0]))]
    return {
        "seed": chosen.episode.seed,
        "trials": len(logs),
        "closed": len(closed),
        "closure": closure,
        "times": np.round(times, 3).tolist(),
        "poses": np.round(poses[:, order], 4).tolist(),
        "goal": chosen.goal.tolist(),
    }


def _smallest_distance(log: PoseLog) -> float:
    distance = log.episode.min_position_error
    return np.inf if distance is None else distance


@dataclass(frozen=True)
class Run:
    """A run of a study, ready to be drawn."""

    times: Float  #: (T,) s
    poses: Float  #: (T, B, 3) m, m, rad
    goal: Float  #: (3,) m, m, rad
    closure: int  #: index of the first pose with closure; the last pose if there is none
    path: ArcPath | None  #: planned at closure; None without closure

    @classmethod
    def read(cls, study: dict[str, Any]) -> Self:
        """Returns the run that the plain values of ``typical_run`` stand for."""
        times, poses, goal = (np.array(study[key]) for key in ("times", "poses", "goal"))
        last = len(times) - 1
        if study["closure"] is None:
            return cls(times, poses, goal, last, None)
        closure = min(int(np.searchsorted(times, study["closure"])), last)
        plan = two_arc.plan(in_frame(goal, poses[closure, 0]), ALPHA1)
        path = ArcPath(poses[closure, 0], plan.curvature, plan.length)
        return cls(times, poses, goal, closure, path)

    @property
    def marks(self) -> Float:
        """Centres of the circles and the switching point (n, 2), m."""
        if self.path is None:
            return np.zeros((0, 2))
        return np.concatenate([self.path.centres, self.path.joints[1:2, :2]])

    @property
    def switch(self) -> int:
        """Index of the pose nearest to the switching point after closure."""
        if self.path is None:
            return self.closure
        offset = self.poses[self.closure :, 0, :2] - self.path.joints[1, :2]
        return self.closure + int(np.hypot(*offset.T).argmin())

    @property
    def stop(self) -> int:
        """Index of the first pose after closure at which the goal is in range."""
        offset = self.poses[self.closure :, 0, :2] - self.goal[:2]
        return self.closure + int((np.hypot(*offset.T) < IN_RANGE).argmax())


def in_frame(poses: Float, frame: Float) -> Float:
    """Returns poses (..., 3) relative to a pose (3,)."""
    offset = (poses[..., 0] - frame[0] + 1j * (poses[..., 1] - frame[1])) * np.exp(-1j * frame[2])
    return np.stack([offset.real, offset.imag, wrap(poses[..., 2] - frame[2])], axis=-1)
