import socket

import pytest
from passafe_dashboard.address import listening_socket, require_free_page_port
from passafe_dashboard.errors import PageAddressError, PagePortInUseError

from passafe.errors import PassafeError


def test_a_taken_port_is_named_with_what_to_do() -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        with pytest.raises(PagePortInUseError) as refused:
            require_free_page_port("127.0.0.1", port)
    message = str(refused.value)
    assert str(port) in message
    assert "choose another port" in message
    assert "\n" not in message
    assert (refused.value.host, refused.value.port) == ("127.0.0.1", port)


def test_a_free_port_is_free_afterwards() -> None:
    with listening_socket("127.0.0.1", 0) as listener:
        port = listener.getsockname()[1]
    require_free_page_port("127.0.0.1", port)
    require_free_page_port("127.0.0.1", port)


@pytest.mark.parametrize(
    ("host", "port"), [("192.0.2.1", 0), ("no such host", 0), ("127.0.0.1", 70_000), ("127.0.0.1", -1)]
)
def test_invalid_address_is_refused_in_one_line(host: str, port: int) -> None:
    with pytest.raises(PageAddressError) as refused:
        require_free_page_port(host, port)
    assert not isinstance(refused.value, PagePortInUseError)
    assert host in str(refused.value)
    assert "\n" not in str(refused.value)
    assert isinstance(refused.value, PassafeError)
