"""Outcomes of links for any settings."""

from hypothesis import strategies as st
from passafe_protocol.link import Link
from passafe_protocol.link_effect import (
    DROPPED_BY_LOSS,
)
from passafe_protocol.link_settings import DISTRIBUTIONS, MAX_DELAY_S, LinkSettings

S = 1_000_000_000
MS = 1_000_000
COUNT = 20_000

share = st.sampled_from([0.0, 0.0, 0.2, 0.5, 1.0])


@st.composite
def any_settings(draw: st.DrawFn) -> LinkSettings:
    """Draw settings with any combination of effects."""
    distribution = draw(st.sampled_from(DISTRIBUTIONS))
    by_table = distribution == "histogram"
    limit = draw(st.sampled_from(["none", "rate", "trace"]))
    edges = sorted(draw(st.sets(st.sampled_from([0.0, 0.01, 0.1, 0.3, 0.5, 2.0]), max_size=4)))
    return LinkSettings(
        delay_s=draw(st.sampled_from([0.0, 0.02, MAX_DELAY_S])),
        jitter_s=0.0 if by_table else draw(st.sampled_from([0.0, 0.01, 1.0])),
        distribution=distribution,
        quantiles_s=(0.0, 0.01, 0.01, 0.2) if by_table else (),
        correlation=draw(st.sampled_from([0.0, 0.5])),
        reorder=draw(st.booleans()),
        loss=draw(share),
        burst_enter=draw(share),
        burst_leave=draw(share),
        burst_loss_good=draw(share),
        duplicate=draw(share),
        corrupt=draw(share),
        rate_hz=draw(st.sampled_from([10.0, 100.0])) if limit == "rate" else 0.0,
        queue=draw(st.sampled_from([1, 3, 1000])),
        outages_s=tuple(zip(edges[::2], edges[1::2], strict=False)),
        trace_s=(0.0, 0.003, 0.003, 0.1) if limit == "trace" else (),
        seed=draw(st.integers(0, 5)),
    )


def outcome(settings: LinkSettings, count: int = COUNT, name: str = "a-to-b") -> list[int | None]:
    """Delay in ns of each of ``count`` messages put in at time 0, ``None`` for those that were dropped."""
    link: Link[int] = Link(name, settings)
    delays: list[int | None] = [None] * count
    dropped = {i for i in range(count) if link.put(0, i) == DROPPED_BY_LOSS}
    for arrival_ns, i in link.pop_arrived(2 * 10 * S):
        delays[i] = arrival_ns
    assert dropped == {i for i, delay in enumerate(delays) if delay is None}
    return delays


def arrived(delays: list[int | None]) -> list[int]:
    return [delay for delay in delays if delay is not None]
