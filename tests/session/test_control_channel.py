"""The channel between supervisor and page."""

import asyncio
import socket
from collections.abc import Awaitable, Callable
from typing import Any

import passafe_services.session.control_channel
import pytest
from passafe_services.session.control_channel import ControlChannel
from passafe_services.session.control_messages import (
    FROM_PAGE,
    FROM_SUPERVISOR,
    EndRun,
    NumberedRequest,
    Refusal,
    RequestAnswer,
    RunChoices,
    StartRun,
)

REQUEST = NumberedRequest(number=7, request=StartRun(choices=RunChoices(scenario="two\nlines", rate_hz=250.0)))
ANSWER = RequestAnswer(number=7, run=2, refusal=Refusal(field="rate_hz", reason="got é"))


def with_both_ends(test: Callable[[ControlChannel[Any], ControlChannel[Any], socket.socket], Awaitable[None]]) -> None:
    """Run a test with supervisor's and page's end, and the page's socket."""

    async def run() -> None:
        one, other = socket.socketpair()
        supervisor = await ControlChannel[Any].over(one, FROM_PAGE)
        page = await ControlChannel[Any].over(other, FROM_SUPERVISOR)
        try:
            await test(supervisor, page, other)
        finally:
            supervisor.close()
            page.close()
            await asyncio.sleep(0)  # lets the transports close

    asyncio.run(run())


def test_messages_arrive_as_they_were_sent_and_in_order() -> None:
    async def test(supervisor: ControlChannel[Any], page: ControlChannel[Any], _end: socket.socket) -> None:
        later = NumberedRequest(number=8, request=EndRun())
        assert page.send(REQUEST)
        assert page.send(later)
        assert supervisor.send(ANSWER)
        assert [await supervisor.receive(), await supervisor.receive()] == [REQUEST, later]
        assert await page.receive() == ANSWER

    with_both_ends(test)


@pytest.mark.parametrize(
    "line",
    [
        b"not json\n",
        b"{}\n",
        b'{"number": 1, "request": {"type": "format the disk"}}\n',
        b'{"number": 1, "request": {"type": "start", "choices": {"scenario": "a", "rate_hz": NaN}}}\n',
        b'{"number": 1, "request": {"type": "end", "more": 1}}\n',
        b"x" * 300_000 + b"\n",
        b'{"number": 1',
    ],
)
def test_what_is_no_message_ends_the_channel(line: bytes) -> None:
    async def test(supervisor: ControlChannel[Any], page: ControlChannel[Any], _end: socket.socket) -> None:
        page._writer.write(line)
        page._writer.write_eof()
        assert await supervisor.receive() is None

    with_both_ends(test)


def test_end_that_does_not_read_costs_bounded_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(passafe_services.session.control_channel, "MOST_UNSENT_BYTES", 10_000)

    async def test(supervisor: ControlChannel[Any], page: ControlChannel[Any], _end: socket.socket) -> None:
        page._reader._transport.pause_reading()
        sent = 0
        while supervisor.send(ANSWER):
            sent += 1
        assert sent > 10
        waiting = supervisor._writer.transport.get_write_buffer_size()
        assert waiting < 11_000

    with_both_ends(test)


def test_nothing_is_sent_to_an_end_that_has_closed() -> None:
    async def test(supervisor: ControlChannel[Any], page: ControlChannel[Any], _end: socket.socket) -> None:
        supervisor.close()
        assert not supervisor.send(ANSWER)
        assert await page.receive() is None

    with_both_ends(test)
