"""Access to the page: open on loopback, by token over TLS elsewhere, and to nobody without the token."""

import ssl
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest
from closed_form import paper_scenario
from passafe_dashboard.errors import PageAccessError
from passafe_dashboard.live.feed import Feed
from passafe_dashboard.page_access import PageAccess, shown_certificate
from passafe_dashboard.server import page_server
from served_page import FastRun, ServedPage, serve_page
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

TOKEN = "a-token-of-this-test"  # noqa: S105 - of this test alone
ELSEWHERE = "0.0.0.0"  # noqa: S104 - nothing listens


@pytest.mark.parametrize("host", ["127.0.0.1", "::1", "localhost", "127.9.9.9"])
def test_loopback_is_open(host: str) -> None:
    assert PageAccess.of(host) == PageAccess()
    assert PageAccess.of(host, token=TOKEN).token == TOKEN
    assert not PageAccess.of(host, token=TOKEN).is_encrypted
    assert PageAccess.of(host, token="new").is_made  # noqa: S106 - asks for a new one


@pytest.mark.parametrize("host", [ELSEWHERE, "::", "192.0.2.7", "robot-pc"])
def test_other_addresses_ask_for_a_token_over_tls(host: str) -> None:
    made = PageAccess.of(host)
    assert made.is_encrypted
    assert made.is_made
    assert len(made.token) > 30
    assert made.token != PageAccess.of(host).token
    assert PageAccess.of(host, token=TOKEN).token == TOKEN
    assert PageAccess.of(host, is_open=True) == PageAccess()


def test_the_address_shows_a_made_token_and_no_other() -> None:
    made = PageAccess.of(ELSEWHERE)
    assert made.address("192.0.2.7", 80) == f"https://192.0.2.7:80/?token={made.token}"
    assert PageAccess.of(ELSEWHERE, token=TOKEN).address("::1", 80) == "https://[::1]:80/?token=…"
    assert PageAccess().address("127.0.0.1", 80) == "http://127.0.0.1:80/"


def test_options_that_do_not_go_together_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "file.pem"
    for options in ({"certificate": file}, {"key": file}):
        with pytest.raises(PageAccessError, match="together"):
            PageAccess.of(ELSEWHERE, **options)
    with pytest.raises(PageAccessError, match="one of them"):
        PageAccess.of(ELSEWHERE, token=TOKEN, is_open=True)
    for token in ("short", "ä" * 20, "with spaces in its text", "semi;colon;semi;colon"):
        with pytest.raises(PageAccessError, match="at least 16"):
            PageAccess.of(ELSEWHERE, token=token)


def test_a_file_that_is_no_certificate_is_refused(tmp_path: Path) -> None:
    (tmp_path / "c.pem").write_text("none")
    access = PageAccess.of("127.0.0.1", certificate=tmp_path / "c.pem", key=tmp_path / "k.pem")
    with shown_certificate(access, []) as shown, pytest.raises(PageAccessError, match="PEM files"):
        page_server(FastRun(Feed()).app(), shown)


@pytest.fixture(scope="module")
def page() -> Iterator[ServedPage]:
    with serve_page(FastRun(Feed(paper_scenario())), access=PageAccess(token=TOKEN, is_encrypted=True)) as served:
        yield served


@pytest.fixture(scope="module")
def browser() -> Iterator[httpx.Client]:
    with httpx.Client(verify=False, timeout=30) as client:  # noqa: S501 - the certificate was made now
        yield client


@pytest.mark.parametrize("path", ["/", "/api/status", "/healthz", "/static/live.js", "/openapi.json", "/none"])
def test_nothing_is_answered_without_the_token(page: ServedPage, browser: httpx.Client, path: str) -> None:
    for headers in (
        {},
        {"Authorization": "Bearer"},
        {"Authorization": f"Bearer {TOKEN}x"},
        {"Cookie": "passafe_token=;"},
    ):
        assert browser.get(page.url + path, headers=headers).status_code == 401
    assert browser.get(f"{page.url}{path}?token=x").status_code == 401
    assert browser.get(f"{page.url}{path}?token={TOKEN}&token={TOKEN}").status_code == 401
    assert browser.put(f"{page.url}/api/stop?token={TOKEN}").status_code == 401  # no control by a link


def test_a_program_shows_it_in_a_header(page: ServedPage, browser: httpx.Client) -> None:
    assert browser.get(page.url + "/api/status", headers={"Authorization": f"Bearer {TOKEN}"}).status_code == 200


def test_a_browser_shows_it_once_and_keeps_a_cookie(page: ServedPage, browser: httpx.Client) -> None:
    answer = browser.get(f"{page.url}/api/links?a=1&token={TOKEN}")
    assert (answer.status_code, answer.headers["location"]) == (303, "/api/links?a=1")
    cookie = answer.headers["set-cookie"]
    assert all(part in cookie for part in (f"passafe_token={TOKEN}", "HttpOnly", "Secure", "SameSite=strict"))
    browser.cookies.clear()
    kept = {"Cookie": f"other=1; passafe_token={TOKEN}"}
    assert browser.get(f"{page.url}/api/links", headers=kept).status_code == 200


@pytest.mark.parametrize("path", ["/live", "/drive"])
def test_a_websocket_needs_it_too(page: ServedPage, path: str) -> None:
    trusting = ssl.create_default_context()
    trusting.check_hostname, trusting.verify_mode = False, ssl.CERT_NONE
    with pytest.raises(InvalidStatus, match="401"), connect(f"wss://{page.host}{path}?token={TOKEN}", ssl=trusting):
        pass
    headers = {"Authorization": f"Bearer {TOKEN}", "Origin": f"https://{page.host}"}
    with connect(f"wss://{page.host}{path}", ssl=trusting, additional_headers=headers) as connection:
        assert connection.recv(timeout=30)
