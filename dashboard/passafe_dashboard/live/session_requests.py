"""Start, end and change runs on a page's request: ask the demo's supervisor, keep the state that it tells."""

import asyncio
import socket
from itertools import count
from typing import Final

from passafe_services.session.control_channel import ControlChannel
from passafe_services.session.control_messages import (
    FROM_SUPERVISOR,
    NumberedRequest,
    PageRequest,
    RequestAnswer,
    SessionState,
)

from passafe_dashboard.errors import NoSessionError, SessionAnswerError, SessionRefusedError
from passafe_dashboard.live.feed import Feed

ANSWER_S: Final = 20.0
"""Time for an answer: a run is checked before it is accepted, which takes seconds where processors are busy."""

MOST_WAITING: Final = 16
"""Requests that may wait for their answers."""


class SessionRequests:
    """Requests to the session of a demo, with their answers.

    Args:
        feed: Where the state of the session is shown.
        channel: Descriptor of the channel to the supervisor; ``None``: there is no demo, all requests are refused.
        answer_s: How long to wait for an answer.
    """

    def __init__(self, feed: Feed, channel: int | None = None, *, answer_s: float = ANSWER_S) -> None:
        self._feed = feed
        self._end = None if channel is None else socket.socket(fileno=channel)
        self._answer_s = answer_s
        self._channel: ControlChannel[RequestAnswer | SessionState] | None = None
        self._numbers = count(1)
        self._waiting: dict[int, asyncio.Future[RequestAnswer]] = {}

    @property
    def is_stopped(self) -> bool:
        """True if the robot's emergency stop is latched, which a new plant must not lose."""
        state = self._feed.run.state
        return state is not None and bool(state.stop)

    async def run(self) -> None:
        """Receive states and answers until the supervisor closes the channel."""
        if self._end is None:
            return
        self._channel = await ControlChannel[RequestAnswer | SessionState].over(self._end, FROM_SUPERVISOR)
        try:
            while (message := await self._channel.receive()) is not None:
                if isinstance(message, SessionState):
                    self._feed.session = message.json_dict()
                elif (waiting := self._waiting.get(message.number)) is not None and not waiting.done():
                    waiting.set_result(message)
        finally:
            self._feed.session = None
            self._channel.close()
            self._channel = None
            for waiting in self._waiting.values():
                if not waiting.done():
                    waiting.set_exception(NoSessionError())

    async def ask(self, request: PageRequest) -> int:
        """Ask the supervisor; return the number of the run that was going on when it accepted.

        Raises:
            NoSessionError: No demo supervises this system.
            SessionRefusedError: The supervisor refuses.
            SessionAnswerError: It does not answer.
        """
        channel, number = self._channel, next(self._numbers)
        if channel is None:
            raise NoSessionError
        if len(self._waiting) >= MOST_WAITING:
            raise SessionRefusedError("", f"{MOST_WAITING} requests are waiting for their answers")
        waiting: asyncio.Future[RequestAnswer] = asyncio.get_running_loop().create_future()
        self._waiting[number] = waiting
        try:
            if not channel.send(NumberedRequest(number=number, request=request)):
                raise NoSessionError
            async with asyncio.timeout(self._answer_s):
                answer = await waiting
        except TimeoutError as error:
            raise SessionAnswerError(self._answer_s) from error
        finally:
            del self._waiting[number]
        if answer.refusal is not None:
            raise SessionRefusedError(answer.refusal.field, answer.refusal.reason)
        return answer.run
