"""The server speaks the protocol that viewers speak: a WebSocket client subscribes and decodes."""

import asyncio
import base64
import json
import socket
import struct
from typing import Any

import pytest
import websockets
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from passafe_protocol.topics import STATE, TICK
from passafe_services.bridge.errors import BridgePortError
from passafe_services.bridge.viewer_server import ViewerServer, open_viewer_server
from passafe_services.tables.layout import TableLayout
from passafe_services.tables.log_messages import LoggedRow
from passafe_services.viewer.named_numbers import NamedNumbers
from passafe_services.viewer.view_message import ViewMessage
from small_log import WALL_NS, header, state, tick

HOST = "127.0.0.1"
DATA = 1
"""Operation code of a message with data."""

PROTOCOL = "foxglove.sdk.v1"


def state_view(k: int) -> ViewMessage:
    layout = TableLayout(STATE)
    layout.note(state(k))
    return NamedNumbers(layout).view(LoggedRow(STATE, "", WALL_NS, header("plant", k), state(k), b""), WALL_NS)


async def first_message(server: ViewerServer, view: ViewMessage) -> tuple[dict[str, Any], int, bytes]:
    """Return channel, time and payload of the first message that a client receives."""
    uri = f"ws://{HOST}:{server.port}"
    async with websockets.connect(uri, subprotocols=[websockets.Subprotocol(PROTOCOL)]) as client:
        server.show(view)
        channel: dict[str, Any] = {}
        async for text in client:
            if isinstance(text, str) and (said := json.loads(text))["op"] == "advertise":
                [channel] = said["channels"]
                break
        wanted = {"op": "subscribe", "subscriptions": [{"id": 7, "channelId": channel["id"]}]}
        await client.send(json.dumps(wanted))
        while True:
            server.show(view)
            try:
                data = await asyncio.wait_for(client.recv(), timeout=0.05)
            except TimeoutError:
                continue
            if isinstance(data, bytes) and data[0] == DATA:
                _, time_ns = struct.unpack("<IQ", data[1:13])
                return channel, time_ns, data[13:]


def test_a_client_subscribes_and_decodes() -> None:
    view = state_view(3)
    with open_viewer_server(HOST, 0) as server:
        channel, time_ns, payload = asyncio.run(asyncio.wait_for(first_message(server, view), timeout=20))

    assert (channel["topic"], channel["schemaName"]) == ("/passafe/state", "passafe.table.State")
    schema = FileDescriptorSet.FromString(base64.b64decode(channel["schema"]))
    assert "x_1" in {field.name for field in schema.file[-1].message_type[0].field}
    assert time_ns == WALL_NS
    assert view.topic.message_type.FromString(payload).x_1 == 3.0


def test_a_type_that_grows_takes_the_place_of_the_one_before() -> None:
    layout = TableLayout(TICK)
    numbers = NamedNumbers(layout)
    with open_viewer_server(HOST, 0) as server:
        for one in (tick(0, rows=()), tick(1)):
            layout.note(one)
            server.show(numbers.view(LoggedRow(TICK, "", WALL_NS, header("filter", 0), one, b""), WALL_NS))

        assert server.port > 0


def test_a_port_in_use_is_refused_in_one_line() -> None:
    with socket.socket() as taken:
        taken.bind((HOST, 0))
        taken.listen()
        port = taken.getsockname()[1]

        with pytest.raises(BridgePortError, match=f"{port}: cannot listen") as caught, open_viewer_server(HOST, port):
            pass

    assert "\n" not in str(caught.value)


def test_an_address_of_another_host_is_refused() -> None:
    with pytest.raises(BridgePortError), open_viewer_server("192.0.2.1", 0):
        pass
