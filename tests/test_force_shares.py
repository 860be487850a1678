"""Non-negative least squares: the shares against independent solvers, and its optimality."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import lsq_linear, nnls

from baselines.allocation.force_shares import share

SEEDS, TEAMS = st.integers(0, 2**32 - 1), st.integers(1, 32)


def problem(seed, team, worlds=1):
    """Columns (W, A, 3) of unit length and wrenches (W, 3)."""
    rng = np.random.default_rng(seed)
    columns = rng.normal(size=(worlds, team, 3))
    return columns / np.linalg.norm(columns, axis=2, keepdims=True), rng.normal(size=(worlds, 3))


def augmented(columns, wrench, bias, ridge):
    """Matrix and right-hand side of the same problem as plain least squares."""
    rows = np.vstack([columns.T, np.sqrt(ridge) * np.eye(len(columns))])
    return rows, np.concatenate([wrench, np.sqrt(ridge) * bias])


@given(SEEDS, TEAMS, st.sampled_from([1e-4, 1e-2, 1.0]))
def test_without_a_bound_above_it_is_non_negative_least_squares(seed, team, ridge):
    columns, wrench = problem(seed, team)
    free = np.zeros((1, team)), np.full((1, team), np.inf)
    expected, _ = nnls(*augmented(columns[0], wrench[0], free[0][0], ridge))
    np.testing.assert_allclose(share(columns, wrench, *free, ridge)[0], expected, atol=1e-7)


@given(SEEDS, TEAMS)
def test_with_a_bias_and_bounds_it_is_bounded_least_squares(seed, team):
    columns, wrench = problem(seed, team)
    rng = np.random.default_rng(seed + 1)
    bias, limit = rng.uniform(0, 0.3, (1, team)), rng.uniform(0.1, 0.5, (1, team))
    limit *= rng.random((1, team)) < 0.8  # Some boats take no part.
    rows, right = augmented(columns[0], wrench[0], bias[0], 0.01)
    free = limit[0] > 0
    expected = np.zeros(team)
    if free.any():
        bounds = 0.0, limit[0, free]
        expected[free] = lsq_linear(rows[:, free], right, bounds, tol=1e-14).x
    np.testing.assert_allclose(share(columns, wrench, bias, limit)[0], expected, atol=1e-5)


@given(SEEDS, TEAMS)
def test_a_wrench_within_the_cone_is_exerted_and_one_beyond_it_is_approached(seed, team):
    columns, beyond = problem(seed, team)
    within = (columns[0] * np.random.default_rng(seed).random((team, 1))).sum(axis=0)
    free = np.zeros((1, team)), np.full((1, team), np.inf)
    exerted = share(columns, within[None], *free, 1e-6)[0] @ columns[0]
    np.testing.assert_allclose(exerted, within, atol=1e-2)
    missing = beyond[0] - share(columns, beyond, *free, 1e-9)[0] @ columns[0]
    assert (columns[0] @ missing <= 1e-4).all()  # No boat could take any of it away.


def test_worlds_do_not_depend_on_each_other():
    columns, wrench = problem(0, 5, worlds=40)
    bias, limit = np.full((40, 5), 0.1), np.full((40, 5), 0.6)
    together = share(columns, wrench, bias, limit)
    one_by_one = [
        share(columns[w, None], wrench[w, None], bias[:1], limit[:1])[0] for w in range(40)
    ]
    np.testing.assert_array_equal(together, one_by_one)


@pytest.mark.parametrize("size", [0.0, 1e-9, 1e6])
def test_extreme_wrenches_have_finite_shares(size):
    columns = problem(1, 4)[0]
    forces = share(columns, np.full((1, 3), size), np.zeros((1, 4)), np.ones((1, 4)))
    assert ((forces >= 0) & (forces <= 1)).all()
