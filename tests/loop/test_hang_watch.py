"""A call that does not return is noticed; many that do are not."""

import threading
from collections.abc import Callable
from itertools import count

import pytest
from passafe_services.loop import hang_watch as watch
from passafe_services.loop.hang_watch import hang_watch

PATIENCE_S = 20.0


@pytest.fixture(autouse=True)
def fast(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(watch, "LOOK_S", 1e-4)


def test_one_call_that_lasts_is_reported_once() -> None:
    hung, found = threading.Event(), []

    def on_hang(call: str) -> None:
        found.append(call)
        hung.set()

    with hang_watch(lambda: (7, "rail: read"), on_hang):
        assert hung.wait(PATIENCE_S)

    assert found == ["rail: read"]


@pytest.mark.parametrize("kind", ["another call at each look", "between calls"])
def test_calls_that_return_are_no_hang(kind: str) -> None:
    looks, enough, found = count(), threading.Event(), []

    def current() -> tuple[int, str] | None:
        number = next(looks)
        if number > 3 * watch.PATIENCE_LOOKS:
            enough.set()
        return None if kind == "between calls" else (number, "rail: read")

    with hang_watch(current, found.append):
        assert enough.wait(PATIENCE_S)

    assert found == []


def test_without_calls_there_is_no_thread() -> None:
    with hang_watch(None, print):
        assert "hang-watch" not in [thread.name for thread in threading.enumerate()]


def test_slow_call_has_no_real_time_priority(monkeypatch: pytest.MonkeyPatch) -> None:
    changes: list[str] = []
    restored, call = threading.Event(), [(1, "rail: read")]

    def restore() -> None:
        changes.append("restored")
        restored.set()

    def suspend(thread: threading.Thread) -> Callable[[], None]:
        changes.append(thread.name)
        call[0] = (2, "rail: read")
        return restore

    monkeypatch.setattr(watch, "suspend_realtime", suspend)
    monkeypatch.setattr(watch, "PATIENCE_LOOKS", 1_000_000)
    with hang_watch(lambda: call[0], print) as slow:
        assert restored.wait(PATIENCE_S)
        assert slow[0] == "rail: read"

    assert changes[:2] == ["MainThread", "restored"]
