"""Planned changes of links, and when their states are reported."""

from passafe_protocol.link_change import LinkChange
from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.link_wire import parameters_of
from passafe_protocol.message_link import MessageLink
from passafe_protocol.messages import Header, LinkConfig, LinkSource
from passafe_services.loop.link_control import LinkControl

S = 1_000_000_000
START = 7 * S
SOURCES = (LinkSource("plant", 1, 0, 4, 5),)


def control(*changes: LinkChange) -> tuple[LinkControl, dict[str, MessageLink]]:
    links = {name: MessageLink(name, LinkSettings()) for name in ("operator-to-filter", "plant-to-filter")}
    return LinkControl(links.values(), changes, lambda _link: SOURCES), links


def step(links: LinkControl, now_ns: int) -> list[tuple[str, str]]:
    """Execute a driver's step and return link and trigger of the states reported."""
    if now_ns < links.due_ns:
        return []
    links.advance(now_ns)
    return [(state.link, state.trigger) for state in links.due_states(now_ns)]


def test_states_are_reported_at_start_every_second_and_at_end() -> None:
    links, _ = control()
    reported = {t: step(links, START + t * S // 10) for t in range(25)}
    last = links.last_states()

    both = ["operator-to-filter", "plant-to-filter"]
    assert {t: each for t, each in reported.items() if each} == {
        0: [(name, "start") for name in both],
        10: [(name, "period") for name in both],
        20: [(name, "period") for name in both],
    }
    assert [(state.link, state.trigger) for state in last] == [(name, "end") for name in both]
    assert all(state.sources == SOURCES for state in last)


def test_scheduled_changes_are_applied_in_order_and_reported() -> None:
    slow, lossy = LinkSettings(delay_s=0.2), LinkSettings(loss=1.0)
    links, by_name = control(
        LinkChange(at_s=0.5, link="plant-to-filter", settings=lossy),
        LinkChange(at_s=0.3, link="plant-to-filter", settings=slow),
        LinkChange(at_s=0.0, link="operator-to-filter", settings=slow),
        LinkChange(at_s=0.4, link="filter-to-plant", settings=slow),  # at another process
    )
    assert step(links, START) == [("operator-to-filter", "scheduled"), ("plant-to-filter", "start")]
    assert by_name["operator-to-filter"].settings == slow
    assert step(links, START + S * 3 // 10 - 1) == []
    assert step(links, START + S * 3 // 10) == [("plant-to-filter", "scheduled")]
    assert by_name["plant-to-filter"].settings == slow
    assert step(links, START + S * 6 // 10) == [("plant-to-filter", "scheduled")]
    assert by_name["plant-to-filter"].settings == lossy


def test_request_is_applied_at_once_and_reported_next_step() -> None:
    links, by_name = control()
    step(links, START)
    wanted = LinkSettings(delay_s=0.1)
    header = Header("console", 9, 3, 0, 0, 0, 0)
    links.configure(header, LinkConfig("plant-to-filter", parameters_of(wanted)))
    links.configure(header, LinkConfig("plant-to-operator", parameters_of(wanted)))  # at another process

    assert by_name["plant-to-filter"].settings == wanted
    assert links.due_ns <= START + 1
    links.advance(START + 1)
    (state,) = links.due_states(START + 1)
    assert (state.link, state.trigger, state.config_source) == ("plant-to-filter", "requested", "console")
    assert (state.config_epoch, state.config_sequence) == (9, 3)
    assert links.due_ns == START + S
