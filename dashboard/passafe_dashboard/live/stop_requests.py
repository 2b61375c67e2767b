"""Press and clear the emergency stop on a page's request."""

import asyncio
from collections.abc import Callable
from typing import Any, Final

from passafe_protocol.messages import EmergencyStop, StopClear
from passafe_protocol.stop_request import StopRequest, press_id

from passafe_dashboard.errors import NothingToStopError, StopAnswerError, StopNameError
from passafe_dashboard.live.broadcast import Broadcast
from passafe_dashboard.live.page_state import stop_json

Json = dict[str, Any]
Publish = Callable[[EmergencyStop | StopClear, int], None]
"""Publishes a request at a monotonic time, ns."""

ANSWER_S: Final = 3.0


class StopRequests:
    """Requests to the plant's emergency stop, repeated until a plant state answers.

    Args:
        broadcast: Source of the plant states.
        publish: Publishes a request.
        epoch: Session of the dashboard.
        answer_s: How long to wait for an answer.
    """

    def __init__(self, broadcast: Broadcast, publish: Publish, *, epoch: int, answer_s: float = ANSWER_S) -> None:
        self._broadcast = broadcast
        self._publish = publish
        self._epoch = epoch
        self._answer_s = answer_s
        self._presses = 0

    async def press(self) -> Json:
        """Press the emergency stop; return the stop that the plant has latched.

        Raises:
            NothingToStopError: No run is going on.
            StopAnswerError: No answer came.
        """
        session = self._broadcast.feed.session
        if session is not None and session["state"] == "stopped":
            raise NothingToStopError
        self._presses += 1
        press = EmergencyStop(press_id(self._epoch, self._presses), "pressed on the page")
        return await self._repeat(StopRequest(press))

    async def clear(self, stop: int) -> Json:
        """Clear the emergency stop of this id; return the stop that is latched afterwards, if somebody pressed again.

        Raises:
            StopNameError: Another stop is latched, or none.
            StopAnswerError: No answer came.
        """
        state = self._broadcast.feed.run.state
        latched = 0 if state is None else state.stop
        if not latched or stop != latched:
            raise StopNameError(stop, latched)
        return await self._repeat(StopRequest(StopClear(stop, "cleared on the page")))

    async def _repeat(self, request: StopRequest) -> Json:
        broadcast = self._broadcast
        try:
            async with asyncio.timeout(self._answer_s):
                while not request.is_done:
                    now_ns = broadcast.clock()
                    body = request.due(now_ns)
                    if body is not None:
                        self._publish(body, now_ns)
                    await broadcast.wait_for_frame()
                    if broadcast.feed.run.state is not None:
                        request.observe(broadcast.feed.run.state)
        except TimeoutError as error:
            raise StopAnswerError(self._answer_s) from error
        return stop_json(broadcast.feed)
