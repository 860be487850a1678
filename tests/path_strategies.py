"""Random goals and paths for the tests of the paper's paths and laws."""

import numpy as np
from hypothesis import strategies as st

from asv_env.geometry import wrap
from baselines.paper.arcs import ArcPath

coordinates = st.floats(-2.0, 2.0)
angles = st.floats(-np.pi, np.pi)
goals = st.tuples(coordinates, coordinates, angles)
radii = st.floats(0.05, 0.6)
curvatures = st.sampled_from([-5.0, 0.0, 5.0]) | st.floats(-5.0, 5.0)
lengths = st.just(0.0) | st.floats(0.0, 2.0)
scales = st.sampled_from([1e-3, 1e-2, 0.5, 100.0, 1e4])
arcs = st.lists(st.tuples(curvatures, lengths), min_size=1, max_size=4)
MIRROR = np.array([-1.0, 1.0, -1.0])


def many_goals(count, seed=0):
    rng = np.random.default_rng(seed)
    return rng.uniform([-1.5, -1.5, -np.pi], [1.5, 1.5, np.pi], (count, 3))


def pose_error(pose, goal):
    """Largest deviation in x, y and heading."""
    deviation = np.asarray(pose) - np.asarray(goal)
    return np.max(
        np.abs([*np.moveaxis(deviation[..., :2], -1, 0), wrap(deviation[..., 2])]), axis=0
    )


def as_path(segments, start=(0.0, 0.0, 0.0)):
    curvature, length = np.transpose(segments)
    return ArcPath(start, curvature, length)
