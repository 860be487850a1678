"""The cross-entropy method finds optima that are known."""

import numpy as np
import pytest

from baselines.rollout.cross_entropy import search

PLACE = np.array([1.0, -2.0, 0.5])


def score(candidate):
    return -float(np.sum((candidate - PLACE) ** 2))


def find(objective=score, seed=0, generations=12, population=24, elite=6):
    rng = np.random.default_rng(seed)
    return search(objective, np.zeros(3), np.full(3, 1.5), rng, generations, population, elite)


def test_the_optimum_is_found():
    np.testing.assert_allclose(find(), PLACE, atol=0.1)


def test_the_optimum_is_found_under_noise():
    noise = np.random.default_rng(5)
    found = find(lambda candidate: score(candidate) + 0.1 * noise.standard_normal())
    np.testing.assert_allclose(found, PLACE, atol=0.3)


def test_the_search_follows_from_its_generator():
    np.testing.assert_array_equal(find(seed=3), find(seed=3))
    assert (find(seed=3) != find(seed=4)).any()


def test_the_mean_is_the_first_candidate_of_every_generation():
    seen = []
    find(lambda candidate: seen.append(candidate) or 0.0, generations=2)
    np.testing.assert_array_equal(seen[0], np.zeros(3))
    assert len(seen) == 48


@pytest.mark.parametrize("elite", [1, 24])
def test_an_elite_that_is_no_part_of_the_population_is_refused(elite):
    with pytest.raises(ValueError, match="elite"):
        find(elite=elite)
