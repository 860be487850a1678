"""The statistics against published and hand-worked cases, their symmetries, and what they cover."""

import itertools
from dataclasses import astuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from baselines.evaluate import statistics
from baselines.evaluate.statistics import (
    Estimate,
    crossed_variance,
    difference,
    difference_in_success,
    improvement,
    influence,
    interquartile_mean,
    iqm,
    mcnemar,
    mean,
    profile,
    proportion,
)

NAN, INF = np.nan, np.inf
NOTHING = Estimate(None, None, None, 0)
HONEST = (0.93, 0.97)
"""What an interval of 95 % may cover by simulation."""
WIDE = (0.95, 0.99)
"""What it covers where trainings do not differ, and it cannot know: see crossed_variance."""


def bounds(estimate):
    return estimate.low, estimate.high


def outcomes(successes, n):
    return [np.arange(n) < successes]


# Published and hand-worked cases


@pytest.mark.parametrize(
    ("successes", "n", "low", "high"),
    [
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0, 0.1611),
        (1, 29, 0.0061, 0.1718),
    ],
)
def test_wilson_as_in_newcombe_1998(successes, n, low, high):
    estimate = proportion(outcomes(successes, n))
    assert (estimate.value, estimate.n) == (pytest.approx(successes / n), n)
    assert bounds(estimate) == pytest.approx((low, high), abs=5e-5)


def test_wilson_of_eight_in_ten_and_its_mirror():
    assert bounds(proportion(outcomes(8, 10))) == pytest.approx((0.490162, 0.943318), abs=1e-6)
    assert bounds(proportion(outcomes(2, 10))) == pytest.approx((0.056682, 0.509838), abs=1e-6)


def test_mcnemar_counts_discordant_episodes():
    first, second = np.repeat([[1, 0], [0, 1], [1, 1], [0, 0]], [1, 8, 30, 5], axis=0).T
    assert mcnemar(first, second) == pytest.approx(2 * (1 + 9) / 2**9)
    assert mcnemar(second, first) == mcnemar(first, second)
    assert mcnemar(first, first) == 1


def test_bonett_price_of_bentur_2009():
    # 21 pairs, of which 1 and 7 are discordant (in Fagerland et al. 2014, Stat. Med. 33)
    first, second = np.repeat([[1, 1], [1, 0], [0, 1], [0, 0]], [1, 1, 7, 12], axis=0).T
    estimate = difference_in_success([first], [second])
    plus, minus = 2 / 23, 8 / 23
    half = 1.959964 * np.sqrt((plus + minus - (plus - minus) ** 2) / 23)
    assert estimate.value == pytest.approx(-6 / 21)
    assert bounds(estimate) == pytest.approx((-6 / 23 - half, -6 / 23 + half))
    assert bounds(estimate) == pytest.approx((-0.508, -0.013), abs=5e-4)


def test_interquartile_mean_drops_a_quarter_at_either_end():
    assert iqm(np.arange(1, 9)) == 4.5
    assert iqm([[0, 1, 2, 1000], [5, 5, 7, 9]], axis=1) == pytest.approx([1.5, 6])
    assert interquartile_mean([[-1000, 3, 4, 1000]]).value == 3.5


def test_standard_error_of_a_trimmed_mean():
    # 1..8 winsorised are 3 3 3 4 5 6 6 6, whose squares about 4.5 sum to 14; four are kept
    statistic, moved = influence(np.arange(1.0, 9), 0.25)
    assert statistic == 4.5
    assert moved.sum() == pytest.approx(0)
    assert moved.var(ddof=1) / 8 == pytest.approx(14 / (4 * 3))
    assert influence([1.0, 2, 6], 0)[1] == pytest.approx([-2, -1, 3])


def test_crossed_variance_of_two_trainings_and_three_episodes():
    # Rows average 2 and 4, columns 2, 2 and 5; mean squares are 6 (trainings), 6 (episodes) and 2.
    table = np.array([[1.0, 2, 3], [3, 2, 7]])
    variance, freedom = crossed_variance(table[:, None])
    assert variance == pytest.approx((6 + 6 - 2) / 6)
    assert freedom == pytest.approx((10 / 6) ** 2 / (1**2 / 2 + 1**2 / 1 + (2 / 6) ** 2 / 2))
    half = stats.t.ppf(0.975, freedom) * np.sqrt(10 / 6)
    assert astuple(mean(table)) == pytest.approx((3, 3 - half, 3 + half, 3))
    assert crossed_variance(table[None]) == pytest.approx((variance, freedom))


def test_trainings_that_differ_less_than_their_residual_add_nothing():
    table = np.array([[1.0, 2, 3], [3, 2, 1.5]])  # columns average 2, 2 and 2.25
    assert crossed_variance(table[:, None]) == pytest.approx((1 / 48 / 3, 2))


def test_difference_has_the_trainings_of_both_and_the_episodes_once():
    rng = np.random.default_rng(0)
    hard = rng.normal(size=40)
    tables = [hard + rng.normal(size=(s, 1)) + rng.normal(size=(s, 40)) for s in (3, 5)]
    estimate = difference(*tables)
    gap = tables[0].mean(0) - tables[1].mean(0)
    variance, scatter = gap.var(ddof=1) / 40, (gap.var(ddof=1) / 40) ** 2 / 39
    for table in tables:
        seeds, rows, columns = len(table), table.mean(1), table.mean(0)
        error = ((table - rows[:, None] - columns + table.mean()) ** 2).sum() / (seeds - 1) / 39
        between, within = rows.var(ddof=1) / seeds, error / seeds / 40
        variance += between - within
        scatter += between**2 / (seeds - 1) + within**2 / (seeds - 1) / 39
    half = stats.t.ppf(0.975, variance**2 / scatter) * np.sqrt(variance)
    assert estimate.value == pytest.approx(tables[0].mean() - tables[1].mean())
    assert bounds(estimate) == pytest.approx((estimate.value - half, estimate.value + half))


def test_improvement_counts_ties_half_and_failures_as_ties():
    #           win tie tie  loss win
    first = [[1, 2, INF, INF, 3]]
    second = [[2, 2, INF, 5, INF]]
    assert improvement(first, second).value == pytest.approx(0.6)
    assert improvement([[1, 3]], [[2, 2], [4, 4]]).value == pytest.approx(0.75)


def test_profile_is_a_share_of_episodes_and_never_counts_failures():
    scores = np.array([[1, 2, 2, INF], [1, 3, INF, INF]])
    share, low, high = profile(scores, [0, 1, 2, 3, 1e9])
    assert share == pytest.approx([0, 2 / 8, 4 / 8, 5 / 8, 5 / 8])
    estimate = proportion(scores <= 2)
    assert (low[2], high[2]) == bounds(estimate)


# What there is to say of little, of nothing and of all the same


@pytest.mark.parametrize("average", [mean, interquartile_mean])
def test_bounds_are_none_where_the_data_cannot_tell(average):
    assert average([[NAN, NAN]]) == NOTHING
    assert average([[NAN, 3.0]]) == Estimate(3, None, None, 1)
    assert average([[3.0], [5.0]]) == Estimate(4, None, None, 1)
    same(average([[0.1] * 7] * 3), Estimate(0.1, None, None, 7))
    assert average([[NAN] * 4, [1.0, 2, 3, NAN]]) == Estimate(2, None, None, 3)
    assert difference([[1.0, NAN]], [[NAN, 1.0]]) == NOTHING


def test_differences_are_taken_where_both_apply():
    first, second = [[1.0, NAN, 5, 4, 9]], [[0.0, 7, NAN, 2, 6]]
    assert difference(first, second).value == pytest.approx((1 + 2 + 3) / 3)
    assert difference(first, second).n == 3
    both = difference([*first, [NAN, 8.0, NAN, NAN, NAN]], second)
    assert (both.value, both.n) == (pytest.approx((2 + 1) / 2), 4)


def test_a_mean_over_trainings_weighs_them_alike():
    table = np.array([[1.0, NAN, NAN, 3], [4, 5, 6, 9], [NAN] * 4, [0, NAN, 1, 2]])
    estimate = mean(table)
    assert estimate.value == pytest.approx((2 + 6 + 1) / 3)
    assert mean(table[[0, 1, 3]]) == estimate
    assert estimate.low < estimate.value < estimate.high


def test_no_width_vanishes_where_all_episodes_go_one_way():
    ones, far = np.ones((1, 20)), np.zeros((5, 20))
    assert bounds(improvement(far[:1], ones)) == (pytest.approx(0.867, abs=1e-3), 1)
    assert bounds(improvement(far, ones)) == bounds(improvement(far[:1], ones))
    assert bounds(difference_in_success(ones, ones)) == pytest.approx((-0.126, 0.126), abs=1e-3)
    assert bounds(proportion(np.ones((5, 20)))) == pytest.approx((20 / (20 + 1.959964**2), 1))


def test_copies_of_a_run_are_not_more_episodes():
    run = outcomes(70, 100)
    one, five = proportion(run), proportion(np.repeat(run, 5, axis=0))
    assert one.high - one.low < five.high - five.low < 1.03 * (one.high - one.low)
    times = np.random.default_rng(0).normal(size=(1, 100))
    five = mean(np.repeat(times, 5, axis=0))
    assert five.high - five.low == pytest.approx(2 * 1.984 * times.std(ddof=1) / 10, rel=1e-3)


def test_a_long_comparison_fits_in_memory_and_is_made_again_exactly():
    times = np.random.default_rng(0).gamma(2, size=(1, 2000))
    assert interquartile_mean(times) == interquartile_mean(times)
    assert mean(times).n == 2000


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: mean([1.0, 2]), r"\(2,\) must be \(training seeds, episodes\)"),
        (lambda: mean(np.empty((1, 0))), r"\(1, 0\) .* not empty"),
        (lambda: mean([[INF]]), "put NaN where nothing applies"),
        (lambda: proportion([[1, NAN]]), "must be 0 or 1 everywhere"),
        (lambda: proportion([[0.5]]), "must be 0 or 1 everywhere"),
        (lambda: improvement([[NAN]], [[1]]), r"give a failure \+inf"),
        (lambda: difference([[1, 2]], [[1]]), r"\(1, 2\) and \(1, 1\) must be of the same"),
        (lambda: difference_in_success([[1]], [[1, 0]]), r"\(1, 1\) and \(1, 2\)"),
        (lambda: mcnemar([1], [1, 0]), r"\(1, 1\) and \(1, 2\)"),
        (lambda: profile([[NAN]], [1]), r"give a failure \+inf"),
    ],
)
def test_data_of_the_wrong_form_are_refused(call, said):
    with pytest.raises(ValueError, match=said):
        call()


# Symmetries


@st.composite
def pairs(draw, numbers):
    """Two tables of the same episodes."""
    episodes = draw(st.integers(2, 12))
    rows = st.lists(numbers, min_size=episodes, max_size=episodes)
    return tuple(np.array(draw(st.lists(rows, min_size=1, max_size=3)), float) for _ in range(2))


VALUES = st.integers(-40, 40).map(lambda k: k / 8) | st.just(NAN)
SCORES = st.integers(0, 5).map(float) | st.just(INF)
SUCCESS = st.sampled_from([0.0, 1.0])


def same(one, other):
    """Whether two estimates agree but for rounding."""
    assert one.n == other.n
    for a, b in itertools.zip_longest(astuple(one)[:3], astuple(other)[:3]):
        assert (a is None) == (b is None)
        assert a is None or a == pytest.approx(b, abs=1e-9)


def turned(estimate, about=0.0):
    """The estimate of about minus what was estimated."""
    value, low, high = (None if x is None else about - x for x in astuple(estimate)[:3])
    return Estimate(value, high, low, estimate.n)


@settings(max_examples=60, deadline=None)
@given(pairs(VALUES), st.sampled_from(["mean", "iqm"]))
def test_swapping_policies_negates_their_difference(tables, statistic):
    one, other = tables
    same(difference(one, other, statistic), turned(difference(other, one, statistic)))


@settings(max_examples=60, deadline=None)
@given(pairs(VALUES), st.sampled_from([mean, interquartile_mean]), st.integers(-9, 9))
def test_averages_shift_and_scale_with_the_data(tables, average, shift):
    table, _ = tables
    estimate = average(table)
    value, low, high = (None if x is None else 4 * x + shift for x in astuple(estimate)[:3])
    same(average(4 * table + shift), Estimate(value, low, high, estimate.n))


@given(pairs(SUCCESS))
def test_swapping_policies_negates_the_difference_in_success(tables):
    one, other = tables
    estimate = difference_in_success(one, other)
    same(estimate, turned(difference_in_success(other, one)))
    assert -1 <= estimate.low <= estimate.value <= estimate.high <= 1


@given(pairs(SUCCESS))
def test_failures_are_what_is_not_success(tables):
    table, _ = tables
    estimate = proportion(table)
    same(estimate, turned(proportion(1 - table), about=1))
    assert 0 <= estimate.low <= estimate.value <= estimate.high <= 1


@given(pairs(SCORES))
def test_one_policy_improves_as_often_as_the_other_does_not(tables):
    one, other = tables
    same(improvement(one, other), turned(improvement(other, one), about=1))
    same(improvement(one, other), improvement(2 * one, 2 * other))


@given(pairs(SCORES))
def test_the_order_of_episodes_and_of_trainings_does_not_matter(tables):
    one, other = tables
    same(improvement(one, other), improvement(one[::-1, ::-1], other[:, ::-1]))
    same(proportion(one < 3), proportion(one[::-1, ::-1] < 3))


# Coverage by simulation


def covered(study, truth, repetitions):
    """Share of simulated studies, each study(rng) -> Estimate, whose interval holds the truth."""
    rng = np.random.default_rng(11)
    return np.mean([e.low <= truth <= e.high for e in (study(rng) for _ in range(repetitions))])


def assert_honest(study, truth, within=HONEST, repetitions=1000):
    share = covered(study, truth, repetitions)
    assert within[0] <= share <= within[1], share


@pytest.fixture
def _fewer_resamples(monkeypatch):
    monkeypatch.setattr(statistics, "RESAMPLES", 400)


def normal_table(rng, seeds, hard, spread):
    """Values (seeds, E) of standard deviations spread: of trainings, of episodes, of the rest."""
    training, episode, rest = spread
    trained = training * rng.normal(size=(seeds, 1)) * (seeds > 1)  # a scripted policy has none
    return trained + episode * hard + rest * rng.normal(size=(seeds, hard.size))


def probit_table(rng, seeds, hard, spread, ease):
    """Successes (seeds, E) where latent values as those of normal_table exceed -ease."""
    return ease + normal_table(rng, seeds, hard, spread) > 0


def likely(seeds, spread, ease):
    """Probability of a success in probit_table."""
    return stats.norm.cdf(ease / np.linalg.norm(spread if seeds > 1 else spread[1:]))


def exactly(estimates, shares):
    """What the intervals of 0, 1 ... successes cover, by share (P,), enumerating the binomial."""
    low, high = np.array([bounds(estimate) for estimate in estimates]).T
    count = np.arange(len(low))
    share = np.reshape(shares, (-1, 1))
    chance = stats.binom.pmf(count, count[-1], share)
    return (chance * (low <= share) * (share <= high)).sum(axis=1)


SHARES = np.linspace(0.1, 0.95, 1001)


def test_wilson_covers_on_average_and_not_near_one():
    wilson = [proportion(outcomes(k, 100)) for k in range(101)]
    covers = exactly(wilson, SHARES)
    assert covers.mean() == pytest.approx(0.951, abs=0.001)
    assert covers.min() > 0.92
    assert exactly(wilson, 0.99) == pytest.approx(0.921, abs=0.001)


def test_improvement_without_ties_covers_on_average():
    wins = [improvement(np.logical_not(outcomes(k, 100)), [[0.5] * 100]) for k in range(101)]
    covers = exactly(wins, SHARES)
    assert covers.mean() == pytest.approx(0.950, abs=0.001)
    assert covers.min() > 0.93
    assert exactly(wins, 0.99) > 0.99


def middle(distribution, partial):
    """Mean of the middle half, from partial(q), the expectation of what lies below q."""
    return 2 * (partial(distribution.ppf(0.75)) - partial(distribution.ppf(0.25)))


LOGNORMAL, GAMMA = stats.lognorm(0.5), stats.gamma(2)
MIDDLE_LOGNORMAL = middle(
    LOGNORMAL, lambda q: LOGNORMAL.mean() * stats.norm.cdf(np.log(q) / 0.5 - 0.5)
)
MIDDLE_GAMMA = middle(GAMMA, lambda q: 2 * stats.gamma(3).cdf(q))
SKEWED = [
    (mean, lambda rng, n: rng.lognormal(0, 0.5, (1, n)), LOGNORMAL.mean()),
    (mean, lambda rng, n: rng.gamma(2, size=(1, n)), 2),
    (interquartile_mean, lambda rng, n: rng.lognormal(0, 0.5, (1, n)), MIDDLE_LOGNORMAL),
    (interquartile_mean, lambda rng, n: rng.gamma(2, size=(1, n)), MIDDLE_GAMMA),
]


@pytest.mark.usefixtures("_fewer_resamples")
@pytest.mark.parametrize("n", [20, 100])
@pytest.mark.parametrize(("average", "times", "truth"), SKEWED)
def test_averages_of_skewed_times(average, times, truth, n):
    assert_honest(lambda rng: average(times(rng, n)), truth)


@pytest.mark.usefixtures("_fewer_resamples")
@pytest.mark.parametrize("statistic", ["mean", "iqm"])
def test_differences_of_correlated_times_some_missing(statistic):
    def study(rng):
        easy = rng.lognormal(0, 0.5, 100)
        one, other = (easy * rng.lognormal(0, 0.3, (1, 100)) for _ in range(2))
        other[rng.random(other.shape) < 0.2] = NAN
        return difference(one, other, statistic)

    assert_honest(study, 0)


SPREADS = [(1, 1, 1), (0.2, 1, 1), (0, 1, 1), (1, 0, 1), (1, 1, 0)]


@pytest.mark.parametrize(
    ("spread", "average", "missing"),
    [
        *((spread, mean, 0) for spread in SPREADS[::2]),
        *((spread, interquartile_mean, 0.3) for spread in SPREADS[1::2]),
    ],
)
def test_averages_over_five_trainings(spread, average, missing):
    def study(rng):
        table = normal_table(rng, 5, rng.normal(size=100), spread)
        return average(np.where(rng.random(table.shape) < missing, NAN, table))

    assert_honest(study, 0)


@pytest.mark.parametrize(
    ("spread", "seeds"), [*zip(SPREADS, [(5, 1), (5, 5)] * 3, strict=False), ((0, 1, 1), (5, 5))]
)
def test_differences_over_five_trainings(spread, seeds):
    def study(rng):
        hard = rng.normal(size=100)
        return difference(*(normal_table(rng, s, hard, spread) for s in seeds))

    assert_honest(study, 0, WIDE if seeds == (5, 5) and not spread[0] else HONEST)


@pytest.mark.parametrize("spread", [(0.5, 1, 1), (0.2, 0.3, 1), (0.2, 2, 1), (0, 1, 1)])
@pytest.mark.parametrize("ease", [0, 1])
def test_success_over_five_trainings(spread, ease):
    def study(rng):
        return proportion(probit_table(rng, 5, rng.normal(size=100), spread, ease))

    assert_honest(study, likely(5, spread, ease), HONEST if spread[0] else WIDE)


@pytest.mark.parametrize(
    ("seeds", "spread", "eases"),
    [
        ((1, 1), (0.5, 1, 1), (0, 0)),
        ((1, 1), (0.2, 0.5, 1), (1, 0.5)),
        ((5, 1), (0.2, 0.5, 1), (0, 0)),
        ((5, 1), (0.5, 1, 1), (1, 0.5)),
        ((5, 1), (0, 1, 1), (0, 0)),
        ((5, 5), (0.5, 1, 1), (0, 0)),
        ((5, 5), (0.2, 0.5, 1), (1, 0.5)),
        ((5, 5), (0, 1, 1), (1, 0.5)),
    ],
)
def test_differences_in_success(seeds, spread, eases):
    def study(rng):
        hard = rng.normal(size=100)
        tables = (probit_table(rng, s, hard, spread, e) for s, e in zip(seeds, eases, strict=True))
        return difference_in_success(*tables)

    first, second = (likely(s, spread, e) for s, e in zip(seeds, eases, strict=True))
    assert_honest(study, first - second, WIDE if seeds == (5, 5) and not spread[0] else HONEST)


def contest(rng, seeds, gap, training, failing):
    """Scores (S1, 100), (S2, 100), the second worse by gap but for noise, a share failing inf."""
    hard = rng.normal(size=100)
    for worse, rows in zip((0, gap), seeds, strict=True):
        scores = worse + normal_table(rng, rows, hard, (training, 1, 0.7))
        yield np.where(rng.random(scores.shape) < failing, INF, scores)


def chance(seeds, gap, training, failing):
    """Probability that the first of a contest beats the second, ties half."""
    spread = np.sqrt(2 * 0.7**2 + training**2 * sum(s > 1 for s in seeds))
    wins = stats.norm.cdf(gap / spread)
    return (1 - failing) ** 2 * wins + (1 - failing) * failing + failing**2 / 2


@pytest.mark.parametrize(
    ("seeds", "failing", "gap"),
    [
        *(((1, 1), 0.15, gap) for gap in (0, 0.5)),
        *(((5, 1), 0, gap) for gap in (0, 1)),
        *(((5, 1), 0.15, gap) for gap in (0.5, 1)),
        *(((5, 5), 0, gap) for gap in (0, 0.5)),
        *(((5, 5), 0.15, gap) for gap in (0, 1)),
    ],
)
def test_improvement(seeds, gap, failing):
    set_up = seeds, gap, 0.3, failing
    assert_honest(lambda rng: improvement(*contest(rng, *set_up)), chance(*set_up))


# Where they are wide, and where they fall short


def test_intervals_are_wide_where_nothing_but_chance_differs():
    def average(rng):
        return mean(normal_table(rng, 5, np.zeros(100), (0, 0, 1)))

    assert_honest(average, 0, WIDE)
    set_up = (5, 5), 0.5, 0, 0
    assert_honest(lambda rng: improvement(*contest(rng, *set_up)), chance(*set_up), WIDE)


def test_differences_near_certain_success_are_wide():
    def study(rng):
        hard, spread = rng.normal(size=100), (0.2, 0.5, 1)
        return difference_in_success(*(probit_table(rng, s, hard, spread, 2.5) for s in (5, 1)))

    assert_honest(study, likely(5, (0.2, 0.5, 1), 2.5) - likely(1, (0.2, 0.5, 1), 2.5), (0.95, 1))


@pytest.mark.parametrize(
    ("seeds", "spread", "within"),
    [
        (3, (0, 1, 1), (0.93, 0.98)),
        (3, (0.4, 1, 0), (0.91, 0.93)),
        (2, (0.4, 1, 0), (0.86, 0.88)),
    ],
)
def test_few_trainings_fall_short_as_the_module_says(seeds, spread, within):
    def study(rng):
        return mean(normal_table(rng, seeds, rng.normal(size=100), spread))

    assert_honest(study, 0, within, repetitions=3000)


def test_trainings_that_differ_skewly_fall_short():
    def study(rng):
        return proportion(probit_table(rng, 5, np.zeros(100), (1, 0, 1), 2))

    assert_honest(study, likely(5, (1, 0, 1), 2), (0.84, 0.89))
