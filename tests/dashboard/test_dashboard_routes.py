import json
import re
from collections.abc import Iterator
from contextlib import suppress
from itertools import pairwise
from typing import Any

import passafe_dashboard.routes.state
import pytest
from closed_form import header, paper_scenario
from passafe_dashboard.live.feed import Feed
from passafe_dashboard.markup import STATIC
from passafe_dashboard.script_bundle import script_bundle
from passafe_protocol.messages import ScenarioInfo
from served_page import FastRun, ServedPage, client_that_reads_nothing, frames, serve_page
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection


@pytest.fixture(scope="module")
def shared_page() -> Iterator[ServedPage]:
    with serve_page(FastRun(Feed(paper_scenario()))) as served:
        yield served


def last_words(connection: ClientConnection, end: type[Exception], *, timeout_s: float) -> str | bytes:
    """Return the last message before ``end`` was raised."""
    last: str | bytes = ""
    with suppress(end):
        while True:
            last = connection.recv(timeout=timeout_s)
    return last


def assert_nothing_is_missing(received: list[dict[str, Any]]) -> None:
    """Every row begins where the one before ended."""
    rows = [row for frame in received for row in frame["tables"]["ticks"]]
    assert len(rows) > 20
    assert all(row[0] == before[1] for before, row in pairwise(rows))
    assert all(frame["lost"] == 0 for frame in received)


def test_the_page_has_a_place_for_everything_it_shows(shared_page: ServedPage) -> None:
    response = shared_page.get("/")
    assert response.status_code == 200
    for heading in (
        "Status",
        "Distance to limits",
        "Energy",
        "Delays",
        "Driver",
        "Controls",
        "Filter now",
        "Over time",
        "Processes and topics",
        "Events",
        "Links",
    ):
        assert f">{heading}</h2>" in response.text
    assert "The paper&#39;s robot and disk" in response.text


def test_everything_the_page_loads_is_served_here(shared_page: ServedPage) -> None:
    loaded = re.findall(r'(?:src|href)="(/[a-z/_]+\.(?:css|js))"', shared_page.get("/").text)
    assert sorted(loaded) == ["/live.js", "/static/live/drive.css", "/static/live/engineer.css", "/static/page.css"]
    for path in loaded:
        assert shared_page.get(path).status_code == 200, path
    script = shared_page.get("/live.js")
    assert script.headers["content-type"].startswith("text/javascript")
    assert script.text == script_bundle("live/main.js")


def test_the_page_may_load_nothing_from_elsewhere(shared_page: ServedPage) -> None:
    policy = shared_page.get("/").headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "http" not in policy
    assert shared_page.get("/live.js").headers["x-content-type-options"] == "nosniff"


def test_status_is_the_current_state(shared_page: ServedPage) -> None:
    with shared_page.listen() as connection:
        frames(connection, 20)
    status = shared_page.get("/api/status").json()
    assert status["filter"]["tick"] > 0
    assert status["liveness"]["state"] == "live"
    assert {entry["process"] for entry in status["processes"]} >= {"plant", "filter"}


def test_healthz_fails_once_reading_has_failed(page: ServedPage, run: FastRun) -> None:
    response = page.get("/healthz")
    assert response.status_code == 200
    assert response.json()["ok"] is True
    run.fails = True
    with page.listen() as connection:
        last_words(connection, TimeoutError, timeout_s=0.5)
    response = page.get("/healthz")
    assert response.status_code == 503
    assert response.json()["ok"] is False


def test_the_socket_streams_frames(shared_page: ServedPage) -> None:
    with shared_page.listen() as connection:
        received = frames(connection, 30)
    assert received[0]["restart"]
    assert not any(frame["restart"] for frame in received[1:])
    ticks = [frame["now"]["filter"]["tick"] for frame in received if frame["now"]["filter"]]
    assert ticks == sorted(ticks)
    assert ticks[-1] > ticks[0]
    assert_nothing_is_missing(received)


def test_several_clients_are_served_at_once(page: ServedPage) -> None:
    with page.listen() as one, page.listen() as other:
        assert frames(one, 1)[0]["restart"]
        assert frames(other, 1)[0]["restart"]
        assert page.get("/healthz").json()["pages"] == 2


def test_client_that_reads_nothing_delays_nobody(page: ServedPage, run: FastRun) -> None:
    with client_that_reads_nothing(page) as slow, page.listen() as quick:
        received = frames(quick, 300)
        assert page.get("/healthz").json()["pages"] == 2
        page.in_loop(run.broadcast.finish, "over")
        got = bytearray()
        while b'"state":"ended"' not in got:
            got += slow.recv(65_536)
    assert got.count(b'"restart":') < 100  # the others were never made
    assert_nothing_is_missing(received)
    assert run.feed.run.ticks.since(0).rows[-1].number > 300


def test_end_of_the_run_is_sent_and_closes_the_socket(page: ServedPage, run: FastRun) -> None:
    with page.listen() as connection:
        frames(connection, 1)
        page.in_loop(run.broadcast.finish, "The run has ended.")
        last = last_words(connection, ConnectionClosed, timeout_s=30)
        assert json.loads(last)["now"]["liveness"] == {"state": "ended", "text": "The run has ended."}
        assert connection.close_code == 1000


@pytest.mark.parametrize("origin", ["http://elsewhere.test", "http://127.0.0.1:1", "null"])
def test_pages_of_other_sites_are_refused(shared_page: ServedPage, origin: str) -> None:
    with pytest.raises(InvalidStatus) as refused:
        shared_page.listen(origin=origin)
    assert refused.value.response.status_code == 403


def test_the_page_s_own_origin_is_let_in(shared_page: ServedPage) -> None:
    with shared_page.listen(origin=shared_page.url) as connection:
        assert frames(connection, 1)


def test_page_beyond_the_limit_is_asked_to_try_later(page: ServedPage, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(passafe_dashboard.routes.state, "MAX_CLIENTS", 1)
    with page.listen() as first:
        frames(first, 1)
        with page.listen() as second:
            with pytest.raises(ConnectionClosed) as refused:
                second.recv(timeout=30)
            assert refused.value.rcvd is not None
            assert refused.value.rcvd.code == 1013


def test_messages_of_a_page_are_ignored(shared_page: ServedPage) -> None:
    with shared_page.listen() as connection:
        connection.send("x" * 1000)
        connection.send(b"\0\xff")
        assert frames(connection, 10)[0]["restart"]


def test_departed_client_is_no_longer_counted(page: ServedPage) -> None:
    with page.listen() as other:
        with page.listen() as connection:
            frames(connection, 1)
        for _ in frames(other, 200):
            if page.get("/healthz").json()["pages"] == 1:
                break
        assert page.get("/healthz").json()["pages"] == 1


def test_a_new_scenario_changes_the_page(page: ServedPage, run: FastRun) -> None:
    values = paper_scenario().model_dump()
    values["title"] = "Another <robot>"
    values["filter"]["barriers"] = ()
    before = page.get("/").text
    page.in_loop(run.feed.push, header("filter", 1), ScenarioInfo(json.dumps(values), "live", "{}"), 0)
    after = page.get("/").text
    assert "Barriers h" in before
    assert "Another &lt;robot&gt;" in after
    assert "Barriers h" not in after
    assert run.feed.scenario_id in after
    with page.listen() as connection:
        assert frames(connection, 1)[0]["layout"] == run.feed.scenario_id


def test_page_without_scenario_waits_for_one() -> None:
    run = FastRun(Feed(), speed=0.0)
    with serve_page(run) as page:
        text = page.get("/").text
        assert "No scenario is known yet" in text


def test_no_script_or_style_refers_to_another_host() -> None:
    for file in STATIC.rglob("*"):
        if file.suffix in (".js", ".css"):
            assert not re.search(r"https?://(?!www\.w3\.org/)", file.read_text("utf-8")), file.name
