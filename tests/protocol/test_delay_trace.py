from math import inf

import pytest
from passafe_protocol.delay_trace import DelayTrace
from passafe_protocol.errors import LinkSettingsError
from passafe_protocol.link import Link
from passafe_protocol.link_effect import DROPPED_BY_LOSS
from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.link_wire import parameters_of, settings_of
from passafe_protocol.message_link import MessageLink
from passafe_protocol.messages import Header, LinkConfig

MS = 1_000_000
TRACE = ((0.0, 0.010), (0.1, inf), (0.2, 0.030))


def test_a_message_shares_the_fate_of_the_probe_before_it() -> None:
    trace = DelayTrace(TRACE)

    found = [trace.passage(1000 * MS + at * MS) for at in (0, 50, 99, 100, 150, 200, 299)]

    assert found == [10 * MS, 10 * MS, 10 * MS, None, None, 30 * MS, 30 * MS]


def test_a_trace_repeats_after_one_more_interval() -> None:
    trace = DelayTrace(TRACE)
    trace.passage(0)

    assert [trace.passage(at * MS) for at in (299, 300, 400, 600)] == [30 * MS, 10 * MS, None, 10 * MS]


def test_a_link_delays_and_loses_as_recorded() -> None:
    link: Link[int] = Link("a-to-b", LinkSettings(delay_trace_s=TRACE, delay_s=0.001))

    effects = [link.put(at * MS, at) for at in (0, 100, 200)]

    assert effects == ["", DROPPED_BY_LOSS, ""] or [bool(one) for one in effects] == [False, True, False]
    assert link.pop_arrived(1000 * MS) == [(11 * MS, 0), (231 * MS, 200)]


@pytest.mark.parametrize(
    "got",
    [
        ((0.0, 0.1),),
        ((0.5, 0.1), (1.0, 0.1)),
        ((0.0, 0.1), (0.0, 0.1)),
        ((0.0, 0.1), (1.0, -0.1)),
        ((0.0, 0.1), (1.0, 11.0)),
        ((0.0, 0.1), (inf, 0.1)),
    ],
)
def test_other_traces_are_refused(got: tuple[tuple[float, float], ...]) -> None:
    with pytest.raises(LinkSettingsError, match="delay_trace_s"):
        LinkSettings(delay_trace_s=got)


def test_a_trace_excludes_a_network() -> None:
    with pytest.raises(LinkSettingsError, match="none if there is a trace"):
        LinkSettings(delay_trace_s=TRACE, network="lte-driving")
    with pytest.raises(LinkSettingsError, match="leo-moving"):
        LinkSettings(network="moon")


def test_a_change_by_wire_keeps_the_trace() -> None:
    link = MessageLink("filter-to-plant", LinkSettings(delay_trace_s=TRACE))
    wanted = parameters_of(LinkSettings(loss=0.5))

    link.configure(Header("console", 1, 0, 0, 0, 0, 0), LinkConfig("filter-to-plant", wanted))

    assert link.settings == LinkSettings(loss=0.5, delay_trace_s=TRACE)
    assert settings_of(wanted, (), TRACE) == link.settings
    assert link.state("period", ()).trace_opportunities == 3
