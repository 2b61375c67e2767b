"""Limit what a connection may cost: how many there are, how long they take, how silent they may be.

uvicorn limits neither the time that a request takes to arrive nor, for WebSockets, the number of connections; and it
closes a silent WebSocket in order, which waits for good for a client that reads nothing.
"""

from asyncio import TimerHandle, Transport
from typing import Final

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.protocol import State

MAX_CONNECTIONS: Final = 256
"""Connections at a time, WebSockets included; any more are closed at once."""

HEADER_S: Final = 5.0
"""Time for the head of the first request to arrive, s."""

REQUEST_S: Final = 30.0
"""Time for the rest of a request, then for the client to take the answer and send the head of the next, s."""


class LimitedHttp(H11Protocol):
    """HTTP connection that is dropped when a request is late, or when there are too many connections."""

    _deadline: TimerHandle | None = None

    def connection_made(self, transport: Transport) -> None:  # type: ignore[override]  # as in uvicorn
        """Accept a connection if there are not too many."""
        super().connection_made(transport)
        if len(self.connections) > MAX_CONNECTIONS:
            transport.abort()
        else:
            self._allow(HEADER_S)

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget the connection."""
        self._allow(None)
        super().connection_lost(exc)

    def handle_events(self) -> None:
        """Handle what has arrived; the head of a request leaves time for the rest."""
        before = self.cycle
        super().handle_events()
        if self.cycle is not before and not self.cycle.response_complete and not self.transport.is_closing():
            self._allow(REQUEST_S)

    def on_response_complete(self) -> None:
        """Wait for the next request."""
        self._allow(None if self.transport.is_closing() else REQUEST_S)
        super().on_response_complete()

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        """Hand the connection over to a WebSocket."""
        self._allow(None)
        super().handle_websocket_upgrade(event)

    def _allow(self, time_s: float | None) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
        self._deadline = None if time_s is None else self.loop.call_later(time_s, self.transport.abort)


class LimitedWebSocket(WebSocketsSansIOProtocol):
    """WebSocket that is dropped when the client does not answer a ping, whether or not it reads."""

    def shutdown(self) -> None:
        """End the connection with the server; one that is ending already is dropped, since uvicorn would raise."""
        if self.handshake_complete and self.conn.state is not State.OPEN:
            self.transport.abort()
        else:
            super().shutdown()

    def keepalive_timeout(self) -> None:
        """Report the timeout to the client, and drop it without waiting for it to read."""
        super().keepalive_timeout()
        self.transport.abort()
