"""Links over HTTP: looked at, changed, and answered with what is in force."""

from collections.abc import Iterator
from threading import Event, Thread
from typing import Any

import httpx
import pytest
from closed_form import paper_scenario
from msgspec.structs import asdict
from passafe_dashboard.live.feed import Feed
from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.link_wire import parameters_of
from passafe_protocol.topics import LINKS
from served_page import FastRun, ServedPage, serve_page

LINK = "plant-to-filter"


@pytest.fixture
def page(run: FastRun) -> Iterator[ServedPage]:
    with serve_page(run, answer_s=1.0) as served:
        yield served


def of_link(page: ServedPage, name: str) -> dict[str, Any]:
    (found,) = [link for link in page.get("/api/links").json()["links"] if link["link"] == name]
    return found


def test_every_link_is_shown_with_settings_and_counts(page: ServedPage) -> None:
    links = page.get("/api/links").json()["links"]

    assert [link["link"] for link in links] == list(LINKS)
    assert {link["link"]: link["reader"] for link in links} == {name: place.reader for name, place in LINKS.items()}
    assert links[0]["counts"]["entered"] == 0
    assert links[0]["settings"]["delay_s"] == 0.0
    assert page.get("/api/status").json()["link_states"][0]["link"] == "operator-to-filter"


def test_change_returns_settings_in_force_and_keeps_the_rest(page: ServedPage, run: FastRun) -> None:
    first = page.put(f"/api/links/{LINK}", {"delay_s": 0.2, "loss": 0.1})
    second = page.put(f"/api/links/{LINK}", {"jitter_s": 0.02, "outages_s": [[1, 2]]})

    assert first.status_code == second.status_code == 200
    assert first.json()["settings"]["delay_s"] == 0.2
    settings = second.json()["settings"]
    assert (settings["delay_s"], settings["jitter_s"], settings["loss"]) == (0.2, 0.02, 0.1)
    assert settings["outages"] == [[1, 2]]
    assert run.links.links[LINK].settings == LinkSettings(delay_s=0.2, jitter_s=0.02, loss=0.1, outages_s=((1.0, 2.0),))
    assert of_link(page, LINK)["settings"] == settings
    assert of_link(page, "filter-to-plant")["settings"]["delay_s"] == 0.0


def test_everything_but_a_trace_can_be_set(page: ServedPage, run: FastRun) -> None:
    wanted = LinkSettings(distribution="histogram", quantiles_s=(0.0, 0.1), correlation=0.5, rate_hz=100.0, queue=3)
    body = asdict(parameters_of(wanted))
    body["outages_s"] = body.pop("outages")

    assert page.put(f"/api/links/{LINK}", body).status_code == 200
    assert run.links.links[LINK].settings == wanted
    assert page.put(f"/api/links/{LINK}", {"trace": "trace.csv"}).status_code == 422


@pytest.mark.parametrize(
    ("body", "named"),
    [
        ({"delay_s": -1}, "delay_s"),
        ({"loss": 1.5}, "loss"),
        ({"jitter_s": "much"}, "jitter_s"),
        ({"delay": 0.1}, "delay"),
        ({"distribution": "gamma"}, "distribution"),
        ({"distribution": "histogram"}, "quantiles_s"),
        ([], "body"),
    ],
)
def test_invalid_settings_are_refused_by_name(page: ServedPage, run: FastRun, body: object, named: str) -> None:
    refused = page.put(f"/api/links/{LINK}", body)

    assert refused.status_code == 422
    (detail,) = refused.json()["detail"]
    assert named in [*detail["loc"], *detail["msg"].replace(":", " ").split()]
    assert run.links.requests == []


def test_refusal_by_the_reader_is_answered_with_its_reason(page: ServedPage, run: FastRun) -> None:
    run.links.links[LINK].reconfigure(LinkSettings(trace_s=(0.1, 0.2)))  # which the dashboard cannot know of yet
    refused = page.put(f"/api/links/{LINK}", {"rate_hz": 10})

    assert refused.status_code == 422
    assert "0 if there is a trace" in refused.json()["detail"][0]["msg"]


def test_a_link_that_does_not_exist_is_not_found(page: ServedPage) -> None:
    missing = page.put("/api/links/plant-to-moon", {"delay_s": 0.1})

    assert missing.status_code == 404
    assert "operator-to-filter, " in missing.json()["detail"]


def test_missing_answer_is_reported_in_time(page: ServedPage, run: FastRun) -> None:
    run.links.silent = True
    silent = page.put(f"/api/links/{LINK}", {"delay_s": 0.1})

    assert silent.status_code == 504
    assert silent.json()["detail"] == f"link {LINK}: no answer within 1 s: is filter running?"
    assert len(run.links.requests) == 1


def test_link_without_a_state_is_refused() -> None:
    run = FastRun(Feed(paper_scenario()))
    run.links.publish_states = lambda *_: None  # type: ignore[method-assign]  # nobody publishes
    with serve_page(run) as page:
        unheard = page.put(f"/api/links/{LINK}", {"delay_s": 0.1})
        assert of_link(page, LINK)["settings"] is None

    assert unheard.status_code == 504
    assert "its state was not received yet" in unheard.json()["detail"]


@pytest.mark.parametrize("origin", ["http://elsewhere.test", "null"])
def test_page_of_another_site_may_change_nothing(page: ServedPage, run: FastRun, origin: str) -> None:
    assert page.put(f"/api/links/{LINK}", {"delay_s": 0.1}, origin=origin).status_code == 403
    assert run.links.requests == []
    assert page.put(f"/api/links/{LINK}", {"delay_s": 0.1}, origin=page.url).status_code == 200


def test_requests_do_not_block_each_other(page: ServedPage, run: FastRun) -> None:
    run.links.silent = True
    began, answers = Event(), []

    def ask(name: str, delay_s: float) -> None:
        began.set()
        answers.append(httpx.put(f"{page.url}/api/links/{name}", json={"delay_s": delay_s}, timeout=30, verify=False))  # noqa: S501 - no TLS here

    threads = [Thread(target=ask, args=(name, 0.1)) for name in LINKS]
    for thread in threads:
        thread.start()
    began.wait(30)
    assert page.get("/api/links").status_code == 200
    for thread in threads:
        thread.join(30)
    assert [answer.status_code for answer in answers] == [504] * len(LINKS)
