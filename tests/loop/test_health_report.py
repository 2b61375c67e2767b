"""The loop of a process reports its own health, to a file and to a service manager."""

import socket
from pathlib import Path
from time import monotonic_ns

import pytest
from passafe_services.loop.health_report import HealthReport, HealthReporter
from passafe_services.loop.readiness import announce_ready
from passafe_services.loop.service_manager import SOCKET_VARIABLE

S = 10**9


def report(**changes: int | bool) -> HealthReport:
    fields = {"monotonic_ns": 0, "connected": True, "executed": 100, "skipped": 0} | changes
    return HealthReport(**fields)  # type: ignore[arg-type]  # each field has one of the two types


@pytest.mark.parametrize(
    ("given", "now_ns", "trouble"),
    [
        (report(), 3 * S, ""),
        (report(), 3 * S + 10**8, "its loop has not reported for 3.1 s"),
        (report(connected=False), S, "no router is connected"),
        (report(executed=50, skipped=50), S, ""),
        (report(executed=49, skipped=51), S, "its loop skipped 51 of 100 steps"),
        (report(executed=0, skipped=0), S, ""),
    ],
)
def test_trouble_is_silence_disconnection_or_skips(given: HealthReport, now_ns: int, trouble: str) -> None:
    assert given.trouble(now_ns) == trouble


def test_reports_count_steps_since_the_last_one(tmp_path: Path) -> None:
    reporter = HealthReporter("plant", tmp_path)
    before_ns = monotonic_ns()

    reporter.report(connected=False, steps=10, skipped=4)
    first = HealthReport.read(tmp_path, "plant")
    reporter.report(connected=True, steps=25, skipped=5)
    second = HealthReport.read(tmp_path, "plant")

    assert first is not None
    assert second is not None
    assert (first.connected, first.executed, first.skipped) == (False, 10, 4)
    assert (second.connected, second.executed, second.skipped) == (True, 15, 1)
    assert before_ns <= first.monotonic_ns <= second.monotonic_ns <= monotonic_ns()


@pytest.mark.parametrize("text", ["", "{", "[]", '{"connected": true}', "\ud800"])
def test_unreadable_report_counts_as_none(tmp_path: Path, text: str) -> None:
    (tmp_path / "filter.json").write_bytes(text.encode(errors="surrogatepass"))

    assert HealthReport.read(tmp_path, "filter") is None
    assert HealthReport.read(tmp_path, "plant") is None


def test_loop_survives_a_folder_that_is_gone(tmp_path: Path) -> None:
    reporter = HealthReporter("filter", tmp_path / "gone")

    reporter.report(connected=True, steps=1, skipped=0)

    assert HealthReport.read(tmp_path / "gone", "filter") is None


@pytest.mark.parametrize("abstract", [False, True])
def test_service_manager_learns_of_loop_and_start(
    abstract: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    address = f"\0{tmp_path}" if abstract else str(tmp_path / "notify")
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
        manager.settimeout(5.0)
        manager.bind(address)
        monkeypatch.setenv(SOCKET_VARIABLE, address.replace("\0", "@"))

        announce_ready("filter")
        HealthReporter("filter", None).report(connected=True, steps=7, skipped=2)

        assert manager.recv(100) == b"READY=1"
        assert manager.recv(100) == b"WATCHDOG=1\nSTATUS=7 steps, 2 skipped, connected"


def test_service_manager_that_is_gone_disturbs_nobody(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(SOCKET_VARIABLE, str(tmp_path / "gone"))

    HealthReporter("filter", None).report(connected=True, steps=7, skipped=2)


def test_reports_are_wanted_by_a_folder_or_a_manager(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(SOCKET_VARIABLE, raising=False)
    assert not HealthReporter("router", None).wanted
    assert HealthReporter("router", tmp_path).wanted
    monkeypatch.setenv(SOCKET_VARIABLE, "/nowhere")
    assert HealthReporter("router", None).wanted
