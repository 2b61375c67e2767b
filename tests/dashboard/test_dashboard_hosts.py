"""The page answers to its own names and its own pages, and to no one else."""

import socket
from collections.abc import Iterator

import httpx
import pytest
from closed_form import paper_scenario
from passafe_dashboard.live.feed import Feed
from passafe_dashboard.routes.own_hosts import OwnHosts
from served_page import FastRun, ServedPage, frames, serve_page
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect
from websockets.typing import Origin

EVIL = "rebound.example"
EVERYWHERE = "::"
"""Every interface."""


@pytest.fixture(scope="module")
def run() -> FastRun:
    return FastRun(Feed(paper_scenario()))


@pytest.fixture(scope="module")
def page(run: FastRun) -> Iterator[ServedPage]:
    with serve_page(run) as served:
        yield served


@pytest.mark.parametrize(
    ("hosts", "header", "allowed"),
    [
        (OwnHosts(), "localhost", True),
        (OwnHosts(), "LocalHost:8080", True),
        (OwnHosts(), "127.0.0.1:1", True),
        (OwnHosts(), "127.9.9.9", True),
        (OwnHosts(), "[::1]:8080", True),
        (OwnHosts(), "192.0.2.7:8080", False),
        (OwnHosts(), EVIL, False),
        (OwnHosts(), f"localhost.{EVIL}", False),
        (OwnHosts(), f"{EVIL}@localhost", False),
        (OwnHosts(), "localhost:8080:9090", False),
        (OwnHosts(), "[::1", False),
        (OwnHosts(), "[::g]", False),
        (OwnHosts(), "", False),
        (OwnHosts.of(EVERYWHERE), "192.0.2.7:8080", True),
        (OwnHosts.of(EVERYWHERE), "[2001:db8::7]", True),
        (OwnHosts.of(EVERYWHERE), EVIL, False),
        (OwnHosts.of(EVERYWHERE, ["Robot-PC"]), "robot-pc:8080", True),
        (OwnHosts.of("robot-pc"), "robot-pc", True),
        (OwnHosts.of("::1"), "192.0.2.7", False),
        (OwnHosts.of("localhost"), "192.0.2.7", False),
    ],
)
def test_host_header_names_this_server(hosts: OwnHosts, header: str, allowed: bool) -> None:
    assert hosts.allow(header) is allowed


@pytest.mark.parametrize(
    ("host", "origin", "status"),
    [(EVIL, f"http://{EVIL}", 421), (EVIL, None, 421), (None, f"http://{EVIL}", 403), (None, "null", 403)],
)
def test_another_site_may_ask_for_nothing(
    page: ServedPage, run: FastRun, host: str | None, origin: str | None, status: int
) -> None:
    headers = ({} if host is None else {"host": host}) | ({} if origin is None else {"origin": origin})
    with httpx.Client(base_url=page.url, headers=headers) as client:
        answers = [client.get(path) for path in ("/", "/api/status", "/api/links", "/healthz", "/static/live/main.js")]
        answers.append(client.put("/api/links/plant-to-filter", json={"delay_s": 0.1}))
    assert {answer.status_code for answer in answers} == {status}
    assert run.links.requests == []


def test_the_answer_to_a_wrong_host_says_what_to_do(page: ServedPage) -> None:
    answer = httpx.get(page.url, headers={"host": EVIL})

    assert answer.text == f"host: got '{EVIL}', allowed localhost, or one named with --page-name"
    assert len(httpx.get(page.url, headers={"host": "x" * 5000}).text) < 200


def test_socket_of_a_rebound_name_is_refused(page: ServedPage) -> None:
    with (
        pytest.raises(InvalidStatus) as refused,
        connect(f"ws://{EVIL}/live", sock=_socket(page), origin=Origin(f"http://{EVIL}")),
    ):
        pass
    assert refused.value.response.status_code == 421


def test_a_page_by_another_own_name_is_let_in(page: ServedPage) -> None:
    own = f"localhost:{page.port}"
    assert httpx.get(page.url, headers={"host": own}).status_code == 200
    with connect(f"ws://{own}/live", sock=_socket(page), origin=Origin(f"http://{own}"), max_queue=None) as connection:
        assert frames(connection, 1)


def test_two_hosts_in_one_request_are_refused(page: ServedPage) -> None:
    with _socket(page) as client:
        client.sendall(f"GET / HTTP/1.1\r\nHost: {page.host}\r\nHost: {EVIL}\r\n\r\n".encode())
        assert client.recv(12) in (b"HTTP/1.1 400", b"HTTP/1.1 421")


def _socket(page: ServedPage) -> socket.socket:
    return socket.create_connection(("127.0.0.1", page.port), 30)


def test_the_browser_runs_nothing_inline_or_from_elsewhere(page: ServedPage) -> None:
    policy = page.get("/").headers["content-security-policy"]
    assert policy.startswith("default-src 'none'; script-src 'self'; connect-src 'self'")
    assert "unsafe" not in policy
    assert "frame-ancestors 'none'" in policy
