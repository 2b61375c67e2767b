from math import inf
from pathlib import Path

import pytest
from passafe_services.cli.app import app
from passafe_services.scenarios.link_trace import read_trace
from passafe_services.tools.link_import.errors import MeasurementError
from passafe_services.tools.link_import.trace_file import read_measurement, write_trace
from typer.testing import CliRunner

STAMPED = """PING h (192.0.2.1) 56(84) bytes of data.
[100.040000] 64 bytes from 192.0.2.1: icmp_seq=1 ttl=64 time=40.0 ms
[100.260000] 64 bytes from 192.0.2.1: icmp_seq=2 ttl=64 time=60.0 ms
[100.600000] no answer yet for icmp_seq=3
[100.650000] 64 bytes from 192.0.2.1: icmp_seq=4 ttl=64 time=50.0 ms

--- h ping statistics ---
4 packets transmitted, 3 received, 25% packet loss, time 600ms
rtt min/avg/max/mdev = 40.0/50.0/60.0/10.0 ms
"""
PLAIN = """PING h (192.0.2.1) 56(84) bytes of data.
64 bytes from 192.0.2.1: icmp_seq=1 ttl=64 time=40.0 ms
64 bytes from 192.0.2.1: icmp_seq=3 ttl=64 time=20.0 ms
64 bytes from 192.0.2.1: icmp_seq=2 ttl=64 time=260 ms
64 bytes from 192.0.2.1: icmp_seq=3 ttl=64 time=21.0 ms (DUP!)
From 192.0.2.9 icmp_seq=4 Destination Host Unreachable
64 bytes from 192.0.2.1: icmp_seq=5 ttl=64 time=20.0 ms

--- h ping statistics ---
5 packets transmitted, 4 received, +1 duplicates, 20% packet loss, time 800ms
"""
MACOS = """PING h (192.0.2.1): 56 data bytes
64 bytes from 192.0.2.1: icmp_seq=0 ttl=117 time=14.250 ms
Request timeout for icmp_seq 1
64 bytes from 192.0.2.1: icmp_seq=2 ttl=117 time=15.750 ms
"""
WINDOWS = """Pinging h [192.0.2.1] with 32 bytes of data:
Reply from 192.0.2.1: bytes=32 time=14ms TTL=117
Request timed out.
Reply from 192.0.2.9: Destination host unreachable.
Reply from 192.0.2.1: bytes=32 time<1ms TTL=117
"""


def probes(tmp_path: Path, text: str, interval_s: float | None = None) -> list[tuple[float, float]]:
    path = tmp_path / "ping.txt"
    path.write_text(text)
    found = read_measurement(path, interval_s=interval_s).probes
    return [(pytest.approx(one.sent_s, abs=1e-9), pytest.approx(one.delay_s)) for one in found]


def test_times_of_day_are_those_of_answers(tmp_path: Path) -> None:
    assert probes(tmp_path, STAMPED) == [(0.0, 0.02), (0.2, 0.03), (0.4, inf), (0.6, 0.025)]


def test_without_times_the_total_gives_the_interval(tmp_path: Path) -> None:
    assert probes(tmp_path, PLAIN) == [(0.0, 0.02), (0.2, 0.13), (0.4, 0.01), (0.6, inf), (0.8, 0.01)]


def test_an_interval_that_is_given_counts(tmp_path: Path) -> None:
    assert [sent_s for sent_s, _ in probes(tmp_path, PLAIN, 0.5)] == [0.0, 0.5, 1.0, 1.5, 2.0]


def test_macos_and_windows_are_read_once_a_second(tmp_path: Path) -> None:
    assert probes(tmp_path, MACOS) == [(0.0, 0.007125), (1.0, inf), (2.0, 0.007875)]
    assert probes(tmp_path, WINDOWS) == [(0.0, 0.007), (1.0, inf), (2.0, inf), (3.0, 0.0005)]


def test_what_was_assumed_and_counted_is_said(tmp_path: Path) -> None:
    path = tmp_path / "ping.txt"
    path.write_text(PLAIN)

    measured = read_measurement(path)

    assert (measured.duplicates, measured.reordered) == (1, 1)
    text = "\n".join(measured.summary())
    assert "5 probes in 0.800 s, one every 200 ms" in text
    assert "lost: 1 (20.00 %), longest run 1" in text
    assert "half of the round trip" in text
    assert "lost in this direction, not on the way back" in text


def test_numbers_that_wrap_go_on(tmp_path: Path) -> None:
    lines = [f"64 bytes from h: icmp_seq={k % 65536} ttl=64 time=2 ms" for k in range(65_530, 65_545)]

    assert len(probes(tmp_path, "\n".join(lines))) == 15


def test_nothing_but_losses_is_a_measurement(tmp_path: Path) -> None:
    lines = [f"no answer yet for icmp_seq={k}" for k in (1, 2, 3)]

    assert [delay_s for _, delay_s in probes(tmp_path, "\n".join(lines))] == [inf, inf, inf]


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("", "0 probes"),
        ("64 bytes from h: icmp_seq=1 ttl=64 time=2 ms", "1 probes"),
        ("64 bytes from h: icmp_seq=1 ttl=64 time=soon ms", "line 1: got '64 bytes"),
    ],
)
def test_other_files_are_refused(tmp_path: Path, text: str, named: str) -> None:
    with pytest.raises(MeasurementError, match=named):
        probes(tmp_path, text)


def test_a_trace_that_is_written_is_read_by_links(tmp_path: Path) -> None:
    (tmp_path / "ping.txt").write_text(STAMPED)
    words = ["link", "import", str(tmp_path / "ping.txt"), "--out", str(tmp_path / "trace.csv")]

    result = CliRunner().invoke(app, words)

    assert result.exit_code == 0, result.output
    assert "4 probes" in result.output
    trace = read_trace(tmp_path / "trace.csv").delay_trace_s
    assert [delay_s for _, delay_s in trace] == pytest.approx([0.02, 0.03, inf, 0.025])


def test_a_trace_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    (tmp_path / "ping.txt").write_text(STAMPED)

    with pytest.raises(MeasurementError, match="can be written"):
        write_trace(tmp_path / "none" / "trace.csv", read_measurement(tmp_path / "ping.txt"))
