"""Estimates with intervals for policies that meet the same episodes, honest about training seeds.

A table holds one number for each training seed and episode, shape (S, E): S is 1 for a scripted
policy, E the same for all, and column e the same episode in every table. The numbers of a column
resemble each other, because an episode may be hard, and so do those of a row, because a training
may fail. Both are sources of variance here: S runs of an episode are not S episodes, and E runs of
a training are not E trainings.

Tables of two policies that are compared are paired as (S1, S2, E), with one number for each pair of
trainings and each episode.

Each interval has the level 0.95 on its own, without a correction for multiple comparisons. The
lowest coverage in the simulations of ``tests/test_statistics.py`` is 93 % with five trainings, 92 %
with three and 87 % with two. It is lower still where trainings differ with a skew, such as a rare
collapse: no interval can account for what was never seen.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special, stats

Table = NDArray[np.float64]
Statistic = Literal["mean", "iqm"]

LEVEL = 0.95  #: level of all intervals
TAIL = (1 - LEVEL) / 2  #: probability beyond either bound
RESAMPLES = 2000  #: number of bootstrap resamples
BATCH = 1_000_000  #: number of resampled values that are held at once: 8 MB an array
TRIM = {"mean": 0.0, "iqm": 0.25}  #: fraction of the values that each statistic drops at either end
ROUNDING = 1e-15  #: variance of a share below which it is zero; one failure in 50,000 has 4e-10
REFUSED: dict[str, tuple[Callable[[Table], NDArray[np.bool_]], str]] = {
    "values": (np.isinf, "hold infinity; put NaN where nothing applies"),
    "scores": (np.isnan, "hold NaN; give a failure +inf"),
    "success": (lambda table: ~np.isin(table, (0, 1)), "must be 0 or 1 everywhere, never NaN"),
}
"""What a table of each kind may not hold, and the remedy."""


@dataclass(frozen=True)
class Estimate:
    """A value with its interval, in the unit of the data."""

    value: float | None  #: estimate; None where there are no data
    low: float | None  #: lower bound; None where the data do not tell
    high: float | None  #: upper bound, likewise
    n: int  #: number of episodes on which it rests, each counted once for any number of trainings


def iqm(x: ArrayLike, axis: int | None = None) -> Table:
    """Returns the mean of the middle half of the values (Agarwal et al. 2021, NeurIPS)."""
    return stats.trim_mean(x, TRIM["iqm"], axis=axis)


def mean(values: ArrayLike) -> Estimate:
    """Returns the mean of values (S, E) over episodes, then over trainings.

    Values are NaN where they do not apply; a training without any value is left out. The interval
    of one training is a bootstrap-t over the episodes, that of several is Student's t with the
    crossed variance. Bounds are None for a single episode, for values that are all the same, and
    where one training is left of several.
    """
    return _location(_table(values, "values")[:, None], "mean")


def interquartile_mean(values: ArrayLike) -> Estimate:
    """Returns the interquartile mean of values (S, E), with an interval as that of ``mean``."""
    return _location(_table(values, "values")[:, None], "iqm")


def difference(first: ArrayLike, second: ArrayLike, statistic: Statistic = "mean") -> Estimate:
    """Returns the statistic of the differences first (S1, E) minus second (S2, E).

    Differences are taken within an episode where both values apply (NaN where one does not), for
    each training of the one with each of the other: what makes an episode hard for both cancels.
    """
    return _location(np.subtract(*_paired(first, second, "values")), statistic)


def proportion(success: ArrayLike) -> Estimate:
    """Returns the share of successes (S, E), 0 or 1, with Wilson's interval (1927, JASA 22).

    Its coverage is 0.95 on average over shares from 0.1 to 0.95, but not everywhere: it is 0.92
    for a share of 0.99 and a hundred episodes.

    With several trainings, the number of episodes is replaced by the number of independent
    episodes that would have the crossed variance, and the normal quantile by Student's t. If all
    succeed or all fail, the data do not tell how trainings differ: every episode then counts once.
    """
    table = _table(success, "success")
    share, (seeds, episodes) = float(table.mean()), table.shape
    variance, quantile = _sampling(table[:, None])
    count = min(share * (1 - share) / variance, seeds * episodes) if variance else episodes
    weight = quantile**2 / count
    centre = (share + weight / 2) / (1 + weight)
    half = np.sqrt(weight * share * (1 - share) + weight**2 / 4) / (1 + weight)
    return Estimate(share, max(0.0, float(centre - half)), min(1.0, float(centre + half)), episodes)


def difference_in_success(first: ArrayLike, second: ArrayLike) -> Estimate:
    """Returns the success rate of first (S1, E), 0 or 1, minus that of second (S2, E), paired."""
    one, other = _paired(first, second, "success")
    return Estimate(*_net(one - other), one.shape[2])


def improvement(first: ArrayLike, second: ArrayLike) -> Estimate:
    """Returns the probability that first (S1, E) beats second (S2, E) in an episode.

    It is that of Agarwal et al. (2021), but within episodes. The smaller score wins; a failure is
    +inf, and two failures tie. A tie counts one half: the probability is
    (1 + wins - losses) / 2, and the bounds follow in the same way.
    """
    one, other = _paired(first, second, "scores")
    value, low, high = _net(np.subtract(one < other, one > other, dtype=float))
    return Estimate((1 + value) / 2, (1 + low) / 2, (1 + high) / 2, one.shape[2])


def mcnemar(first: ArrayLike, second: ArrayLike) -> float:
    """Returns McNemar's exact two-sided p-value for successes (E,) of two policies.

    Under the null hypothesis that both succeed equally often, every episode in which exactly one
    succeeds is a toss of a fair coin (1947, Psychometrika 12). The test compares two single
    policies, without regard to training seeds.
    """
    one, other = _paired(np.asarray(first)[None], np.asarray(second)[None], "success")
    wins, losses = int((one > other).sum()), int((one < other).sum())
    return float(stats.binomtest(wins, wins + losses).pvalue) if wins + losses else 1.0


def profile(scores: ArrayLike, at: ArrayLike) -> tuple[Table, Table, Table]:
    """Returns the share of scores (S, E) up to each of the levels at (T,), and its bounds, (T,).

    It is the performance profile of Dolan and Moré (2002, Math. Program. 91), with the pointwise
    intervals of ``proportion``. A failure, +inf, is above every level.
    """
    table = _table(scores, "scores")
    points = [proportion(table <= level) for level in np.atleast_1d(at)]
    share, low, high = np.array([(p.value, p.low, p.high) for p in points], float).reshape(-1, 3).T
    return share, low, high


def _location(table: Table, statistic: Statistic) -> Estimate:
    """Returns the mean or interquartile mean of (S1, S2, E), NaN where values do not apply."""
    trainings, present = table.shape[:2], ~np.isnan(table)
    table = table[np.ix_(*(present.any(axis) for axis in ((1, 2), (0, 2), (0, 1))))]
    if not table.size:
        return Estimate(None, None, None, 0)
    pseudo = pseudo_values(table, TRIM[statistic])
    n, value = table.shape[2], float(np.nanmean(pseudo))
    lost = any(was > 1 == now for was, now in zip(trainings, table.shape, strict=False))
    if n == 1 or lost or np.nanmin(pseudo) == np.nanmax(pseudo):
        return Estimate(value, None, None, n)
    if table.shape[:2] == (1, 1):
        return Estimate(value, *bootstrap_bounds(table[0, 0], TRIM[statistic]), n)
    variance, freedom = crossed_variance(pseudo)
    half = float(special.stdtrit(freedom, 1 - TAIL)) * variance**0.5
    return Estimate(value, value - half, value + half, n)


def _sampling(table: Table) -> tuple[float, float]:
    """Returns the variance of the mean of shares (S1, S2, E), and the quantile of its interval."""
    if table.shape[:2] == (1, 1) or table.shape[2] == 1:
        return float(table.var()) / table.shape[2], float(special.ndtri(1 - TAIL))
    variance, freedom = crossed_variance(table)
    return variance if variance > ROUNDING else 0.0, float(special.stdtrit(freedom, 1 - TAIL))


def _net(sign: Table) -> tuple[float, float, float]:
    """Returns the mean of signs (S1, S2, E) in {-1, 0, 1}, wins less losses, and its bounds.

    The interval is the adjusted Wald interval of Bonett and Price (2012, J. Educ. Behav. Stat.
    37): one win and one loss are added to the episodes, or, with several trainings, to the number
    of independent episodes that would have the crossed variance.
    """
    (first, second, episodes), net = sign.shape, float(sign.mean())
    variance, quantile = _sampling(sign)
    spread, most = float((sign**2).mean()) - net**2, 2 * episodes / (1 / first + 1 / second)
    count = min(spread / variance, most) if variance else episodes
    square = count**2 * variance + 2 * (1 + net**2 * count / (count + 2))
    centre, half = net * count / (count + 2), quantile * square**0.5 / (count + 2)
    return net, max(-1.0, centre - half), min(1.0, centre + half)


def _table(data: ArrayLike, kind: str) -> Table:
    """Returns data as a table (S, E), or refuses what a kind of ``REFUSED`` may not hold."""
    table = np.asarray(data, dtype=float)
    if table.ndim != 2 or not table.size:
        raise ValueError(
            f"{kind} of shape {table.shape} must be (training seeds, episodes) and not empty; "
            "a scripted policy has one row"
        )
    refused, remedy = REFUSED[kind]
    if refused(table).any():
        raise ValueError(f"{kind} of shape {table.shape} {remedy}")
    return table


def _paired(first: ArrayLike, second: ArrayLike, kind: str) -> tuple[Table, Table]:
    """Returns tables (S1, E) and (S2, E) as (S1, 1, E) and (1, S2, E), paired by episode."""
    one, other = _table(first, kind), _table(second, kind)
    if one.shape[1] != other.shape[1]:
        raise ValueError(
            f"{kind} of shapes {one.shape} and {other.shape} must be of the same episodes, one a "
            "column; leave out those that only one of them met"
        )
    return one[:, None], other[None]


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
    n, whole = table.shape[2], ~np.isnan(table).any(axis=2)
    statistic, own = influence(table[whole], trim)
    pseudo[whole] = statistic[:, None] + own
    for row in np.argwhere(~whole):
        pair = tuple(row)
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
