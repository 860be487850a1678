"""What the autopilot's reference model does for a learner that begins with large random actions.

``python benchmarks/beginner.py`` compares the autopilot as it is with one whose reference jumps to
every set-point. First, teams in closure act at random, with normal actions of standard deviation
1 at each control step, as a policy-gradient learner does at first: for how long do they keep the
vessel? Then stable-baselines3's PPO learns an easy push (a goal straight ahead) with the defaults
of that library: what share of episodes does it deliver at the end?
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import tyro

from asv_env import BoatVecEnv
from asv_env.checks import check_whole
from asv_env.params import BoatParams
from asv_env.presets import make_params
from asv_env.simulation import Simulation
from baselines.rollout.commands import command

JUMPING = BoatParams(response=(0.0, 0.0), acceleration=(1e6, 1e6))  #: no reference model
BOATS = {"reference model": BoatParams(), "reference that jumps": JUMPING}
EASY = {"goal": (0.0, -0.3, 0.0), "position_tolerance": 0.1, "heading_tolerance": 0.5}
"""The easy push: straight ahead, with the tolerances of the paper's own trials."""


@dataclass(frozen=True)
class Options:
    """Compares learners' first actions with and without the reference model."""

    worlds: int = 256  #: number of teams that act at random
    rows: int = 500_000  #: transitions of boats from which PPO learns; 0 leaves it out
    seeds: int = 3  #: number of trainings for each autopilot

    def __post_init__(self) -> None:
        check_whole(self, "worlds", 1, 10**5)
        check_whole(self, "rows", 0, 10**9)
        check_whole(self, "seeds", 1, 100)


def grasp_times(boat: BoatParams, worlds: int) -> np.ndarray:
    """Returns the times (W,) for which teams that act at random keep their grasp, s."""
    params = make_params("push", boat=boat, time_limit=30.0)
    simulation, rng = Simulation(params, worlds), np.random.default_rng(10**8)
    simulation.reset(seeds=range(10**8, 10**8 + worlds))
    lost = np.full(worlds, np.inf)
    for tick in range(params.time_limit_ticks):
        over = simulation.ending.terminated | simulation.ending.truncated
        if over.any():
            simulation.reset(over)
        simulation.step(rng.standard_normal((worlds, params.num_boats, 2)))
        open_now = ~simulation.state.closed & np.isinf(lost)
        lost[open_now] = (tick + 1) / params.clock.control
    return lost


def learn(boat: BoatParams, rows: int, seed: int) -> float:
    """Returns the share of deliveries in the last tenth of a PPO training with defaults."""
    from stable_baselines3 import PPO
    from stable_baselines3.common.callbacks import BaseCallback

    class Deliveries(BaseCallback):
        """Notes which episodes end with a delivery."""

        def __init__(self) -> None:
            super().__init__()
            self.ended: list[tuple[int, bool]] = []

        def _on_step(self) -> bool:
            for info in self.locals["infos"]:
                if "terminal_observation" in info:
                    self.ended.append((self.num_timesteps, bool(info["is_success"])))
            return True

    env = BoatVecEnv("push", num_envs=16, boat=boat, time_limit=60.0, **EASY)
    watch = Deliveries()
    PPO("MlpPolicy", env, seed=seed).learn(rows, callback=watch)
    late = [success for when, success in watch.ended if when > 0.9 * watch.num_timesteps]
    return float(np.mean(late)) if late else float("nan")


def compare(options: Annotated[Options, tyro.conf.arg(name="")]) -> None:
    """Compare learners' first actions with and without the reference model."""
    for name, boat in BOATS.items():
        lost = grasp_times(boat, options.worlds)
        low, median, high = np.quantile(lost, [0.25, 0.5, 0.75])
        print(f"{name}: grasp lost after {median:.1f} s (quartiles {low:.1f} to {high:.1f} s)")
    for name, boat in BOATS.items():
        for seed in range(options.seeds if options.rows else 0):
            share = learn(boat, options.rows, seed)
            result = f"{name}: PPO, seed {seed}, {options.rows} rows: {100 * share:.0f} % delivered"
            print(result, flush=True)


main = command(compare, "python benchmarks/beginner.py")

if __name__ == "__main__":
    main()
