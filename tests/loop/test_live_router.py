"""The router as a process."""

import os
import signal
import socket
from collections.abc import Callable

import pytest

pytestmark = pytest.mark.live


@pytest.mark.parametrize("signum", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_it_cleanly(start: Callable, port: int, signum: int) -> None:
    router = start("router", "--port", port)
    router.wait_ready("router")
    os.kill(router.pid, signum)
    assert router.output() == {"reason": "SIGNAL"}
    assert router.end() == (0, "")


def test_the_end_of_the_lifeline_ends_it_cleanly(start: Callable, port: int) -> None:
    router = start("router", "--port", port, "--lifeline")
    router.wait_ready("router")
    router.cut_lifeline()
    assert router.output() == {"reason": "LIFELINE"}
    assert router.end() == (0, "")


def test_a_port_that_another_router_has_is_one_clear_error(start: Callable, router: object, port: int) -> None:
    del router
    second = start("router", "--port", port)
    assert second.output() == {
        "fault": "PortInUseError",
        "text": f"port {port} on 127.0.0.1 is in use: is another router running? Choose another port.",
    }
    assert second.end() == (2, "")


def test_a_port_that_any_program_has_is_one_clear_error(start: Callable) -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        router = start("router", "--port", other.getsockname()[1])
        assert router.output()["fault"] == "PortInUseError"
        assert router.end() == (2, "")


def test_a_port_out_of_range_is_one_clear_error(start: Callable) -> None:
    router = start("router", "--port", 70_000)
    assert router.output() == {"fault": "EndpointError", "text": "port: got 70000, allowed 1 to 65535"}
