"""Intervals for policies that meet the same episodes, honest about training seeds.

A table holds one number for each training seed and episode, shape (S, E): S is 1 for a scripted
policy, E the same for all, and column e the same episode in every table. Numbers of one column
resemble each other, for an episode may be hard, and so do those of one row, for a training may go
wrong. So both are sources of variance here: S runs of an episode are not S episodes, and E runs
of a training are not E trainings.

Each interval holds at ``LEVEL`` on its own; nothing corrects for looking at many. What they cover
is measured in ``tests/test_statistics.py``: with five trainings at worst one or two points in a
hundred less, with three three and with two eight; or more where trainings differ skewly, say with
a rare collapse, for no interval knows what was never seen.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special, stats

Statistic = Literal["mean", "iqm"]
Table = NDArray[np.float64]

LEVEL = 0.95
TAIL = (1 - LEVEL) / 2
RESAMPLES = 2000
TRIM = {"mean": 0.0, "iqm": 0.25}
"""Share of the values that each statistic drops at either end."""
BATCH = 1_000_000  # resampled numbers held at once: 8 MB an array
ROUNDING = 1e-15  # of the variance of a share; one failure in 5 x 10,000 runs makes 4e-10

REFUSED: dict[str, tuple[Callable[[Table], NDArray[np.bool_]], str]] = {
    "values": (np.isinf, "hold infinity; put NaN where nothing applies"),
    "scores": (np.isnan, "hold NaN; give a failure +inf"),
    "success": (lambda table: ~np.isin(table, (0, 1)), "must be 0 or 1 everywhere, never NaN"),
}
"""What a table of each kind may not hold, and the remedy."""


@dataclass(frozen=True)
class Estimate:
    """A value and the bounds of its interval, in the unit of the data; None where they cannot tell.

    The number n counts the episodes it rests on, each once, whatever the number of trainings.
    """

    value: float | None
    low: float | None
    high: float | None
    n: int


def iqm(x: ArrayLike, axis: int | None = None) -> Table:
    """Interquartile mean, of the middle half of the values (Agarwal et al. 2021, NeurIPS)."""
    return stats.trim_mean(x, TRIM["iqm"], axis=axis)


def mean(values: ArrayLike) -> Estimate:
    """Mean over the episodes of values (S, E), NaN where they do not apply, then over trainings.

    One training: bootstrap-t over the episodes. Several: Student's t with the crossed variance. A
    training in which nothing applies is left out. Bounds are None for a single episode, for values
    that are all the same, and where one training is left of several.
    """
    return _location(_table(values, "values")[:, None], "mean")


def interquartile_mean(values: ArrayLike) -> Estimate:
    """Interquartile mean over the episodes of values (S, E), then over trainings; see mean."""
    return _location(_table(values, "values")[:, None], "iqm")


def difference(first: ArrayLike, second: ArrayLike, statistic: Statistic = "mean") -> Estimate:
    """Statistic of the differences first (S1, E) minus second (S2, E), NaN as in mean.

    They are taken within an episode where both apply, for each training of the one with each of
    the other: what makes an episode hard for both cancels.
    """
    return _location(np.subtract(*_against(first, second, "values")), statistic)


def proportion(success: ArrayLike) -> Estimate:
    """Share of successes (S, E), 0 or 1, with Wilson's interval (1927, JASA 22).

    Over shares from 0.1 to 0.95 it covers 0.95 on average, but not everywhere: of a hundred
    episodes and a share of 0.99, 0.92.

    With several trainings it takes the number of independent episodes that would have the crossed
    variance, and Student's t. If all succeed or all fail nothing tells how alike the trainings
    are: it then counts every episode once.
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
    """Success rate of first (S1, E) minus that of second (S2, E), 0 or 1, within episodes."""
    one, other = _against(first, second, "success")
    return Estimate(*_net(one - other), one.shape[2])


def improvement(first: ArrayLike, second: ArrayLike) -> Estimate:
    """Probability that first (S1, E) beats second (S2, E) in an episode, a tie being one half.

    Agarwal et al. (2021), but within episodes. The smaller score is the better; a failure is
    +inf, and two failures tie. It is (1 + wins - losses) / 2, and so is its interval.
    """
    one, other = _against(first, second, "scores")
    value, low, high = _net(np.subtract(one < other, one > other, dtype=float))
    return Estimate((1 + value) / 2, (1 + low) / 2, (1 + high) / 2, one.shape[2])


def mcnemar(first: ArrayLike, second: ArrayLike) -> float:
    """Exact two-sided p that two policies succeed equally often, from successes (E,) of each.

    McNemar (1947, Psychometrika 12): if so, every episode in which just one succeeds is a toss of
    a fair coin. It knows of no training seeds: it compares two single policies.
    """
    one, other = _against(np.asarray(first)[None], np.asarray(second)[None], "success")
    wins, losses = int((one > other).sum()), int((one < other).sum())
    return float(stats.binomtest(wins, wins + losses).pvalue) if wins + losses else 1.0


def profile(scores: ArrayLike, at: ArrayLike) -> tuple[Table, Table, Table]:
    """Share of scores (S, E) no greater than each of at (T,), with pointwise bounds, each (T,).

    The performance profile of Dolan and Moré (2002, Math. Program. 91) with intervals as by
    proportion. A failure, +inf, is never within.
    """
    table = _table(scores, "scores")
    points = [proportion(table <= level) for level in np.atleast_1d(at)]
    share, low, high = np.array([(p.value, p.low, p.high) for p in points], float).reshape(-1, 3).T
    return share, low, high


def influence(values: ArrayLike, trim: float) -> tuple[Table, Table]:
    """Trimmed mean of values (..., n), and how much each of them moves it, (..., n).

    Statistic plus influence make pseudo-values, which vary as the statistic does: their standard
    error is that of Tukey and McLaughlin (1963, Sankhya A 25), from the winsorised values. Without
    a trim they are the values themselves.
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
    """Variance of the mean of (S1, S2, E), NaN left out, and its degrees of freedom; E > 1.

    Two-way random effects of trainings and episodes without replication. The variance between
    episodes holds the residual already: each policy with several trainings adds what lies between
    them beyond the residual, and never less than nothing, whence intervals are somewhat wide where
    trainings do not differ. Freedom by Satterthwaite (1946, Biometrics Bulletin 2).
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
            if between > within * (1 + 1e-9):  # lest rounding decides where they are equal
                total += between - within
                scatter += between**2 / (seeds - 1) + within**2 / freedom
                least = min(least, seeds - 1)
    return total, max(total**2 / scatter, least) if scatter else np.inf


def _location(table: Table, statistic: Statistic) -> Estimate:
    """Estimate of a mean or interquartile mean from (S1, S2, E), NaN where it does not apply."""
    trainings, present = table.shape[:2], ~np.isnan(table)
    table = table[np.ix_(*(present.any(axis) for axis in ((1, 2), (0, 2), (0, 1))))]
    if not table.size:
        return Estimate(None, None, None, 0)
    pseudo = _spread_out(table, TRIM[statistic])
    n, value = table.shape[2], float(np.nanmean(pseudo))
    lost = any(was > 1 == now for was, now in zip(trainings, table.shape, strict=False))
    if n == 1 or lost or np.nanmin(pseudo) == np.nanmax(pseudo):
        return Estimate(value, None, None, n)
    if table.shape[:2] == (1, 1):
        return Estimate(value, *_bootstrap(table[0, 0], TRIM[statistic]), n)
    variance, freedom = crossed_variance(pseudo)
    half = float(special.stdtrit(freedom, 1 - TAIL)) * variance**0.5
    return Estimate(value, value - half, value + half, n)


def _spread_out(table: Table, trim: float) -> Table:
    """Pseudo-values of each row of (S1, S2, E): the statistic where one is missing, NaN if all."""
    pseudo = np.full(table.shape, np.nan)
    n = table.shape[2]
    for pair in np.ndindex(table.shape[:2]):
        present = ~np.isnan(table[pair])
        if m := int(present.sum()):
            pseudo[pair], own = influence(table[pair][present], trim)
            pseudo[pair][present] += np.sqrt(n * (n - 1) / (m * max(m - 1, 1))) * own
    return pseudo


def _bootstrap(values: Table, trim: float) -> tuple[float, float]:
    """Bootstrap-t bounds of the trimmed mean of values (n,), n > 1 (Efron 1981; Hall 1988).

    It follows the skew of times and distances at small n, where percentile and BCa intervals lack
    up to five points in a hundred. Student's t takes its place where resamples have no spread to
    divide by, and for so few values that they often nearly have none.
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
    """Trimmed mean of values (..., n), n > 1, and its standard error."""
    centre, own = influence(values, trim)
    return centre, own.std(axis=-1, ddof=1) / np.sqrt(own.shape[-1])


def _sampling(table: Table) -> tuple[float, float]:
    """Variance of the mean of shares (S1, S2, E), and the quantile that goes with it."""
    if table.shape[:2] == (1, 1) or table.shape[2] == 1:
        return float(table.var()) / table.shape[2], float(special.ndtri(1 - TAIL))
    variance, freedom = crossed_variance(table)
    return variance if variance > ROUNDING else 0.0, float(special.stdtrit(freedom, 1 - TAIL))


def _net(sign: Table) -> tuple[float, float, float]:
    """Share of wins less that of losses in sign (S1, S2, E) of -1, 0 and 1, and its bounds.

    The adjusted Wald interval of Bonett and Price (2012, J. Educ. Behav. Stat. 37): one win and
    one loss are added, so that it has a width where all episodes go one way. With several
    trainings they are added to the number of independent episodes that would have the crossed
    variance: no more than policies alike in all their runs could amount to, and the episodes
    themselves where there is no variance.
    """
    (first, second, episodes), net = sign.shape, float(sign.mean())
    variance, quantile = _sampling(sign)
    spread, most = float((sign**2).mean()) - net**2, 2 * episodes / (1 / first + 1 / second)
    count = min(spread / variance, most) if variance else episodes
    square = count**2 * variance + 2 * (1 + net**2 * count / (count + 2))
    centre, half = net * count / (count + 2), quantile * square**0.5 / (count + 2)
    return net, max(-1.0, centre - half), min(1.0, centre + half)


def _table(data: ArrayLike, kind: str) -> Table:
    """Data of a kind in ``REFUSED`` as (S, E)."""
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


def _against(first: ArrayLike, second: ArrayLike, kind: str) -> tuple[Table, Table]:
    """Tables (S1, E) and (S2, E) as (S1, 1, E) and (1, S2, E), to be compared within episodes."""
    one, other = _table(first, kind), _table(second, kind)
    if one.shape[1] != other.shape[1]:
        raise ValueError(
            f"{kind} of shapes {one.shape} and {other.shape} must be of the same episodes, one a "
            "column; leave out those that only one of them met"
        )
    return one[:, None], other[None]
