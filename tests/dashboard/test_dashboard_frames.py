import json
from typing import Any

import pytest
from closed_form import MS, ClosedFormRun, h, header, paper_scenario, state, tick
from passafe_dashboard.columns import ColumnLayout, drawn_columns
from passafe_dashboard.live.feed import Feed
from passafe_dashboard.live.frames import KEPT, ClientFrames, Made

LAYOUT = ColumnLayout.of(paper_scenario())
TICK_COLUMNS = drawn_columns(tuple(LAYOUT.tick_columns))


def fill(feed: Feed, run: ClosedFormRun, until_ms: int) -> None:
    for message in run.until(until_ms * MS):
        feed.push(*message)


def frame(client: ClientFrames) -> dict[str, Any]:
    read: dict[str, Any] = json.loads(client.next_frame('{"a": 1}'))
    return read


def test_first_frame_has_the_history_and_the_next_the_new_rows() -> None:
    feed, run = Feed(paper_scenario()), ClosedFormRun()
    fill(feed, run, 1_000)
    client = ClientFrames(feed)
    first = frame(client)
    assert first["restart"]
    assert first["now"] == {"a": 1}
    assert first["layout"] == feed.scenario_id
    assert len(first["tables"]["ticks"]) == 29
    fill(feed, run, 1_100)
    second = frame(client)
    assert not second["restart"]
    assert len(second["tables"]["ticks"]) == len(second["tables"]["states"]) == 3
    assert frame(client)["tables"] == {"ticks": [], "states": []}


def test_rows_list_the_drawn_columns_in_order() -> None:
    feed, run = Feed(paper_scenario()), ClosedFormRun()
    fill(feed, run, 100)
    row = dict(zip(TICK_COLUMNS, frame(ClientFrames(feed))["tables"]["ticks"][0], strict=True))
    assert row["time_s"] - row["start_s"] == pytest.approx(1 / 30, rel=1e-6)
    assert row["psi_0_0"] == pytest.approx(h(0.033))


def test_an_interruption_is_null_but_for_the_time() -> None:
    feed = Feed(paper_scenario())
    for number, k in enumerate((0, 1, 2_000, 2_100)):
        feed.push(header("filter", number), tick(k), 0)
    row = dict(zip(TICK_COLUMNS, frame(ClientFrames(feed))["tables"]["ticks"][1], strict=True))
    assert row.pop("start_s") == pytest.approx(1 / 30)
    assert row.pop("time_s") == pytest.approx(2.0, abs=1 / 30)
    assert set(row.values()) == {None}


def test_late_client_receives_the_count_of_lost_rows() -> None:
    feed, run = Feed(paper_scenario(), history_s=1.0), ClosedFormRun()
    fill(feed, run, 500)
    client = ClientFrames(feed)
    frame(client)
    fill(feed, run, 3_500)
    late = frame(client)
    assert late["lost"] == 60
    assert len(late["tables"]["ticks"]) == 30


def test_a_new_run_starts_the_charts_over() -> None:
    feed, run = Feed(paper_scenario()), ClosedFormRun()
    fill(feed, run, 500)
    client = ClientFrames(feed)
    frame(client)
    feed.push(header("plant", 0, epoch=9), state(0), 2000 * MS)
    assert frame(client)["restart"]
    assert not frame(client)["restart"]


def test_a_client_knows_whether_it_has_seen_the_end() -> None:
    feed = Feed(paper_scenario())
    client = ClientFrames(feed)
    frame(client)
    assert not client.has_sent_end
    feed.finish("over")
    frame(client)
    assert client.has_sent_end


def test_clients_that_keep_up_share_one_text() -> None:
    feed, run = Feed(paper_scenario()), ClosedFormRun()
    fill(feed, run, 500)
    early, late = [ClientFrames(feed) for _ in range(3)], ClientFrames(feed)
    for until_ms in (500, 1_000):
        fill(feed, run, until_ms)
        made: Made = {}
        texts = [client.next_frame('{"a": 1}', made) for client in early]
        assert texts[0] is texts[1] is texts[2]
    own = late.next_frame('{"a": 1}', made)
    assert own not in texts
    assert own == ClientFrames(feed).next_frame('{"a": 1}')


def test_few_texts_are_kept() -> None:
    feed, run = Feed(paper_scenario()), ClosedFormRun()
    clients = [ClientFrames(feed) for _ in range(9)]
    for k, client in enumerate(clients):
        fill(feed, run, 100 * (k + 1))
        client.next_frame("{}")
    made: Made = {}
    for client in clients:
        client.next_frame("{}", made)
    assert len(made) == KEPT
