"""Requests of any kind to any documented route are answered, and never with an error of the server."""

import json
import socket
from collections.abc import Iterator
from itertools import product
from typing import Any
from urllib.parse import quote

import httpx
import pytest
from closed_form import paper_scenario
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from passafe_dashboard.live.feed import Feed
from passafe_dashboard.live.link_requests import LinkUpdate
from passafe_protocol.topics import LINKS
from served_page import FastRun, ServedPage, serve_page

METHODS = ("GET", "PUT", "POST", "DELETE", "PATCH", "HEAD", "OPTIONS")
ANSWERS = {200, 202, 400, 404, 405, 409, 413, 422, 504}
"""Statuses that an answer may have: 504 is that of a process that is silent, 409 that of a stop that is not latched,
or of runs without a demo."""

scalars = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20)
values = st.recursive(
    scalars,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner, max_size=4),
    max_leaves=12,
)
updates = st.dictionaries(st.sampled_from(sorted(LinkUpdate.model_fields)) | st.text(max_size=8), values, max_size=4)
bodies = st.binary(max_size=200) | (updates | values).map(lambda value: json.dumps(value).encode())
names = st.sampled_from(sorted(LINKS)) | st.text(st.characters(codec="utf-8"), min_size=1, max_size=20)


@pytest.fixture(scope="module")
def page() -> Iterator[ServedPage]:
    with serve_page(FastRun(Feed(paper_scenario())), answer_s=0.2) as served:
        yield served


def documented() -> dict[str, Any]:
    run = FastRun(Feed(paper_scenario()))
    paths: dict[str, Any] = run.app().openapi()["paths"]
    return paths


PATHS = sorted(documented())


def test_every_route_is_in_the_description() -> None:
    assert {"/", "/api/status", "/healthz", "/api/links", "/api/links/{name}", "/api/stop"} <= set(PATHS)


@pytest.mark.parametrize(("path", "method"), list(product(PATHS, METHODS)))
def test_every_method_is_answered_or_not_allowed(page: ServedPage, path: str, method: str) -> None:
    url = page.url + path.replace("{name}", "plant-to-filter").replace("{stop}", "7")
    answer = httpx.request(method, url, timeout=30)

    described = method.lower() in documented()[path]
    assert (answer.status_code != 405) is described
    assert answer.status_code in ANSWERS


@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    path=st.sampled_from(PATHS),
    method=st.sampled_from(METHODS),
    name=names,
    body=bodies,
    kind=st.sampled_from(["application/json", "text/plain", "application/json; charset=\xff", ""]),
)
@example(path="/api/links/{name}", method="PUT", name="plant-to-filter", body=b'{"loss": NaN}', kind="application/json")
@example(path="/api/clear/{stop}", method="POST", name="0/", body=b"", kind="application/json")
def test_no_request_makes_the_server_fail(
    page: ServedPage, path: str, method: str, name: str, body: bytes, kind: str
) -> None:
    url = page.url + path.replace("{name}", quote(name, safe="")).replace("{stop}", quote(name, safe=""))
    answer = httpx.request(method, url, content=body, headers={b"content-type": kind.encode("latin-1")}, timeout=30)

    assert answer.status_code in ANSWERS, answer.text
    if answer.status_code == 422:
        assert all(set(problem) == {"type", "loc", "msg"} for problem in answer.json()["detail"])


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(garbage=st.binary(max_size=400), is_socket=st.booleans())
@example(garbage=b"\x81\xfe\xff\xff" + bytes(4), is_socket=True)
def test_any_bytes_leave_the_server_to_others(page: ServedPage, garbage: bytes, is_socket: bool) -> None:
    with socket.create_connection(("127.0.0.1", page.port), 30) as client:
        if is_socket:
            client.sendall(
                f"GET /live HTTP/1.1\r\nHost: {page.host}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
            )
            assert client.recv(12) == b"HTTP/1.1 101"
        client.sendall(garbage)
        client.shutdown(socket.SHUT_WR)
    assert page.get("/healthz").status_code == 200


def test_page_still_answers_after_all_of_it(page: ServedPage) -> None:
    assert page.get("/healthz").json()["ok"] is True
