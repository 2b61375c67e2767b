"""WebSocket server of Foxglove's protocol, with a channel for each topic of the view."""

import socket
from collections.abc import Iterator
from contextlib import contextmanager

import foxglove
from foxglove import Channel, Context, Schema
from mcap.well_known import MessageEncoding, SchemaEncoding

from passafe_services.bridge.errors import BridgePortError
from passafe_services.viewer.view_message import ViewMessage, ViewTopic

MOST_WAITING = 1024
"""Messages that wait for a slow client; the oldest is dropped."""


class ViewerServer:
    """Server that is open; made by ``open_viewer_server``.

    Args:
        context: Where its channels are.

    Attributes:
        port: TCP port at which it listens.
    """

    def __init__(self, context: Context, port: int) -> None:
        self.port = port
        self._context = context
        self._channels: dict[str, tuple[ViewTopic, Channel]] = {}

    def show(self, view: ViewMessage) -> None:
        """Send a message to every client that has asked for its topic."""
        known = self._channels.get(view.topic.name)
        if known is None or known[0] is not view.topic:
            if known is not None:
                known[1].close()  # its type has grown: clients learn of another channel
            schema = Schema(name=view.topic.schema_name, encoding=SchemaEncoding.Protobuf, data=view.topic.schema)
            channel = Channel(
                view.topic.name, schema=schema, message_encoding=MessageEncoding.Protobuf, context=self._context
            )
            known = self._channels[view.topic.name] = view.topic, channel
        known[1].log(view.message.SerializeToString(), log_time=view.time_ns)


@contextmanager
def open_viewer_server(host: str, port: int) -> Iterator[ViewerServer]:
    """Open a server and close it at the end of the block.

    Args:
        host: Address at which it listens.
        port: TCP port; 0 takes a free one.

    Raises:
        BridgePortError: It cannot listen there.
    """
    _require_free(host, port)
    context = Context()
    try:
        server = foxglove.start_server(
            name="passafe", host=host, port=port, context=context, message_backlog_size=MOST_WAITING
        )
    except RuntimeError as error:  # of the library's own server, which names no other class
        raise BridgePortError(host, port, str(error)) from error
    try:
        yield ViewerServer(context, server.port)
    finally:
        server.stop()


def _require_free(host: str, port: int) -> None:
    """Check that an address can be listened on: the library says it less plainly."""
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        with socket.socket(family, kind, protocol) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind(address)
    except OSError as error:
        raise BridgePortError(host, port, error.strerror or str(error)) from error
