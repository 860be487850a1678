"""How much a mean varies from one study to the next: variances, and bootstrap bounds.

Tables hold one number for each pair of trainings and each episode, shape (S1, S2, E); see
``statistics``.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

Table = NDArray[np.float64]

LEVEL = 0.95  #: level of all intervals
TAIL = (1 - LEVEL) / 2  #: probability beyond either bound
RESAMPLES = 2000  #: number of bootstrap resamples
BATCH = 1_000_000  #: number of resampled values that are held at once: 8 MB an array


def influence(values: ArrayLike, trim: float) -> tuple[Table, Table]:
    """Returns the trimmed mean of values (..., n), and the influence of each on it, (..., n).

    The statistic plus the influences are pseudo-values, which vary as the statistic does: their
    standard error is that of Tukey and McLaughlin (1963, Sankhya A 25), from the winsorised
    values. With trim 0 they are the values themselves.
    """
    values = np.asarray(values, dtype=float)
    n = values.shape[-1]
    cut = int(trim * n)
    kept = n - 2 * cut
    parts = np.partition(values, (cut, n - 1 - cut), axis=-1)
    lowest, highest = parts[..., cut, None], parts[..., n - 1 - cut, None]
    excess = np.clip(values, lowest, highest) - lowest  # exactly nothing where all are the same
    scale = np.sqrt(n * (n - 1) / (kept * max(kept - 1, 1)))
    centre = lowest[..., 0] + (parts[..., cut : n - cut] - lowest).mean(axis=-1)
    return centre, scale * (excess - excess.mean(axis=-1, keepdims=True))


def crossed_variance(pseudo: Table) -> tuple[float, float]:
    """Returns the variance of the mean of pseudo-values (S1, S2, E), and its degrees of freedom.

    NaN are left out; E > 1. The model is two-way random effects, of trainings and of episodes,
    without replication. The variance between episodes contains the residual variance. Each policy
    with several trainings adds the variance between these in excess of the residual variance, or
    nothing where there is no excess; so intervals are somewhat wide where trainings do not differ.
    The degrees of freedom are those of Satterthwaite (1946, Biometrics Bulletin 2).
    """
    episodes = pseudo.shape[-1]
    total = float(np.nanmean(pseudo, axis=(0, 1)).var(ddof=1)) / episodes
    scatter, least = total**2 / (episodes - 1), episodes - 1
    for rows in (np.nanmean(pseudo, axis=1), np.nanmean(pseudo, axis=0)):
        if (seeds := len(rows)) > 1:
            freedom = (seeds - 1) * (episodes - 1)
            between = float(rows.mean(axis=1).var(ddof=1)) / seeds
            residual = rows - rows.mean(axis=1, keepdims=True) - rows.mean(axis=0) + rows.mean()
            within = float((residual**2).sum()) / (freedom * rows.size)
            if between > within * (1 + 1e-9):  # rounding must not decide where they are equal
                total += between - within
                scatter += between**2 / (seeds - 1) + within**2 / freedom
                least = min(least, seeds - 1)
    return total, max(total**2 / scatter, least) if scatter else np.inf


def pseudo_values(table: Table, trim: float) -> Table:
    """Returns the pseudo-values of each row of (S1, S2, E).

    A missing value has the row's statistic as its pseudo-value; rows without any value are NaN.
    """
    pseudo = np.full(table.shape, np.nan)
    n = table.shape[2]
    for pair in np.ndindex(table.shape[:2]):
        present = ~np.isnan(table[pair])
        if m := int(present.sum()):
            pseudo[pair], own = influence(table[pair][present], trim)
            pseudo[pair][present] += np.sqrt(n * (n - 1) / (m * max(m - 1, 1))) * own
    return pseudo


def bootstrap_bounds(values: Table, trim: float) -> tuple[float, float]:
    """Returns bootstrap-t bounds of the trimmed mean of values (n,), n > 1.

    The method (Efron 1981; Hall 1988) follows the skew of times and distances at small n, where
    the coverage of percentile and BCa intervals is up to five percentage points too low. Student's
    t replaces it where resamples have no spread to divide by, and for so few values that their
    spread is often nearly zero.
    """
    rng, n = np.random.default_rng(0), len(values)
    kept, batch = n - 2 * int(trim * n), max(1, BATCH // n)
    centre, error = _standard_error(values, trim)
    ratios = []
    for start in range(0, RESAMPLES, batch):
        index = rng.integers(n, size=(min(batch, RESAMPLES - start), n))
        resampled, errors = _standard_error(values[index], trim)
        endless = np.copysign(np.inf, resampled - centre)
        ratios.append(np.divide(resampled - centre, errors, out=endless, where=errors > 0))
    ratio = np.concatenate(ratios)
    below = np.quantile(ratio, TAIL, method="lower")
    above = np.quantile(ratio, 1 - TAIL, method="higher")
    if kept < 6 or not np.isfinite([below, above]).all():
        below, above = special.stdtrit(kept - 1, [TAIL, 1 - TAIL])
    return float(centre - above * error), float(centre - below * error)


def _standard_error(values: Table, trim: float) -> tuple[Table, Table]:
    """Returns the trimmed mean of values (..., n), n > 1, and its standard error."""
    centre, own = influence(values, trim)
    return centre, own.std(axis=-1, ddof=1) / np.sqrt(own.shape[-1])
