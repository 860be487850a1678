"""Films of episodes."""

from collections.abc import Iterator
from pathlib import Path
from typing import cast

from asv_env.params import EnvParams
from asv_env.render import video
from asv_env.render.viewer import Frame, Viewer
from asv_env.simulation import Simulation
from baselines.policy import MakePolicy
from baselines.rollout.guard import Guard
from baselines.rollout.loop import rollout

EVERY = 4  #: control ticks between two frames
FPS = 20  #: frames a second
SIZE = (480, 480)  #: width and height of a frame, px
LAST = 30  #: number of times that the last frame is shown


def save(path: Path, make_policy: MakePolicy, params: EnvParams, seed: int) -> None:
    """Films the episode of a seed, to GIF or MP4 by the path's suffix; replaces the file.

    Raises:
        ValueError: a suffix other than ".gif" and ".mp4".
    """
    video.save(frames(make_policy, params, seed), path, FPS, overwrite=True)


def frames(make_policy: MakePolicy, params: EnvParams, seed: int) -> Iterator[Frame]:
    """Yields the frames (height, width, 3) uint8 of one episode, which a policy error ends."""
    simulation, viewer = Simulation(params), Viewer(params, size=SIZE)
    policy = Guard(make_policy, params)
    for tick in rollout(simulation, policy.act, [seed]):
        tick.over[list(policy.errors)] = True
        if tick.state.tick[0] % EVERY == 0:
            yield cast(Frame, viewer.draw(tick.state))
    yield from [cast(Frame, viewer.draw(simulation.state))] * LAST
