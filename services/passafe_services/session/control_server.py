"""Serves a session to its page over control channels."""

import asyncio
import socket
from collections.abc import Coroutine
from typing import Any

from passafe_services.session.control_channel import ControlChannel
from passafe_services.session.control_messages import FROM_PAGE, NumberedRequest, RequestAnswer
from passafe_services.session.run_requests import RunRequests
from passafe_services.session.run_session import RunSession


class ControlServer:
    """Supervisor's side of the control channels: takes requests, and publishes the state whenever it changes.

    Args:
        session: The session.
        requests: Carries requests out.
    """

    def __init__(self, session: RunSession, requests: RunRequests) -> None:
        self._session = session
        self._requests = requests
        self._channels: set[ControlChannel[NumberedRequest]] = set()
        self._tasks: set[asyncio.Task[None]] = set()
        self._is_due = False
        session.on_change = self.publish

    def connect(self, _name: str, end: socket.socket) -> None:
        """Serve a process that was started with a channel, over this end of it."""
        self._begin(self._serve(end))

    def publish(self) -> None:
        """Send the state to every page, once for all changes of this turn of the event loop."""
        if not self._is_due:
            self._is_due = True
            asyncio.get_running_loop().call_soon(self._send_state)

    def _send_state(self) -> None:
        self._is_due = False
        state = self._session.state
        for channel in self._channels:
            channel.send(state)

    async def _serve(self, end: socket.socket) -> None:
        channel = await ControlChannel[NumberedRequest].over(end, FROM_PAGE)
        self._channels.add(channel)
        try:
            channel.send(self._session.state)
            while (message := await channel.receive()) is not None:
                self._begin(self._answer(channel, message))
        finally:
            self._channels.discard(channel)
            channel.close()

    async def _answer(self, channel: ControlChannel[NumberedRequest], message: NumberedRequest) -> None:
        refusal = await self._requests.handle(message.request)
        channel.send(RequestAnswer(number=message.number, run=self._session.number, refusal=refusal))

    def _begin(self, work: Coroutine[Any, Any, None]) -> None:
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
