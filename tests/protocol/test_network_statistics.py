"""Each network model has the delays, losses, bursts and memory that it states.

Seeds are fixed. Bounds are four standard deviations for as many independent samples as the memory of the model leaves
in half an hour.
"""

from itertools import groupby, pairwise
from math import exp, sqrt
from random import Random

import numpy as np
import pytest
from passafe_protocol.link import Link
from passafe_protocol.link_effect import DROPPED_BY_LOSS
from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.network_path import MOST_STEPS, NetworkPath
from passafe_protocol.networks import NETWORKS, NetworkModel
from scipy import stats

S = 1_000_000_000
LASTS_S = 1800
RATE_HZ = 50
SIGMAS = 4.0
MODELS = list(NETWORKS.values())


def passages(model: NetworkModel, *, rate_hz: int = RATE_HZ, duration_s: float = LASTS_S, seed: int = 1) -> np.ndarray:
    """Return the delay of messages sent at a rate, s; not a number for lost ones."""
    draws = [Random(f"{model.name} {seed} {k}").random for k in range(3)]
    path = NetworkPath(model, *draws)
    found = (path.passage(k * S // rate_hz) for k in range(round(duration_s * rate_hz)))
    return np.array([np.nan if one is None else one / S for one in found])


@pytest.fixture(scope="module")
def runs() -> dict[str, np.ndarray]:
    return {model.name: passages(model) for model in MODELS}


@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.name)
def test_delays_have_the_stated_quantiles(model: NetworkModel, runs: dict[str, np.ndarray]) -> None:
    delays = runs[model.name][~np.isnan(runs[model.name])]
    independent = LASTS_S / max(2.0 * model.memory_s, 1.0 / RATE_HZ)
    blur_s = model.jitter_s + model.offset_s

    steps = len(model.quantiles_s) - 1
    for k, quantile_s in enumerate(model.quantiles_s[1:-1], start=1):
        bound = SIGMAS * sqrt(k / steps * (1 - k / steps) / independent)
        assert np.mean(delays <= quantile_s - blur_s) <= k / steps + bound
        assert np.mean(delays <= quantile_s + blur_s) >= k / steps - bound
    assert delays.max() <= model.longest_delay_s
    spread = float(np.std(delays)) + model.jitter_s
    periods = LASTS_S / model.period_s if model.period_s else 1.0
    bound = SIGMAS * (spread / sqrt(independent) + model.offset_s / sqrt(3 * periods))
    assert delays.mean() == pytest.approx(model.mean_delay_s, abs=bound)


@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.name)
def test_losses_have_the_stated_share(model: NetworkModel, runs: dict[str, np.ndarray]) -> None:
    lost = np.isnan(runs[model.name])
    memory_s = model.step_s / (model.burst_enter + model.burst_leave)
    bad = model.bad_share
    of_bursts = bad * (1 - bad) * (model.loss_bad - model.loss_good) ** 2 * 2 * memory_s / LASTS_S
    of_messages = model.loss_share * (1 - model.loss_share) / lost.size
    of_gaps = 0.0 if not model.period_s else (model.gap_s[1] - model.gap_s[0]) ** 2 / 12 / model.period_s / LASTS_S

    bound = SIGMAS * sqrt(of_bursts + of_messages + of_gaps) + 1 / lost.size
    assert lost.mean() == pytest.approx(model.loss_share, abs=bound)


@pytest.mark.parametrize("name", ["aircraft-calm", "aircraft-rough"])
def test_bursts_last_as_long_as_stated(name: str, runs: dict[str, np.ndarray]) -> None:
    model = NETWORKS[name]
    bursts = [sum(1 for _ in group) for lost, group in groupby(np.isnan(runs[name])) if lost]

    mean = 1 / model.burst_leave  # steps, of which one message falls into each
    deviation = sqrt(1 - model.burst_leave) / model.burst_leave
    assert np.mean(bursts) == pytest.approx(mean, abs=SIGMAS * deviation / sqrt(len(bursts)))
    assert stats.kstest(bursts, stats.geom(model.burst_leave).cdf).statistic < model.burst_leave + 0.02  # it has steps


@pytest.mark.parametrize("name", ["leo-moving", "leo-moving-obstructed", "lte-driving", "5g-driving", "aircraft-calm"])
def test_memory_of_delays_fades_as_stated(name: str, runs: dict[str, np.ndarray]) -> None:
    model, delays = NETWORKS[name], runs[name]
    scores = stats.norm.ppf((stats.rankdata(delays, nan_policy="omit") - 0.5) / np.sum(~np.isnan(delays)))
    lag = round(model.memory_s * RATE_HZ)
    pairs = np.stack([scores[:-lag], scores[lag:]])

    correlation = float(np.corrcoef(pairs[:, ~np.isnan(pairs).any(axis=0)])[0, 1])

    bound = SIGMAS / sqrt(LASTS_S / (2 * model.memory_s)) + 0.05  # the jitter of single messages blurs the ranks
    assert correlation == pytest.approx(exp(-1), abs=bound)


def test_satellite_on_the_move_is_as_it_was_measured(runs: dict[str, np.ndarray]) -> None:
    free, obstructed = runs["leo-moving"], runs["leo-moving-obstructed"]

    assert 2e3 * np.nanmean(free) == pytest.approx(44, abs=2)
    assert 2e3 * np.nanmean(obstructed) == pytest.approx(92, abs=6)
    assert 2e3 * NETWORKS["leo-moving-obstructed"].longest_delay_s == pytest.approx(470)
    by_second = np.isnan(obstructed).reshape(-1, RATE_HZ).mean(axis=1)
    assert np.quantile(by_second, 0.9) == pytest.approx(0.6, abs=0.08)


def test_reconfigurations_come_every_15_s() -> None:
    model, rate_hz = NETWORKS["leo-reconfiguring"], 200
    lost = np.isnan(passages(model, rate_hz=rate_hz, duration_s=600))
    starts = [k for k in range(1, lost.size) if lost[k] and not lost[k - 1]]
    lengths = {k: int(np.argmin(lost[k:])) / rate_hz for k in starts}
    phase = int(np.median([k % (15 * rate_hz) for k, length_s in lengths.items() if length_s > 0.045]))

    gaps = [lengths.get(k, 0.0) for k in range(phase, lost.size, 15 * rate_hz)]

    assert len(gaps) >= 39
    assert min(gaps) >= model.gap_s[0] - 1 / rate_hz
    assert np.mean(gaps) == pytest.approx(sum(model.gap_s) / 2, abs=SIGMAS * 0.029 / sqrt(len(gaps)) + 1 / rate_hz)


def test_offsets_change_at_a_reconfiguration_alone() -> None:
    model = NetworkModel(
        name="x", title="", source="", assumed="", step_s=0.02, quantiles_s=(0.02, 0.02), period_s=1.0, offset_s=0.01
    )
    delays = passages(model, duration_s=60)
    changes = [k for k, (a, b) in enumerate(pairwise(delays)) if a != b]

    assert 55 <= len(changes) <= 60
    assert all(later - earlier == RATE_HZ for earlier, later in pairwise(changes))


@pytest.mark.parametrize("name", ["aircraft-calm", "aircraft-rough"])
def test_fast_and_slow_robots_meet_the_same_network(name: str) -> None:
    slow, fast = (passages(NETWORKS[name], rate_hz=rate_hz, duration_s=60) for rate_hz in (50, 1000))

    assert np.array_equal(slow, fast[::20], equal_nan=True)


def test_a_pause_is_drawn_anew_in_no_time() -> None:
    path = NetworkPath(NETWORKS["leo-reconfiguring"], *[Random(k).random for k in range(3)])
    path.passage(0)

    delays = [path.passage(k * 2 * MOST_STEPS * S) for k in range(1, 200)]

    assert len({one for one in delays if one is not None}) > 150


def test_a_link_has_the_network_on_top_of_its_own_effects() -> None:
    plain: Link[int] = Link("a-to-b", LinkSettings(network="transcontinental-114ms", seed=3))
    more: Link[int] = Link("a-to-b", LinkSettings(network="transcontinental-114ms", delay_s=0.1, seed=3))
    for link in (plain, more):
        for k in range(100):
            link.put(k * 10_000_000, k)

    arrivals = [{item: at for at, item in link.pop_arrived(10 * S)} for link in (plain, more)]

    assert arrivals[0]
    assert all(arrivals[1][item] - at == S // 10 for item, at in arrivals[0].items())


def test_a_link_counts_what_the_network_loses() -> None:
    link: Link[int] = Link("a-to-b", LinkSettings(network="aircraft-rough"))
    effects = [link.put(k * 20_000_000, k) for k in range(1000)]

    lost = sum(effect == DROPPED_BY_LOSS for effect in effects)
    assert lost == link.counts.dropped_loss
    assert 300 < lost < 700


def test_both_directions_have_draws_of_their_own_and_a_seed() -> None:
    def outcome(name: str, seed: int) -> list[bool]:
        link: Link[int] = Link(name, LinkSettings(network="aircraft-rough", seed=seed))
        return [bool(link.put(k * 20_000_000, k)) for k in range(300)]

    assert outcome("a-to-b", 1) == outcome("a-to-b", 1)
    assert outcome("a-to-b", 1) != outcome("b-to-a", 1)
    assert outcome("a-to-b", 1) != outcome("a-to-b", 2)


def test_other_settings_leave_the_network_going_on() -> None:
    settings = LinkSettings(network="aircraft-rough")
    left, changed = Link[int]("a-to-b", settings), Link[int]("a-to-b", settings)
    outcomes: list[list[bool]] = [[], []]
    for k in range(400):
        if k == 200:
            changed.reconfigure(LinkSettings(network="aircraft-rough", delay_s=0.01))
        for link, found in zip((left, changed), outcomes, strict=True):
            found.append(bool(link.put(k * 20_000_000, k)))

    assert outcomes[0] == outcomes[1]
    changed.reconfigure(LinkSettings())
    assert not changed.put(10 * S, 0)
