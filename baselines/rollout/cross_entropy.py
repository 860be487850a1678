"""The cross-entropy method: a search for the arguments that score best.

Rubinstein and Kroese, The Cross-Entropy Method, 2004: sample candidates from a normal distribution,
fit the distribution to the best of them, and repeat.
"""

from collections.abc import Callable

import numpy as np

from asv_env.types import Float

SMOOTHING = 0.7  #: weight of the fitted distribution; the rest is that of the last one


def search(
    objective: Callable[[Float], float],
    mean: Float,
    spread: Float,
    rng: np.random.Generator,
    generations: int,
    population: int,
    elite: int,
) -> Float:
    """Returns the mean (K,) of the last distribution.

    Args:
        objective: score of a candidate (K,), the larger the better.
        mean: (K,) of the first distribution; the mean is always one of the candidates.
        spread: (K,) standard deviations of the first distribution.
        rng: generator of the candidates.
        generations: number of distributions that are fitted.
        population: number of candidates of each.
        elite: number of the best ones to which a distribution is fitted.

    Raises:
        ValueError: the elite is not a part of the population, or less than two.
    """
    if not 2 <= elite < population:
        raise ValueError(f"elite = {elite}: must be at least 2 and less than {population}")
    mean, spread = np.array(mean, dtype=np.float64), np.array(spread, dtype=np.float64)
    for _ in range(generations):
        candidates = mean + spread * rng.standard_normal((population, len(mean)))
        candidates[0] = mean
        scores = np.array([objective(candidate) for candidate in candidates])
        best = candidates[np.argsort(-scores, kind="stable")[:elite]]
        mean = mean + SMOOTHING * (best.mean(axis=0) - mean)
        spread = spread + SMOOTHING * (best.std(axis=0) - spread)
    return mean
