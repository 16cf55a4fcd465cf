"""Coverage of intervals on synthetic data, and tests whose p is known in closed form."""

from functools import lru_cache

import numpy as np
import pytest
from scipy import stats

from vpf_sim.evaluation.analysis import statistics
from vpf_sim.evaluation.analysis.statistics import (
    Interval,
    mean_interval,
    paired_difference,
    paired_shares,
    seeds_for_mean,
    seeds_for_share,
    share_interval,
)
from vpf_sim.types import Bools, Floats

RANDOM = np.random.Generator(np.random.PCG64(11))


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fewer resamples: of thousands of intervals each may be a little rough."""
    monkeypatch.setattr(statistics, "RESAMPLES", 1499)
    monkeypatch.setattr(statistics, "_weights", lru_cache(statistics._weights.__wrapped__))


def intervals(samples: Floats) -> list[Interval]:
    """Those of (m, n) samples."""
    found = [interval for interval in map(mean_interval, samples) if interval is not None]
    assert len(found) == len(samples)
    return found


def coverage(samples: Floats, mean: float) -> float:
    """Share of the intervals of (m, n) samples that hold their true mean."""
    return float(np.mean([low <= mean <= high for low, high in intervals(samples)]))


@pytest.mark.parametrize(("count", "least", "most"), [(10, 0.92, 0.96), (30, 0.93, 0.97)])
@pytest.mark.usefixtures("quick")
def test_the_bootstrap_covers_the_mean_of_normal_values_in_95_percent(count: int, least: float, most: float) -> None:
    """Of 1500 intervals that are each right with 0.95 (0.94 for ten values), the share is so within 0.006 (1 sigma)."""
    assert least <= coverage(RANDOM.normal(3.0, 2.0, (1500, count)), 3.0) <= most


@pytest.mark.usefixtures("quick")
def test_the_bootstrap_of_five_values_is_not_the_narrow_one() -> None:
    samples = RANDOM.normal(0.0, 1.0, (1500, 5))
    plain = stats.bootstrap((samples,), np.mean, axis=-1, n_resamples=999, rng=RANDOM).confidence_interval
    assert coverage(samples, 0.0) >= 0.90 > np.mean((plain.low <= 0.0) & (plain.high >= 0.0)) + 0.03


@pytest.mark.usefixtures("quick")
def test_a_normal_means_interval_is_as_wide_as_students() -> None:
    samples = RANDOM.normal(0.0, 1.0, (500, 30))
    students = 2.0 * stats.t.ppf(0.975, 29) * samples.std(axis=1, ddof=1) / np.sqrt(30.0)
    assert np.mean(np.diff(intervals(samples))) == pytest.approx(np.mean(students), rel=0.05)


@pytest.mark.parametrize("count", [5, 30, 300])
def test_the_bootstrap_equals_scipys_except_for_its_level(count: int) -> None:
    """Both draw their own resamples, so the ends agree to a few hundredths of the width."""
    values = RANDOM.exponential(1.0, count)
    level = 1.0 - 2.0 * stats.norm.sf(stats.t.ppf(0.975, count - 1) * np.sqrt(count / (count - 1)))
    ends = stats.bootstrap((values,), np.mean, confidence_level=level, method="BCa", rng=RANDOM).confidence_interval
    assert mean_interval(values) == pytest.approx((ends.low, ends.high), abs=0.05 * (ends.high - ends.low))


def test_an_interval_is_a_function_of_its_values_alone() -> None:
    values = RANDOM.normal(size=8)
    low, high = mean_interval(values) or (0.0, 0.0)
    assert mean_interval(values) == (low, high)
    assert mean_interval(2.0 * values + 1.0) == pytest.approx((2.0 * low + 1.0, 2.0 * high + 1.0))


@pytest.mark.parametrize("scale", [1e-200, 1e-9, 1e9, 1e150])
def test_an_interval_scales_with_its_values(scale: float) -> None:
    values = RANDOM.exponential(1.0, 12)
    low, high = mean_interval(values) or (0.0, 0.0)
    assert mean_interval(scale * values) == pytest.approx((scale * low, scale * high), rel=1e-6, abs=0.0)


@pytest.mark.parametrize("count", [2, 3, 5, 30, 300])
def test_one_outlier_gives_a_finite_interval(count: int) -> None:
    low, high = mean_interval(np.arange(count) == 0) or (1.0, 0.0)
    assert 0.0 <= low < 1.0 / count < high <= 1.0


def test_values_without_spread_have_no_interval() -> None:
    assert mean_interval(np.array([3.0])) is None
    assert mean_interval(np.full(30, 1.0)) is None
    assert mean_interval(np.array([1.0, 2.0])) == (1.0, 2.0), "of two values nothing is known beyond them"


@pytest.mark.parametrize("episodes", [1, 5, 30, 300])
def test_an_interval_of_a_share_covers_it_in_at_least_95_percent_of_outcomes(episodes: int) -> None:
    """The exact coverage, by summing over the binomial distribution, at 99 shares."""
    ends = [share_interval(count, episodes) for count in range(episodes + 1)]
    for share in np.arange(1, 100) / 100.0:
        chance = stats.binom.pmf(np.arange(episodes + 1), episodes, share)
        holds = [interval.low <= share <= interval.high for interval in ends]
        assert np.sum(chance[holds]) >= 0.95


def test_an_interval_of_a_share_in_closed_form() -> None:
    assert share_interval(30, 30) == pytest.approx((0.025 ** (1.0 / 30.0), 1.0))
    assert share_interval(0, 30) == pytest.approx((0.0, 1.0 - 0.025 ** (1.0 / 30.0)))
    by_scipy = stats.binomtest(17, 30).proportion_ci()
    assert share_interval(17, 30) == pytest.approx((by_scipy.low, by_scipy.high))


def test_ten_pairs_of_one_sign_have_the_least_possible_p() -> None:
    first = np.arange(10.0)
    found = paired_difference(first, first - np.linspace(0.5, 1.5, 10))
    assert found is not None
    assert (found.difference, found.p, found.pairs) == pytest.approx((1.0, 2.0 / 2.0**10, 10))
    assert found.interval is not None
    assert found.interval.low > 0.0


def test_the_p_of_a_permutation_test_is_counted_exactly() -> None:
    """Of the 8 sign patterns of (1, 2, 3) only two means are as far from 0 as that of (1, 2, 3), six as (1, -2, 3)."""
    zeros = np.zeros(3)
    assert [
        found.p if (found := paired_difference(np.array(values), zeros)) else None
        for values in ([1.0, 2.0, 3.0], [1.0, -2.0, 3.0], [1.0, 2.0, -3.0])
    ] == pytest.approx([2.0 / 8.0, 6.0 / 8.0, 1.0])


def test_the_permutation_test_equals_scipys() -> None:
    for count, error in ((7, 1e-12), (30, 0.02)):
        difference = RANDOM.normal(0.3, 1.0, count)
        found = paired_difference(difference, np.zeros(count))
        theirs = stats.permutation_test((difference,), np.mean, permutation_type="samples", rng=RANDOM)
        assert found is not None
        assert found.p == pytest.approx(theirs.pvalue, abs=error)


def test_paired_differences_detect_more_than_unpaired_means() -> None:
    """Seeds differ by 1, the drivers by 0.1 on each of them."""
    seeds = RANDOM.normal(0.0, 1.0, 30)
    found = paired_difference(seeds + 0.1 + RANDOM.normal(0.0, 0.05, 30), seeds)
    assert found is not None
    assert found.interval is not None
    assert found.p < 0.001
    assert 0.05 < found.interval.low < found.difference < found.interval.high < 0.15
    one, other = mean_interval(seeds + 0.1), mean_interval(seeds)
    assert one is not None
    assert other is not None
    assert one.low < other.high


def test_one_pair_has_no_interval() -> None:
    assert paired_difference(np.array([2.0]), np.array([0.5])) == (1.5, None, 1.0, 1)


def test_no_pairs_no_difference() -> None:
    assert paired_difference(np.empty(0), np.empty(0)) is None
    same = paired_difference(np.ones(5), np.ones(5))
    assert same == (0.0, None, 1.0, 5)


def test_mcnemar_counts_the_pairs_that_differ() -> None:
    first = np.array([True] * 28 + [False] * 2)
    second = np.array([True] * 20 + [False] * 8 + [True, False])
    found = paired_shares(first, second)
    assert found.difference == pytest.approx(7.0 / 30.0)
    assert found.p == pytest.approx(2.0 * (1 + 9) / 2.0**9), "8 : 1, both tails"
    assert found.interval is not None
    assert found.interval.low > 0.0
    assert paired_shares(first, first)[::2] == (0.0, 1.0)


@pytest.mark.parametrize("only_first", range(8))
def test_mcnemar_is_the_binomial_test(only_first: int) -> None:
    first: Bools = np.arange(12) < only_first
    second: Bools = (np.arange(12) >= only_first) & (np.arange(12) < 7)
    assert paired_shares(first, second).p == pytest.approx(stats.binomtest(only_first, 7).pvalue)


@pytest.mark.parametrize(("only_first", "only_second"), [(0.1, 0.1), (0.3, 0.05), (0.02, 0.02)])
def test_the_interval_of_a_difference_of_shares_covers_it(only_first: float, only_second: float) -> None:
    """The exact coverage over all outcomes of 20 pairs, each by its multinomial chance."""
    pairs, held = 20, 0.0
    true = only_first - only_second
    for a in range(pairs + 1):
        for b in range(pairs + 1 - a):
            rest = pairs - a - b
            chance = stats.multinomial.pmf(
                [a, b, rest], pairs, [only_first, only_second, 1.0 - only_first - only_second]
            )
            if chance < 1e-9:
                continue
            first = np.array([True] * a + [False] * b + [True] * rest)
            second = np.array([False] * a + [True] * b + [True] * rest)
            low, high = paired_shares(first, second).interval or Interval(0.0, 0.0)
            held += chance * (low <= true <= high)
    assert held >= 0.94


def test_the_seeds_for_a_width_of_a_mean() -> None:
    values = RANDOM.normal(0.0, 0.5, 40)
    needed = seeds_for_mean(values, 0.2)
    assert needed is not None

    def width(count: int) -> float:
        return float(2.0 * stats.t.ppf(0.975, count - 1) * np.std(values, ddof=1) / np.sqrt(count))

    assert width(needed) <= 0.2 < width(needed - 1)
    more = seeds_for_mean(values, 0.1)
    assert more is not None
    assert width(more) <= 0.1 < width(more - 1)
    assert 3.5 * needed < more <= 4 * needed, "half the width, four times the seeds, less what a surer spread saves"
    assert seeds_for_mean(values[:1], 0.2) is None
    assert seeds_for_mean(np.ones(9), 0.2) is None
    assert seeds_for_mean(np.array([0.0, 1e-9]), 0.2) == 2


def test_the_seeds_for_a_width_of_a_share() -> None:
    needed = seeds_for_share(30, 30, 0.1)
    assert 1.0 - 0.025 ** (1.0 / needed) <= 0.1 < 1.0 - 0.025 ** (1.0 / (needed - 1))
    assert seeds_for_share(15, 30, 0.2) == pytest.approx(1.96**2 / 0.2**2, rel=0.1)


def test_values_that_differ_by_rounding_have_no_interval() -> None:
    values = np.ones(30)
    values[:3] = np.nextafter(1.0, 0.0)
    assert mean_interval(values) is None
    assert mean_interval(1e-9 * values) is None
    assert mean_interval(np.array([1.0, 1.0, 1.0 - 1e-9])) is not None
