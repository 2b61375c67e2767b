"""The endpoint of the router."""

import pytest
from passafe_services.loop.errors import EndpointError
from passafe_services.loop.router_endpoint import RouterEndpoint


@pytest.mark.parametrize(
    ("host", "locator"),
    [("127.0.0.1", "tcp/127.0.0.1:7000"), ("::1", "tcp/[::1]:7000"), ("robot.lan", "tcp/robot.lan:7000")],
)
def test_locator(host: str, locator: str) -> None:
    assert RouterEndpoint(host=host, port=7000).locator == locator


@pytest.mark.parametrize("port", [0, -1, 65_536])
def test_a_port_out_of_range_is_refused(port: int) -> None:
    with pytest.raises(EndpointError, match=f"port: got {port}, allowed 1 to 65535"):
        RouterEndpoint(port=port)


@pytest.mark.parametrize("host", ["", "a b", "tcp/localhost", "[::1]", "host?x", "host#x"])
def test_a_host_that_is_none_is_refused(host: str) -> None:
    with pytest.raises(EndpointError, match="allowed a host name or address"):
        RouterEndpoint(host=host, port=7000)
