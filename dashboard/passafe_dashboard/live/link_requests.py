"""Read the links, and change one on a page's request."""

import asyncio
from collections.abc import Callable
from typing import Any, Final

from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.link_wire import parameters_of, settings_of
from passafe_protocol.messages import LinkConfig
from passafe_protocol.topics import LINKS
from passafe_services.scenarios.link_schema import LinkFields
from passafe_services.scenarios.link_schema import ScenarioLink as CheckedSettings
from pydantic import ValidationError

from passafe_dashboard.errors import LinkAnswerError, LinkUpdateError
from passafe_dashboard.live.broadcast import Broadcast
from passafe_dashboard.live.page_state import link_json

Json = dict[str, Any]
Publish = Callable[[LinkConfig, int], tuple[str, int, int]]
"""Publishes a request at a monotonic time, ns, and returns source, epoch and number of the message."""

ANSWER_S: Final = 3.0


class LinkUpdate(LinkFields):
    """Settings that a page requests; others keep their value. A trace can only be given when a system starts."""

    trace: None = None


class LinkRequests:
    """Requests to links, with their answers.

    Args:
        broadcast: Source of the answers.
        publish: Publishes a request.
        answer_s: How long to wait for an answer.
    """

    def __init__(self, broadcast: Broadcast, publish: Publish, *, answer_s: float = ANSWER_S) -> None:
        self._broadcast = broadcast
        self._board = broadcast.feed.links
        self._publish = publish
        self._answer_s = answer_s

    def states(self) -> list[Json]:
        """Return every link with its settings in force and counts, as far as they are known."""
        return [link_json(self._broadcast.feed, name, self._broadcast.clock()) for name in LINKS]

    async def change(self, name: str, update: LinkUpdate) -> Json:
        """Request other settings of a link; return it with those in force.

        Args:
            name: One of ``LINKS``.
            update: Settings to change.

        Raises:
            LinkUpdateError: Settings that do not go together, here or at the process that reads the link.
            LinkAnswerError: No answer came.
        """
        known = self._board.newest(name)
        if known is None:
            raise LinkAnswerError(name, LINKS[name].reader, "its state was not received yet")
        wanted = _changed(settings_of(known.state.parameters), update)
        source, epoch, number = self._publish(LinkConfig(name, parameters_of(wanted)), self._broadcast.clock())
        try:
            async with asyncio.timeout(self._answer_s):
                while (answer := self._board.answer(name, source, epoch, number)) is None:
                    await self._broadcast.wait_for_frame()
        except TimeoutError as error:
            raise LinkAnswerError(name, LINKS[name].reader, f"no answer within {self._answer_s:g} s") from error
        if answer.state.refusal:
            raise LinkUpdateError((), update.model_dump(exclude_unset=True), answer.state.refusal)
        return link_json(self._broadcast.feed, name, self._broadcast.clock())


def _changed(before: LinkSettings, update: LinkUpdate) -> LinkSettings:
    values = {field: getattr(before, field) for field in CheckedSettings.model_fields if field != "trace"}
    requested = update.model_dump(exclude_unset=True)
    try:
        return CheckedSettings.model_validate(values | requested).settings()
    except ValidationError as error:
        first = error.errors()[0]
        raise LinkUpdateError(first["loc"], requested, first["msg"].removeprefix("Value error, ")) from error
