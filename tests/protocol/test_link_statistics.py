"""Delay, correlation, loss, bursts, duplication, corruption and throughput match their definitions.

The seeds are fixed, so a test passes always or never; the levels say how unlikely a correct link was to fail it.
"""

from collections.abc import Callable
from itertools import groupby
from math import sqrt
from random import Random

import numpy as np
import pytest
from passafe_protocol.correlated_uniform import CorrelatedUniform
from passafe_protocol.delay_distribution import LONGEST_NS, PARETO_NORMAL_SIGMA, pareto_normal
from passafe_protocol.link import Link
from passafe_protocol.link_effect import CORRUPTED, DROPPED_BY_LOSS
from passafe_protocol.link_settings import LinkSettings
from scipy import integrate, stats

S = 1_000_000_000
MS = 1_000_000
COUNT = 20_000
LEVEL = 1e-3
SIGMAS = 4.0


def delays_s(settings: LinkSettings, count: int = COUNT) -> np.ndarray:
    """Delays of messages put in one after the other, in that order, s."""
    link: Link[int] = Link("a-to-b", settings)
    for i in range(count):
        link.put(0, i)
    arrived = sorted((i, arrival_ns) for arrival_ns, i in link.pop_arrived(LONGEST_NS))
    assert len(arrived) == count
    return np.array([arrival_ns for _, arrival_ns in arrived]) / S


def losses(settings: LinkSettings, count: int = COUNT) -> list[bool]:
    """Return whether each message was lost."""
    link: Link[int] = Link("a-to-b", settings)
    return [link.put(0, i) == DROPPED_BY_LOSS for i in range(count)]


def within(got: int, share: float, count: int) -> bool:
    """Check whether a binomial count is within ``SIGMAS`` standard deviations of its mean."""
    return abs(got - share * count) < SIGMAS * sqrt(count * share * (1 - share))


# The delay is 0.1 s, the jitter 10 ms. A Pareto variable of shape 3 has mean 3/2 and variance 3/4.
PARETO = stats.pareto(3, loc=0.1 - 1.5 * 0.01 * 2 / sqrt(3), scale=0.01 * 2 / sqrt(3))
MARGINALS: dict[str, tuple[LinkSettings, Callable[[np.ndarray], np.ndarray]]] = {
    "uniform": (LinkSettings(delay_s=0.1, jitter_s=0.01), stats.uniform(0.09, 0.02).cdf),
    "normal": (LinkSettings(delay_s=0.1, jitter_s=0.01, distribution="normal"), stats.norm(0.1, 0.01).cdf),
    "pareto": (LinkSettings(delay_s=0.1, jitter_s=0.01, distribution="pareto"), PARETO.cdf),
    "histogram": (
        LinkSettings(delay_s=0.1, distribution="histogram", quantiles_s=(0.0, 0.01, 0.05, 0.06)),
        lambda x: np.interp(x, [0.1, 0.11, 0.15, 0.16], [0, 1 / 3, 2 / 3, 1]),
    ),
}


@pytest.mark.parametrize("name", MARGINALS)
def test_delays_have_the_requested_distribution(name: str) -> None:
    settings, cdf = MARGINALS[name]

    assert stats.kstest(delays_s(settings), cdf).pvalue > LEVEL


@pytest.mark.parametrize("name", MARGINALS)
def test_correlated_delays_still_have_it(name: str) -> None:
    settings, cdf = MARGINALS[name]
    found = np.concatenate(  # every twentieth: at correlation 0.5 as good as independent
        [delays_s(LinkSettings(**{**fields(settings), "correlation": 0.5, "seed": seed}))[::20] for seed in range(8)]
    )

    assert stats.kstest(found, cdf).pvalue > LEVEL


def fields(settings: LinkSettings) -> dict[str, object]:
    return {name: getattr(settings, name) for name in LinkSettings.__slots__}


@pytest.mark.parametrize("name", MARGINALS)
@pytest.mark.parametrize("correlation", [0.25, 0.9])
def test_successive_delays_have_the_requested_rank_correlation(name: str, correlation: float) -> None:
    settings, _ = MARGINALS[name]
    found = delays_s(LinkSettings(**{**fields(settings), "correlation": correlation}))

    # Bartlett: the variance of an estimate from an autoregressive sequence is about (1 − ρ²)/n.
    assert stats.spearmanr(found[:-1], found[1:]).statistic == pytest.approx(
        correlation, abs=SIGMAS * 1.3 * sqrt((1 - correlation**2) / COUNT)
    )


def test_rank_correlation_is_of_the_numbers_not_their_gaussians() -> None:
    asked, count = 0.6, 200_000
    source = CorrelatedUniform(Random(3).random)
    source.correlate(asked)
    found = np.array([source() for _ in range(count)])

    # Gaussians of correlation 0.6 would give 6/π·asin(0.3) = 0.582.
    tolerance = SIGMAS * 1.3 * sqrt((1 - asked**2) / count)
    assert tolerance < 0.01
    assert stats.spearmanr(found[:-1], found[1:]).statistic == pytest.approx(asked, abs=tolerance)


def test_uncorrelated_delays_are_uncorrelated() -> None:
    found = delays_s(MARGINALS["normal"][0])

    assert abs(stats.spearmanr(found[:-1], found[1:]).statistic) < SIGMAS / sqrt(COUNT)


def test_pareto_normal_mixes_quantiles_with_unit_deviation() -> None:
    u = np.array([1e-6, 0.01, 0.3, 0.5, 0.9, 1 - 1e-6])
    expected = (stats.norm.ppf(u) + 3 * (stats.pareto(3).ppf(u) - 1.5) * 2 / sqrt(3)) / 4 / PARETO_NORMAL_SIGMA

    def squared(z: float) -> float:  # with z for u, the tail is no trouble
        value = (z + 3 * (stats.norm.sf(z) ** (-1 / 3) - 1.5) * 2 / sqrt(3)) / 4
        return value**2 * stats.norm.pdf(z)

    variance = integrate.quad(squared, -9, 8, limit=200)[0] + integrate.quad(squared, 8, 37, limit=200)[0]
    assert [pareto_normal(each) for each in u] == pytest.approx(expected)
    assert sqrt(variance) == pytest.approx(PARETO_NORMAL_SIGMA, rel=1e-6)
    mixed = delays_s(LinkSettings(delay_s=0.1, jitter_s=0.01, distribution="pareto-normal"))
    assert mixed.mean() == pytest.approx(0.1, abs=SIGMAS * 0.01 / sqrt(COUNT))


def test_delay_never_falls_below_zero() -> None:
    found = delays_s(LinkSettings(delay_s=0.01, jitter_s=0.04, seed=3))

    assert found.min() == 0
    assert within(int(np.count_nonzero(found == 0)), 3 / 8, COUNT)  # share of ±40 ms that lies below −10 ms


def test_no_delay_is_longer_than_the_longest() -> None:
    found = delays_s(LinkSettings(delay_s=10.0, jitter_s=10.0, distribution="pareto"))

    assert found.max() == LONGEST_NS / S
    assert within(int(np.count_nonzero(found == LONGEST_NS / S)), stats.pareto(3).sf(1.5 + sqrt(3) / 2), COUNT)


@pytest.mark.parametrize("loss", [0.02, 0.2, 0.5, 0.9])
def test_loss_is_the_share_that_is_lost_independently(loss: float) -> None:
    lost = losses(LinkSettings(loss=loss, seed=5))
    runs = [(gone, sum(1 for _ in run)) for gone, run in groupby(lost)]

    assert within(sum(lost), loss, COUNT)
    bursts = [length for gone, length in runs if gone]
    # Of independent losses the bursts are geometric with mean 1/(1 − p).
    spread = sqrt(loss) / (1 - loss) / sqrt(len(bursts))
    assert np.mean(bursts) == pytest.approx(1 / (1 - loss), abs=SIGMAS * spread)


def test_gilbert_bursts_have_their_mean_length_and_loss_share() -> None:
    p, r, count = 0.02, 0.25, 200_000
    lost = losses(LinkSettings(burst_enter=p, burst_leave=r, seed=2), count)
    bursts = [sum(1 for _ in run) for gone, run in groupby(lost) if gone]
    gaps = [sum(1 for _ in run) for gone, run in groupby(lost) if not gone]

    assert np.mean(bursts) == pytest.approx(1 / r, abs=SIGMAS * sqrt(1 - r) / r / sqrt(len(bursts)))
    assert np.mean(gaps) == pytest.approx(1 / p, abs=SIGMAS * sqrt(1 - p) / p / sqrt(len(gaps)))
    share = p / (p + r)
    memory = (1 + (1 - p - r)) / (p + r)  # of the two-state chain: its variance grows by this
    assert sum(lost) / count == pytest.approx(share, abs=SIGMAS * sqrt(share * (1 - share) * memory / count))
    lengths = np.bincount(bursts)[1:30]
    expected = len(bursts) * r * (1 - r) ** np.arange(len(lengths))
    usual = expected >= 10
    assert (
        stats.chisquare(lengths[usual], expected[usual] * lengths[usual].sum() / expected[usual].sum()).pvalue > LEVEL
    )


def test_each_state_of_gilbert_elliott_has_its_share_of_losses() -> None:
    p, r, good, bad, count = 0.05, 0.1, 0.01, 0.7, 200_000
    settings = LinkSettings(burst_enter=p, burst_leave=r, burst_loss_good=good, burst_loss_bad=bad, seed=4)
    lost = losses(settings, count)

    share = (p * bad + r * good) / (p + r)
    memory = (1 + (1 - p - r)) / (p + r)
    assert sum(lost) / count == pytest.approx(share, abs=SIGMAS * sqrt(share * (1 - share) * memory / count))


def test_independent_and_burst_losses_add_up() -> None:
    lost = losses(LinkSettings(loss=0.3, burst_enter=1.0, burst_leave=1.0, burst_loss_bad=0.5), COUNT)

    assert within(sum(lost[1::2]), 1 - 0.7 * 0.5, COUNT // 2)
    assert within(sum(lost[::2]), 0.3, COUNT // 2)


@pytest.mark.parametrize("share", [0.01, 0.3])
def test_duplication_and_corruption_have_their_share(share: float) -> None:
    link: Link[int] = Link("a-to-b", LinkSettings(duplicate=share, corrupt=share, seed=7))
    reported = [link.put(0, i) for i in range(COUNT)]
    copies = link.counts.duplicated

    assert within(copies, share, COUNT)
    assert within(link.counts.corrupted, share, COUNT + copies)
    assert sum(effects.count(CORRUPTED[0]) for effects in reported) == link.counts.corrupted


@pytest.mark.parametrize(("offered_hz", "passed_hz"), [(1000, 400), (300, 300)])
def test_a_rate_lets_no_more_through_and_no_less(offered_hz: int, passed_hz: int) -> None:
    link: Link[int] = Link("a-to-b", LinkSettings(rate_hz=400.0, queue=10))
    for i in range(10 * offered_hz):
        link.put(i * S // offered_hz, i)
    arrivals = [arrival_ns for arrival_ns, _ in link.pop_arrived(10 * S)]

    assert len(arrivals) == pytest.approx(10 * passed_hz, abs=2)
    assert np.diff(arrivals).min() >= S / 400 if offered_hz > 400 else True
    assert max(np.array(arrivals[-100:]) - S * 10) <= 0


def test_a_trace_delivers_at_its_times_and_at_no_other() -> None:
    trace_s = (0.001, 0.004, 0.004, 0.011, 0.020)
    link: Link[int] = Link("a-to-b", LinkSettings(trace_s=trace_s, queue=1000))
    for i in range(900):
        link.put(i * MS, i)  # four times as many as get through
    arrivals = np.array([arrival_ns for arrival_ns, _ in link.pop_arrived(S)])
    expected = [round(S * (lap * 0.020 + at)) for lap in range(50) for at in trace_s]

    assert arrivals.tolist() == expected[: len(arrivals)]
    assert len(arrivals) == 250
