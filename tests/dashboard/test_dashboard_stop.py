"""The emergency stop over HTTP: pressed, shown, cleared by its name, and never by a page of another site."""

from collections.abc import Iterator
from typing import Any

import pytest
from passafe_protocol.messages import EmergencyStop, Header, OperatorLease, StopClear
from served_page import FastRun, ServedPage, serve_page


@pytest.fixture
def page(run: FastRun) -> Iterator[ServedPage]:
    with serve_page(run, answer_s=1.0) as served:
        yield served


def status(page: ServedPage) -> dict[str, Any]:
    found: dict[str, Any] = page.get("/api/status").json()
    return found


def test_a_press_returns_when_the_plant_has_latched_it(page: ServedPage, run: FastRun) -> None:
    assert status(page)["stop"] == {"id": None, "source": None}

    answer = page.put("/api/stop", None)

    press = run.stop_requests[0]
    assert isinstance(press, EmergencyStop)
    assert answer.status_code == 200
    assert answer.json() == {"id": str(press.id), "source": "dashboard"} == status(page)["stop"]
    assert run.latch.is_latched


def test_a_clear_names_the_stop_that_it_means(page: ServedPage, run: FastRun) -> None:
    first = page.put("/api/stop", None).json()["id"]
    second = page.put("/api/stop", None).json()["id"]

    refused = page.put(f"/api/clear/{first}", None)
    assert refused.status_code == 409
    assert second in refused.json()["detail"]
    assert run.latch.is_latched
    assert page.put(f"/api/clear/{second}", None).json() == {"id": None, "source": None}
    assert not run.latch.is_latched
    again = page.put(f"/api/clear/{second}", None)
    assert (again.status_code, "no stop is latched" in again.json()["detail"]) == (409, True)


def test_a_press_without_a_run_says_so_at_once(page: ServedPage, run: FastRun) -> None:
    run.feed.session = {"state": "stopped", "run": 1, "trouble": "", "processes": {}}

    answer = page.put("/api/stop", None)

    assert (answer.status_code, answer.json()["detail"]) == (409, "No run is going on: there is nothing to stop.")
    assert run.stop_requests == []


@pytest.mark.parametrize("stop", ["0", "-1", str(2**64), "nan", "x"])
def test_a_clear_of_no_number_is_refused(page: ServedPage, stop: str) -> None:
    assert page.put(f"/api/clear/{stop}", None).status_code == 422


def test_a_silent_plant_is_an_error_after_many_repeats(page: ServedPage, run: FastRun) -> None:
    run.links.silent = True

    answer = page.put("/api/stop", None)

    assert answer.status_code == 504
    assert "no answer from plant within 1 s" in answer.json()["detail"]
    assert len(run.stop_requests) > 10
    assert len(set(run.stop_requests)) == 1


def test_a_clear_that_is_not_answered_is_an_error(page: ServedPage, run: FastRun) -> None:
    stop = page.put("/api/stop", None).json()["id"]
    run.links.silent = True

    assert page.put(f"/api/clear/{stop}", None).status_code == 504
    assert isinstance(run.stop_requests[-1], StopClear)
    assert run.latch.is_latched


def test_pages_of_other_sites_neither_stop_nor_clear(page: ServedPage, run: FastRun) -> None:
    stop = page.put("/api/stop", None).json()["id"]
    for path in ("/api/stop", f"/api/clear/{stop}"):
        assert page.put(path, None, Origin="https://example.org").status_code == 403

    assert len({request for request in run.stop_requests if isinstance(request, EmergencyStop)}) == 1
    assert run.latch.is_latched


def test_the_lease_is_part_of_the_state(page: ServedPage, run: FastRun) -> None:
    assert status(page)["lease"] is None
    header = Header("filter", 1, 10**6, 0, 0, 0, 0)
    page.in_loop(run.feed.push, header, OperatorLease(3, 2**63 + 1, "keyboard", 4_500_000, 9), 0)

    assert status(page)["lease"] == {
        "number": 3,
        "holder": str(2**63 + 1),
        "device": "keyboard",
        "heartbeat_ms": 4.5,
        "refused": "9",
    }
    page.in_loop(run.feed.push, Header("filter", 1, 10**6 + 1, 0, 0, 0, 0), OperatorLease(3, 0, "", -1), 0)
    assert status(page)["lease"]["holder"] is None
