"""Adapter: a TorchRL EnvBase, many worlds in one batch, all boats one group of agents."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.spaces import Box, MultiDiscrete

from asv_env.arguments import checked_seeds
from asv_env.checks import Whole, choice
from asv_env.envs.common import Adapter, ResetNeededError, Stage, goal_option, world_seeds
from asv_env.envs.infos import metrics_of, reward_terms, team_mean
from asv_env.envs.limits import limited
from asv_env.numerics import numerics
from asv_env.params import DISCRETE_ACTIONS
from asv_env.presets import Overrides, make_params
from asv_env.sensing.global_state import global_state, global_state_bound
from asv_env.simulation import Simulation
from asv_env.tasks import InitialStates, Task
from asv_env.types import Bool, Float, Observation, TimeStep

try:
    import torch
    from tensordict import TensorDict, TensorDictBase
    from torchrl.data import Bounded, Categorical, Composite, Unbounded
    from torchrl.envs import EnvBase
except ImportError as error:
    raise ImportError("asv_env.TorchRLEnv needs TorchRL: pip install 'asv-env[torchrl]'") from error

GROUP = "asv"  #: name of the group of all boats
INFO = ("is_success", "position_error", "heading_error")  #: infos by default
ENDS = ("done", "terminated", "truncated")


class TorchRLEnv(Adapter, EnvBase):
    """Many worlds as one TorchRL environment: ``asv_env.TorchRLEnv("push", num_envs=64)``.

    The batch size is (W,), the number of worlds; A is the number of boats, K that of observed
    features, S that of values of the global state. Names and values of the tensors are those of
    TorchRL's ``PettingZooWrapper`` of ``parallel_env``, to the bit, and stepping is many times
    faster.

    Observation: ("asv", "observation") (W, A, K) float32; "state" (W, S) float32, see
    ``global_state``; ("asv", "info", name) (W, A) float32 for the names of ``info``.
    Action: ("asv", "action") (W, A, 2) float32 in [-1, 1]; finite values outside are clipped. With
    ``action_mode="discrete"`` (W, A) numbers of ``DISCRETE_ACTIONS``.
    Reward: ("asv", "reward") (W, A, 1) float32.
    End: as in ``JointEnv``; "done", "terminated" and "truncated" (W, 1) bool, and the same for
    each boat at ("asv", "done") ... (W, A, 1).

    With ``flat`` one agent drives all boats of a world, and there is no group: "observation"
    (W, A K), "action" (W, 2 A), or (W, A) if discrete, "reward" (W, 1), the mean of the boats'
    rewards, and ("info", name) (W,).

    Where an episode is over, TorchRL's collectors and rollouts reset its world alone. World w gets
    ``seed + w`` at its next reset, and later episodes continue with its own Generator.

    Args:
        task, num_boats, scenario: as in ``JointEnv``.
        num_envs: W.
        seed: seed of world 0, as in ``set_seed``; None: another one each time.
        device: device of all tensors. Worlds are simulated on the CPU; tensors for a GPU are
            copied from pinned memory.
        with_state: whether "state" is observed.
        flat, max_episode_steps: as in ``JointEnv``.
        info: names of metrics and "reward_<term>" that are observed as infos.
        render_mode: None, "rgb_array" or "human", which shows world 0.
        num_threads, initial_states: see ``Simulation``.
        **options: see ``presets.make_params``.
    """

    def __init__(
        self,
        task: str | Task = "transport",
        num_envs: int = 64,
        num_boats: int | None = None,
        scenario: str | Overrides = "nominal",
        seed: int | None = None,
        device: Any = "cpu",
        with_state: bool = True,
        flat: bool = False,
        info: Sequence[str] = INFO,
        render_mode: str | None = None,
        num_threads: int | None = None,
        initial_states: InitialStates | None = None,
        max_episode_steps: int | None = None,
        **options: Any,
    ) -> None:
        num_envs = Whole(1).checked("num_envs", num_envs)
        params = make_params(task, num_boats, scenario, **options)
        params = limited(params, options, max_episode_steps=max_episode_steps)
        simulation = Simulation(params, num_envs, num_threads, initial_states)
        EnvBase.__init__(self, device=device or "cpu", batch_size=(num_envs,))
        self._open(simulation, render_mode)
        self.is_closed = False
        self.num_envs, self._team, self._with_state = num_envs, params.num_boats, with_state
        self._flat, self._agents = flat, (num_envs,) if flat else (num_envs, params.num_boats)
        known = (*reward_terms(simulation), *metrics_of(simulation))
        self._info = tuple(choice("info", name, known) for name in info)
        names = [f"{GROUP}_{boat}" for boat in range(self._team)]
        self.group_map = {} if flat else {GROUP: names}  #: {group: names of its agents}
        self._make_specs()
        self._latest: Observation = np.empty(0, dtype=np.float32)  # of all worlds
        self._ends = np.zeros((2, num_envs), dtype=np.bool_)  # terminated, truncated
        self._set_seed(seed)

    def _make_specs(self) -> None:
        """Sets TorchRL's descriptions of all tensors."""
        agents, device = self._agents, self.device
        seen, acted = map(self._spec, self._boat_spaces(self._team, flat=self._flat))
        self._acted = tuple(acted.shape)
        observed = {"observation": seen}
        if self._info:
            infos = {name: Unbounded(agents, device=device) for name in self._info}
            observed["info"] = Composite(infos, shape=agents)
        observation = self._of_agents(observed)
        if self._with_state:
            bound = global_state_bound(self._team)
            observation["state"] = self._spec(Box(-bound, bound))
        done = self._of_agents(self._end_specs(*agents))
        done.update(self._end_specs(self.num_envs))
        self.observation_spec, self.done_spec = observation, done
        self.action_spec = self._of_agents({"action": acted})
        self.reward_spec = self._of_agents({"reward": Unbounded((*agents, 1), device=device)})

    def _spec(self, space: Any) -> Any:
        """Returns TorchRL's description of a space of one world, for all worlds."""
        shape = (self.num_envs, *space.shape)
        if isinstance(space, MultiDiscrete):
            return Categorical(len(DISCRETE_ACTIONS), shape, device=self.device)
        low, high = (torch.from_numpy(bound).expand(shape) for bound in (space.low, space.high))
        return Bounded(low.clone(), high.clone(), device=self.device)

    def _end_specs(self, *batch: int) -> dict[str, Any]:
        """Returns TorchRL's descriptions of the flags of an end (..., 1)."""
        flag = Categorical(2, (*batch, 1), dtype=torch.bool, device=self.device)
        return {name: flag.clone() for name in ENDS}

    def _of_agents(self, specs: dict[str, Any]) -> Composite:
        """Returns the description of tensors of the agents, which are a group unless flat."""
        worlds = (self.num_envs,)
        if self._flat:
            return Composite(specs, shape=worlds)
        return Composite({GROUP: Composite(specs, shape=self._agents)}, shape=worlds)

    def _set_seed(self, seed: int | None) -> None:
        """Takes the seeds that the worlds get at their next reset; see ``set_seed``."""
        self._seeds = checked_seeds(world_seeds(seed, self.num_envs), self.num_envs)

    @numerics()
    def _reset(
        self,
        tensordict: TensorDictBase | None = None,
        options: Mapping[str, Any] | None = None,
    ) -> TensorDictBase:
        """Begins episodes in all worlds, or in those of "_reset" (W, 1); see ``reset``."""
        self._require("reset", Stage.NEW, Stage.RUNNING)
        goal, mask = goal_option(options), self._mask(tensordict, "_reset")
        if self._stage is Stage.NEW:
            mask = np.ones_like(mask)
        worlds = np.flatnonzero(mask)
        seeds = [self._seeds[world] for world in worlds]
        observation = self.simulation.reset(mask, seeds, goal)
        for world in worlds:
            self._seeds[world] = None
        latest = observation if len(worlds) == self.num_envs else self._latest.copy()
        latest[mask] = observation
        self._latest, self._ends, self._stage = latest, self._ends & ~mask, Stage.RUNNING
        self._show()
        return self._tensors()

    @numerics()
    def _step(self, tensordict: TensorDictBase) -> TensorDictBase:
        """Advances all worlds by a control step, or those of "_step" (W, 1); see ``step``."""
        self._require("step", Stage.RUNNING)
        action = tensordict.get(self.action_key)
        if tuple(action.shape) != self._acted:
            raise ValueError(f"action of shape {tuple(action.shape)}: must be {self._acted}")
        over = self._over(tensordict)
        by_boat = action.reshape(self.num_envs, self._team, *self._action_shape)
        step = self.simulation.step(by_boat.numpy(force=True))
        ends = np.stack([step.ending.terminated, step.ending.truncated])
        self._latest, self._ends = step.observation, np.where(over, self._ends, ends)
        self._show()
        return self._tensors(step)

    def _over(self, tensordict: TensorDictBase) -> Bool:
        """Returns the worlds (W,) that this step leaves out because their episodes are over.

        The worlds of a simulation step together, so these begin an episode that nobody sees.
        """
        over, steps = np.logical_or.reduce(self._ends), self._mask(tensordict, "_step")
        if (over & steps).any():
            worlds = np.flatnonzero(over & steps).tolist()
            raise ResetNeededError(f"step: the episodes of worlds {worlds} are over; reset them")
        if not (over | steps).all():
            worlds = np.flatnonzero(~(over | steps)).tolist()
            raise ValueError(
                f"'_step' leaves out worlds {worlds} in the middle of their episodes: worlds of "
                "one environment step together"
            )
        if over.any():
            self.simulation.reset(over)
        return over

    def _mask(self, tensordict: TensorDictBase | None, name: str) -> Bool:
        """Returns the worlds (W,) of a mask in a call, all where there is none."""
        given = None if tensordict is None else tensordict.get(name, None)
        if given is None:
            return np.ones(self.num_envs, dtype=np.bool_)
        mask: Bool = given.reshape(self.num_envs).numpy(force=True)
        return mask

    def _tensors(self, step: TimeStep | None = None) -> TensorDict:
        """Returns what the worlds report after a step, or after a reset."""
        terminated, truncated = self._ends.copy()
        ends = dict(zip(ENDS, (terminated | truncated, terminated, truncated), strict=True))
        own: dict[str, np.ndarray] = {"observation": self._latest.copy().reshape(*self._agents, -1)}
        if step is not None:
            own["reward"] = self._of_each(step.reward)[..., None]
        if not self._flat:
            boats = (*self._agents, 1)
            own |= {n: np.repeat(end, self._team).reshape(boats) for n, end in ends.items()}
        root: dict[str, np.ndarray] = {name: end[:, None] for name, end in ends.items()}
        if self._with_state:
            root["state"] = global_state(self.simulation.state, self.params)
        tensors, agents = (
            self._on_device(root, self._agents[:1]),
            self._on_device(own, self._agents),
        )
        if self._info:
            agents["info"] = self._on_device(self._infos(step), self._agents)
        return tensors.update(agents) if self._flat else tensors.set(GROUP, agents)

    def _infos(self, step: TimeStep | None) -> dict[str, Float]:
        """Returns the infos of the agents, (W, A) or flat (W,), float32."""
        known = metrics_of(self.simulation)
        if any(name not in known for name in self._info):
            known |= reward_terms(self.simulation, step)
        return {n: self._of_each(known[n].reshape(self.num_envs, -1)) for n in self._info}

    def _of_each(self, values: Float) -> Float:
        """Returns values (W, A) or (W, 1) as float32 of each boat (W, A), or flat their mean."""
        if self._flat:
            return team_mean(values).astype(np.float32)
        return np.broadcast_to(values, self._agents).astype(np.float32)

    def _on_device(self, arrays: Mapping[str, np.ndarray], batch: tuple[int, ...]) -> TensorDict:
        """Returns arrays, which nothing else holds, as tensors with these batch axes."""
        tensors = {name: torch.from_numpy(array) for name, array in arrays.items()}
        if self.device.type == "cuda":  # only pinned memory is copied while the CPU continues
            tensors = {name: tensor.pin_memory() for name, tensor in tensors.items()}
        moved = {n: tensor.to(self.device, non_blocking=True) for n, tensor in tensors.items()}
        return TensorDict(moved, batch, device=self.device)

    def close(self, *, raise_if_closed: bool = True) -> None:
        """Closes the window, if there is one; the environment cannot be used any more."""
        Adapter.close(self)
        self.is_closed = True
