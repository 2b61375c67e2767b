"""Runs of a demo, asked for on the page: the dashboard's end of the control channel, and the routes."""

import asyncio
import socket
from collections.abc import Awaitable, Callable
from typing import Any

import passafe_dashboard.live.session_requests
import pytest
from fastapi import FastAPI
from fastapi.exceptions import RequestValidationError
from httpx import ASGITransport, AsyncClient, Response
from passafe_dashboard.errors import NoSessionError, SessionAnswerError, SessionRefusedError
from passafe_dashboard.live.feed import Feed
from passafe_dashboard.live.page_state import page_state
from passafe_dashboard.live.session_requests import SessionRequests
from passafe_dashboard.routes.refusals import answer_invalid
from passafe_dashboard.routes.run import run_routes
from passafe_services.session.control_channel import ControlChannel
from passafe_services.session.control_messages import (
    FROM_PAGE,
    EndRun,
    NumberedRequest,
    PageRequest,
    Refusal,
    RequestAnswer,
    SessionState,
)

STATE = SessionState(
    state="running",
    run=3,
    scenario="moving-disk",
    mode="both",
    prediction=True,
    gatekeeper=False,
    rate_hz=500.0,
    recording=True,
    log="moving-disk.mcap",
    can=("run",),
    scenarios=("moving-disk",),
    processes={},
    last=None,
    trouble="",
)

Supervisor = ControlChannel[NumberedRequest]


def beside_supervisor(
    test: Callable[[SessionRequests, Feed, Supervisor], Awaitable[None]], *, answer_s: float = 20.0
) -> Feed:
    """Run a test with the dashboard's end of a channel, open, and the supervisor's; return the feed."""
    feed = Feed()

    async def run() -> None:
        one, other = socket.socketpair()
        supervisor = await Supervisor.over(one, FROM_PAGE)
        requests = SessionRequests(feed, other.detach(), answer_s=answer_s)
        open_channel = asyncio.create_task(requests.run())
        supervisor.send(STATE)
        while feed.session is None:  # noqa: ASYNC110 - what is tested sets no event
            await asyncio.sleep(0)
        await test(requests, feed, supervisor)
        supervisor.close()
        await open_channel

    asyncio.run(run())
    return feed


def test_state_is_on_the_page_until_the_supervisor_ends() -> None:
    async def test(_requests: SessionRequests, feed: Feed, _supervisor: Supervisor) -> None:
        session = page_state(feed, 0)["session"]
        assert (session["state"], session["run"], session["log"]) == ("running", 3, "moving-disk.mcap")
        assert "type" not in session

    assert beside_supervisor(test).session is None


def test_answers_find_their_requests_in_any_order() -> None:
    async def test(requests: SessionRequests, _feed: Feed, supervisor: Supervisor) -> None:
        asked = [asyncio.create_task(requests.ask(EndRun())) for _ in range(3)]
        numbers = [message.number for _ in asked if (message := await supervisor.receive())]
        refused = numbers[1]
        for number in reversed(numbers):
            refusal = Refusal(field="", reason="not now") if number == refused else None
            supervisor.send(RequestAnswer(number=number, run=number, refusal=refusal))
        supervisor.send(RequestAnswer(number=999, run=0))  # nobody waits for it
        assert await asked[0] == numbers[0]
        with pytest.raises(SessionRefusedError, match="not now"):
            await asked[1]
        assert await asked[2] == numbers[2]

    beside_supervisor(test)


def test_silent_supervisor_is_reported() -> None:
    async def test(requests: SessionRequests, _feed: Feed, _supervisor: Supervisor) -> None:
        with pytest.raises(SessionAnswerError, match=r"no answer from the demo's supervisor within 0\.01 s"):
            await requests.ask(EndRun())

    beside_supervisor(test, answer_s=0.01)


def test_number_of_waiting_requests_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(passafe_dashboard.live.session_requests, "MOST_WAITING", 2)

    async def test(requests: SessionRequests, _feed: Feed, supervisor: Supervisor) -> None:
        waiting = [asyncio.create_task(requests.ask(EndRun())) for _ in range(2)]
        numbers = [message.number for _ in waiting if (message := await supervisor.receive())]
        with pytest.raises(SessionRefusedError, match="2 requests are waiting"):
            await requests.ask(EndRun())
        for number in numbers:
            supervisor.send(RequestAnswer(number=number, run=1))
        assert await asyncio.gather(*waiting) == [1, 1]

    beside_supervisor(test)


def test_supervisor_that_ends_leaves_nobody_waiting() -> None:
    async def test(requests: SessionRequests, _feed: Feed, supervisor: Supervisor) -> None:
        asked = asyncio.create_task(requests.ask(EndRun()))
        await supervisor.receive()
        supervisor.close()
        with pytest.raises(NoSessionError):
            await asked
        with pytest.raises(NoSessionError):
            await requests.ask(EndRun())

    beside_supervisor(test)


class Answering(SessionRequests):
    """Requests that are answered at once."""

    def __init__(self, feed: Feed) -> None:
        super().__init__(feed)
        self.asked: list[PageRequest] = []
        self.error: Exception | None = None

    async def ask(self, request: PageRequest) -> int:
        """Note a request, and refuse it on demand."""
        self.asked.append(request)
        if self.error is not None:
            raise self.error
        return 4


@pytest.fixture
def answering() -> Answering:
    return Answering(Feed())


class Client:
    """Asks the routes."""

    def __init__(self, session: Answering) -> None:
        self._app = FastAPI()
        self._app.include_router(run_routes(session, session._feed))
        self._app.add_exception_handler(RequestValidationError, answer_invalid)

    def request(self, method: str, path: str, body: dict[str, Any] | None = None) -> Response:
        """Return the answer to a request."""

        async def ask() -> Response:
            async with AsyncClient(transport=ASGITransport(self._app), base_url="http://page") as client:
                return await client.request(method, path, json=body)

        return asyncio.run(ask())


@pytest.fixture
def client(answering: Answering) -> Client:
    return Client(answering)


def test_routes_ask_for_what_they_name(client: Client, answering: Answering) -> None:
    run = {"scenario": "moving-disk", "mode": "safe", "prediction": False, "rate_hz": 250.0, "recording": False}
    answers = [
        client.request("POST", "/api/run", run),
        client.request("DELETE", "/api/run"),
        client.request("POST", "/api/processes/filter/kill"),
        client.request("POST", "/api/processes/plant/restart"),
    ]

    assert [(answer.status_code, answer.json()) for answer in answers] == [(202, {"run": 4})] * 4
    assert [one.type for one in answering.asked] == ["start", "end", "kill", "restart"]
    assert answering.asked[0].model_dump()["choices"] == run | {"gatekeeper": None}


def test_state_of_the_session_is_served(client: Client, answering: Answering) -> None:
    assert client.request("GET", "/api/run").json() is None

    answering._feed.session = STATE.json_dict()
    assert client.request("GET", "/api/run").json()["scenario"] == "moving-disk"


@pytest.mark.parametrize(
    ("error", "status", "text"),
    [
        (NoSessionError(), 409, "`passafe demo` alone"),
        (SessionRefusedError("", "a run is stopping"), 409, "a run is stopping"),
        (SessionRefusedError("rate_hz", "rate_hz: got 13, allowed above 100"), 422, "got 13, allowed above 100"),
        (SessionAnswerError(20.0), 504, "within 20 s"),
    ],
)
def test_refusals_have_a_status_and_a_reason(
    error: Exception, status: int, text: str, client: Client, answering: Answering
) -> None:
    answering.error = error

    answer = client.request("POST", "/api/run", {"scenario": "moving-disk"})
    assert (answer.status_code, text in answer.text) == (status, True)


@pytest.mark.parametrize(
    "body",
    [
        {},
        {"scenario": ""},
        {"scenario": "a" * 5000},
        {"scenario": "a", "mode": "wild"},
        {"scenario": "a", "rate_hz": 1e9},
        {"scenario": "a", "rate_hz": "fast"},
        {"scenario": "a", "recording": None},
        {"scenario": "a", "file": "/etc/passwd"},
    ],
)
def test_body_of_another_form_never_reaches_the_supervisor(
    body: dict[str, Any], client: Client, answering: Answering
) -> None:
    assert client.request("POST", "/api/run", body).status_code == 422
    assert answering.asked == []


@pytest.mark.parametrize(
    ("method", "path"),
    [("GET", "/api/processes/filter/kill"), ("GET", "/api/processes/filter/restart"), ("PUT", "/api/run")],
)
def test_nothing_is_controlled_by_another_method(method: str, path: str, client: Client, answering: Answering) -> None:
    assert client.request(method, path).status_code == 405
    assert answering.asked == []


def test_process_that_does_not_exist_is_refused(client: Client) -> None:
    answer = client.request("POST", "/api/processes/init/kill")

    assert answer.status_code == 422
    assert "'recorder'" in answer.text
