"""Accounts of links: they balance exactly, or the review reports the differences."""

from collections.abc import Callable
from pathlib import Path

import pytest
from msgspec.structs import replace
from passafe_protocol.codec import encode
from passafe_protocol.messages import Header, LinkEvent, LinkSource, LinkState, Message, OperatorCommand
from passafe_protocol.topics import LINKS, Topic
from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.scenarios.load import load_scenario
from passafe_services.scenarios.schema import Scenario
from passafe_services.simulation import lockstep_loop, steps_of
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.link_accounts import LinkAccount, link_accounts
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict

EVERYTHING = {
    "delay_s": 0.02,
    "jitter_s": 0.01,
    "loss": 0.05,
    "burst_enter": 0.02,
    "burst_leave": 0.3,
    "duplicate": 0.1,
    "corrupt": 0.05,
    "rate_hz": 800.0,
    "queue": 10,
    "outages_s": [(0.1, 0.15)],
    "seed": 4,
}
LINK = "operator-to-filter"

Sent = tuple[Topic, Header, Message]
Change = Callable[[list[Sent]], list[Sent]]


class Simulated:
    """A run with every effect on every link, whose log can be changed before it is read."""

    def __init__(self, folder: Path) -> None:
        links = {f"links.{name}": EVERYTHING for name in LINKS}
        self.scenario: Scenario = load_scenario("notomista-cai-2020", {"duration_s": 0.5, **links})
        self.sent: list[Sent] = []
        loop = lockstep_loop(self.scenario, lambda topic, header, body: self.sent.append((topic, header, body)))
        loop.run(steps_of(self.scenario))
        loop.finish()
        self._folder = folder

    def log(self, change: Change = lambda sent: sent, *, driver: str = "lockstep") -> RunLog:
        path = self._folder / "run.mcap"
        metadata = run_metadata(
            scenario_json=self.scenario.model_dump_json(),
            versions={},
            driver="live" if driver == "live" else "lockstep",
        )
        with LogWriter(path, metadata) as log:
            for topic, header, body in change(list(self.sent)):
                key = topic.key(header.source)
                log.write(key, encode(header, body), sequence=header.sequence, wall_ns=header.wall_ns)
        return RunLog.read(path)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Simulated:
    return Simulated(tmp_path_factory.mktemp("links"))


def account(log: RunLog, link: str = LINK) -> LinkAccount:
    (found,) = [each for each in link_accounts(log) if each.link == link]
    return found


def changed(kind: type, index: int, **fields: object) -> Change:
    """Change one message of a kind that is about the link."""

    def change(sent: list[Sent]) -> list[Sent]:
        places = [i for i, (_, _, body) in enumerate(sent) if isinstance(body, kind) and body.link == LINK]
        topic, header, body = sent[places[index]]
        sent[places[index]] = (topic, header, replace(body, **fields))
        return sent

    return change


def without(kind: type, index: int) -> Change:
    def change(sent: list[Sent]) -> list[Sent]:
        places = [i for i, (_, _, body) in enumerate(sent) if isinstance(body, kind)]
        del sent[places[index]]
        return sent

    return change


@pytest.mark.parametrize("driver", ["lockstep", "live"])
def test_every_link_of_a_bad_run_is_accounted_for_exactly(run: Simulated, driver: str) -> None:
    accounts = link_accounts(run.log(driver=driver))

    assert [each.link for each in accounts] == list(LINKS)
    for each in accounts:
        assert each.differences == {}
        assert each.final
        assert each.epoch == (1 if driver == "live" else None)
        assert each.sent - each.lost_on_bus + each.duplicated == (
            each.delivered + sum(each.dropped.values()) + each.in_flight
        )
        assert min(each.duplicated, each.corrupted, each.in_flight, *each.dropped.values()) > 0
        assert each.text.startswith(f"{each.link}: {each.sent} sent − 0 lost on the bus + {each.duplicated} copies = ")
        assert "differs" not in each.text


def test_the_verdict_tells_it_and_needs_it(run: Simulated) -> None:
    good = Verdict.of(run.log(), CoreEvaluator(run.scenario))
    bad = Verdict.of(run.log(changed(LinkState, -1, dropped_loss=0)), CoreEvaluator(run.scenario))

    assert good.properties["links-reconciled"].holds is True
    assert good.properties["links-reconciled"].required
    assert len(good.links) == 4
    assert bad.properties["links-reconciled"].holds is False
    assert bad.properties["links-reconciled"].worst > 0
    assert bad.verdict != "holds"


def test_a_log_without_links_is_not_judged(run: Simulated) -> None:
    log = run.log(lambda sent: [each for each in sent if not isinstance(each[2], LinkState | LinkEvent)])
    verdict = Verdict.of(log, CoreEvaluator(run.scenario))

    assert verdict.links == []
    assert (verdict.properties["links-reconciled"].holds, verdict.properties["links-reconciled"].required) == (
        None,
        False,
    )


def test_events_without_states_are_unproven(run: Simulated) -> None:
    log = run.log(lambda sent: [each for each in sent if not isinstance(each[2], LinkState)])
    entry = Verdict.of(log, CoreEvaluator(run.scenario)).properties["links-reconciled"]

    assert (entry.holds, entry.required) == (None, True)


def end_of(run: Simulated) -> LinkState:
    return [body for _, _, body in run.sent if isinstance(body, LinkState) and body.link == LINK][-1]


@pytest.mark.parametrize(
    ("field", "by", "named"),
    [
        ("entered", 1, {"entered and sent": 1}),
        ("delivered", 2, {"balance": 2}),
        ("in_flight", 1, {"balance": 1}),
    ],
)
def test_a_count_that_is_another_is_found(run: Simulated, field: str, by: int, named: dict[str, int]) -> None:
    log = run.log(changed(LinkState, -1, **{field: getattr(end_of(run), field) + by}))

    assert account(log).differences == named
    assert account(log, "filter-to-plant").differences == {}


@pytest.mark.parametrize("field", ["dropped_loss", "dropped_queue", "dropped_outage", "duplicated", "corrupted"])
def test_a_count_that_the_events_do_not_tell_is_found(run: Simulated, field: str) -> None:
    log = run.log(changed(LinkState, -1, **{field: getattr(end_of(run), field) + 1}))

    assert account(log).differences[field.replace("dropped_", "dropped by ")] == 1
    assert f"differs in {field.replace('dropped_', 'dropped by ')} by 1" in account(log).text


def test_an_event_that_is_another_or_missing_is_found(run: Simulated) -> None:
    assert account(run.log(changed(LinkEvent, 3, sequence=10**6))).differences == {
        "events of messages that were not sent": 1
    }
    assert (
        account(run.log(changed(LinkEvent, 3, effect="corrupted", cause="queue"))).differences[
            "events of no known effect"
        ]
        == 1
    )
    gone = [each.differences for each in link_accounts(run.log(without(LinkEvent, 5)))]
    assert {"events missing in the log"} <= {what for each in gone for what in each}


def test_a_message_that_is_missing_in_the_log_is_found(run: Simulated) -> None:
    assert account(run.log(without(OperatorCommand, 100))).differences == {"messages missing in the log": 1}


def test_losses_on_the_bus_are_counted_by_the_reader(run: Simulated) -> None:
    end = end_of(run)
    (source,) = end.sources
    fewer = LinkSource(source.source, source.epoch, source.first, source.newest, source.received - 3)
    log = run.log(changed(LinkState, -1, sources=(fewer,), entered=end.entered - 3, delivered=end.delivered - 3))

    assert account(log).differences == {}
    assert account(log).lost_on_bus == 3
    assert "− 3 lost on the bus" in account(log).text


def test_a_killed_reader_is_accounted_for_up_to_its_last_state(run: Simulated) -> None:
    def killed(sent: list[Sent]) -> list[Sent]:
        return [each for each in sent if not (isinstance(each[2], LinkState) and each[2].trigger == "end")]

    found = account(run.log(killed, driver="live"))
    assert found.differences == {}
    assert not found.final
    assert found.sent < account(run.log()).sent


def test_sessions_of_a_reader_are_accounted_for_one_by_one(run: Simulated) -> None:
    def twice(sent: list[Sent]) -> list[Sent]:
        again = [
            (topic, replace(header, epoch=2), body)
            for topic, header, body in sent
            if header.source == "filter" and isinstance(body, (LinkState, LinkEvent))
        ]
        return sent + again

    accounts = [each for each in link_accounts(run.log(twice, driver="live")) if each.link == LINK]
    assert [(each.epoch, each.differences) for each in accounts] == [(1, {}), (2, {})]
