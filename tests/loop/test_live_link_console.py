"""Links of real processes, looked at and changed from another one while they run."""

import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import suppress

import pytest
from msgspec.structs import replace
from passafe_protocol.codec import decode
from passafe_protocol.errors import ProtocolError
from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.link_wire import parameters_of, settings_of
from passafe_protocol.messages import Header, LinkConfig, LinkState, Message
from passafe_protocol.topics import INPUT, LINK_CONFIG, LINK_EVENT, LINK_STATE
from passafe_services.loop.bus import open_bus
from passafe_services.loop.errors import LinkNameError, LinkRefusedError, LinkSilentError
from passafe_services.loop.link_console import LinkConsole, open_link_console
from passafe_services.loop.router_endpoint import RouterEndpoint

pytestmark = pytest.mark.live

PATIENCE_S = 20.0
LINK = "operator-to-filter"


class BusRecorder:
    """Receive every message of every topic."""

    def __init__(self, port: int) -> None:
        self._opened = open_bus(RouterEndpoint(port=port))
        self._reader = self._opened.__enter__().recording_reader()
        self.received: list[tuple[Header, Message]] = []

    def until(self, enough: Callable[[list[tuple[Header, Message]]], bool]) -> list[tuple[Header, Message]]:
        end = time.monotonic() + PATIENCE_S
        while not enough(self.received):
            assert time.monotonic() < end, len(self.received)
            for key, data in self._reader.drain():
                for topic in (INPUT, LINK_CONFIG, LINK_EVENT, LINK_STATE):
                    if key.endswith(f"/{topic.name}"):
                        with suppress(ProtocolError):
                            self.received.append(decode(topic, data))
            time.sleep(0.005)
        return self.received

    def of(self, kind: type) -> list[tuple[Header, Message]]:
        return [(header, body) for header, body in self.received if isinstance(body, kind)]

    def close(self) -> None:
        self._opened.__exit__(None, None, None)


@pytest.fixture
def recorder(router: object, port: int) -> Iterator[BusRecorder]:
    del router
    opened = BusRecorder(port)
    yield opened
    opened.close()


@pytest.fixture
def console(router: object, port: int) -> Iterator[LinkConsole]:
    del router
    with open_link_console(RouterEndpoint(port=port), answer_s=PATIENCE_S) as opened:
        yield opened


def test_running_link_is_changed_and_answers_with_its_settings(
    start: Callable, port: int, recorder: BusRecorder, console: LinkConsole
) -> None:
    start("filter", "--port", port).wait_ready("filter")
    start("operator", "--port", port).wait_ready("operator")
    recorder.until(lambda _: len(recorder.of(INPUT.body)) >= 20)
    before = console.state(LINK)
    wanted = replace(before.parameters, delay_s=0.1, jitter_s=0.01)
    answer = console.configure(LINK, wanted)

    assert settings_of(before.parameters) == LinkSettings()
    assert answer.parameters == wanted
    assert (answer.trigger, answer.config_source, answer.refusal) == ("requested", "console", "")
    recorder.until(lambda _: any(_lag_s(body) >= 0.09 for _, body in recorder.of(INPUT.body)))
    (request_header, _), *_ = recorder.of(LinkConfig)
    (state_header, reported), *_ = [(h, s) for h, s in recorder.of(LinkState) if s.trigger == "requested"]
    assert (reported.config_epoch, reported.config_sequence) == (request_header.epoch, request_header.sequence)
    lags = [(header.sent_ns, _lag_s(body)) for header, body in recorder.of(INPUT.body)]
    assert min(lag for sent_ns, lag in lags if sent_ns < request_header.sent_ns) < 0.05
    late = [lag for sent_ns, lag in lags if sent_ns > state_header.sent_ns + 50_000_000]
    assert min(late) >= 0.09 - 1e-6


def _lag_s(body: Message) -> float:
    """Return the transit time of a command, from the answer of the toy filter."""
    _, received_ns, _, sent_ns = body.u
    return (received_ns - sent_ns) * 1e-9


def test_the_last_state_accounts_for_every_message(start: Callable, port: int, recorder: BusRecorder) -> None:
    filtering = start("filter", "--port", port, "--delay", 0.05, "--loss", 0.3)
    filtering.wait_ready("filter")
    start("operator", "--port", port, "--steps", 300).wait_ready("operator")
    recorder.until(lambda _: len(recorder.of(INPUT.body)) >= 150)
    os.kill(filtering.pid, signal.SIGTERM)
    recorder.until(lambda _: any(state.trigger == "end" for _, state in recorder.of(LinkState)))
    end = recorder.of(LinkState)[-1][1]

    assert end.entered + end.duplicated == end.delivered + end.dropped_loss + end.in_flight
    assert end.dropped_loss == len(recorder.of(LINK_EVENT.body)) > 0
    (source,) = end.sources
    assert source.received == end.entered == source.newest - source.first + 1


def test_contradictions_are_refused_with_the_reason(
    start: Callable, port: int, console: LinkConsole, monkeypatch: pytest.MonkeyPatch
) -> None:
    start("filter", "--port", port).wait_ready("filter")
    contradiction = replace(parameters_of(LinkSettings()), distribution="histogram")

    with pytest.raises(LinkRefusedError, match="quantiles_s: got \\(\\), allowed 2 to 64") as caught:
        console.configure(LINK, contradiction)
    assert caught.value.link == LINK
    assert settings_of(console.state(LINK).parameters) == LinkSettings()
    monkeypatch.setattr(console, "_answer_s", 1.5)
    assert list(console.states()) == [LINK]


def test_missing_answer_is_an_error_within_the_timeout(port: int, router: object) -> None:
    del router
    with open_link_console(RouterEndpoint(port=port), answer_s=0.7) as console:
        began = time.monotonic()
        with pytest.raises(LinkSilentError, match=r"no answer from plant within 0\.7 s: is it running"):
            console.configure("filter-to-plant", parameters_of(LinkSettings()))
        with pytest.raises(LinkSilentError):
            console.state("filter-to-plant")
        assert console.states() == {}
        assert time.monotonic() - began < 5.0
        with pytest.raises(LinkNameError, match="allowed operator-to-filter"):
            console.state("filter-to-moon")
