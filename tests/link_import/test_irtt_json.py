import gzip
import json
from math import inf
from pathlib import Path
from typing import Any

import pytest
from passafe_services.tools.link_import.errors import MeasurementError
from passafe_services.tools.link_import.irtt_json import Clocks, Direction
from passafe_services.tools.link_import.trace_file import read_measurement

MS = 1_000_000
BEGIN_NS = 1_763_800_000_000_000_000
AHEAD = 5_000
"""The server's clock is 5 s ahead of the client's, ms."""


def trip(k: int, send_ms: float, receive_ms: float, *, lost: str = "false", ahead_ms: float = AHEAD) -> dict[str, Any]:
    """Return a probe sent every 10 ms, as irtt writes it."""
    sent_ns = BEGIN_NS + k * 10 * MS
    one: dict[str, Any] = {
        "seqno": k,
        "lost": lost,
        "timestamps": {"client": {"send": {"wall": sent_ns, "monotonic": k}, "receive": {}}, "server": {}},
    }
    if lost == "false":
        send_ns, receive_ns = round((send_ms + ahead_ms) * MS), round((receive_ms - ahead_ms) * MS)
        one["delay"] = {"send": send_ns, "receive": receive_ns, "rtt": send_ns + receive_ns}
    return one


def written(path: Path, trips: list[dict[str, Any]], **stats: int) -> Path:
    path.write_text(json.dumps({"version": {}, "stats": stats, "round_trips": trips}))
    return path


def delays_ms(path: Path, direction: Direction = Direction.SEND, clocks: Clocks = Clocks.UNKNOWN) -> list[float]:
    return [1e3 * one.delay_s for one in read_measurement(path, direction=direction, clocks=clocks).probes]


def test_an_offset_of_the_clocks_is_taken_out(tmp_path: Path) -> None:
    path = written(tmp_path / "a.json", [trip(0, 20, 20), trip(1, 30, 25), trip(2, 22, 40)])

    assert delays_ms(path) == pytest.approx([20, 30, 22])
    assert delays_ms(path, Direction.RECEIVE) == pytest.approx([20, 25, 40])
    assert "5000.000 ms ahead" in read_measurement(path).assumptions[0]


def test_an_uneven_path_is_taken_for_an_offset_and_said(tmp_path: Path) -> None:
    path = written(tmp_path / "a.json", [trip(0, 30, 10), trip(1, 31, 10)])

    assert delays_ms(path) == pytest.approx([20, 21])
    assert "shortest delays of both directions are then equal" in read_measurement(path).assumptions[0]


def test_synchronized_clocks_are_believed_until_they_contradict(tmp_path: Path) -> None:
    even = written(tmp_path / "even.json", [trip(0, 30, 10, ahead_ms=0), trip(1, 31, 10, ahead_ms=0)])
    apart = written(tmp_path / "apart.json", [trip(0, 30, 10), trip(1, 31, 10)])

    assert delays_ms(even, clocks=Clocks.SYNCHRONIZED) == pytest.approx([30, 31])
    with pytest.raises(MeasurementError, match=r"clocks: got a delay of -4990\.000 ms"):
        delays_ms(apart, clocks=Clocks.SYNCHRONIZED)


def test_a_drift_of_the_clocks_is_said(tmp_path: Path) -> None:
    path = written(tmp_path / "a.json", [trip(k, 20, 20, ahead_ms=AHEAD + 0.1 * k) for k in range(100)])

    [_, drift] = read_measurement(path).assumptions
    assert "change by 7.500 ms" in drift


def test_losses_count_in_their_direction_alone(tmp_path: Path) -> None:
    trips = [trip(0, 20, 20), trip(1, 0, 0, lost="true_up"), trip(2, 0, 0, lost="true_down"), trip(3, 20, 20)]
    trips.append(trip(4, 0, 0, lost="true"))
    path = written(tmp_path / "a.json", trips)
    there, back = (read_measurement(path, direction=one) for one in Direction)

    assert [(one.sent_s, one.delay_s) for one in there.probes if one.delay_s == inf] == [
        (pytest.approx(0.01, abs=1e-6), inf),
        (pytest.approx(0.04, abs=1e-6), inf),
    ]
    assert [one.sent_s for one in back.probes if one.delay_s == inf] == pytest.approx([0.02, 0.04], abs=1e-6)
    assert (there.left_out, back.left_out) == (1, 1)
    assert "1 probes without an answer" in there.assumptions[-1]


def test_reordered_and_doubled_answers_are_counted(tmp_path: Path) -> None:
    path = written(tmp_path / "a.json", [trip(0, 20, 40), trip(1, 20, 20), trip(2, 20, 20)], duplicates=3)

    measured = read_measurement(path)

    assert (measured.reordered, measured.duplicates) == (1, 3)
    assert "duplicates: 3, reordered: 1" in "\n".join(measured.summary())


def test_packed_output_is_read_too(tmp_path: Path) -> None:
    plain = written(tmp_path / "a.json", [trip(0, 20, 20), trip(1, 30, 25)])
    packed = tmp_path / "a.json.gz"
    packed.write_bytes(gzip.compress(plain.read_bytes()))

    assert read_measurement(packed) == read_measurement(plain)


@pytest.mark.parametrize(
    ("content", "named"),
    [
        ("{", "contents"),
        ('{"round_trips": []}', "round_trips"),
        ('{"round_trips": [{"seqno": 1, "lost": "perhaps"}, {}]}', r"round_trips\.0\.lost: got 'perhaps'"),
        (json.dumps({"round_trips": [trip(0, 1, 1), trip(1, 0, 0, lost="true")]}), "1 answers"),
        (json.dumps({"round_trips": [trip(0, 1, 1), trip(1, 90_000, 1)]}), "at most 10 s"),
        (json.dumps({"round_trips": [trip(0, 1, 1), trip(0, 1, 1)]}), "all the same"),
    ],
)
def test_other_files_are_refused(tmp_path: Path, content: str, named: str) -> None:
    path = tmp_path / "a.json"
    path.write_text(content)

    with pytest.raises(MeasurementError, match=named) as caught:
        read_measurement(path)

    assert "\n" not in str(caught.value)


def test_files_that_cannot_be_read_are_refused(tmp_path: Path) -> None:
    torn = tmp_path / "torn.gz"
    torn.write_bytes(gzip.compress(b"{" * 1000)[:-9])
    for path, named in ((tmp_path / "none", "No such file"), (torn, "ended before"), (tmp_path, "regular file")):
        with pytest.raises(MeasurementError, match=named):
            read_measurement(path)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{}", "round_trips: got nothing, allowed a value: this key is required"),
        ('{"round_trips": null}', "round_trips: got None, allowed a list"),
        ('{"round_trips": [', "allowed JSON of irtt"),
    ],
)
def test_what_is_wrong_is_said_in_words(text: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "measured.json"
    path.write_text(text)
    with pytest.raises(MeasurementError) as refused:
        delays_ms(path)

    assert said in str(refused.value)


def test_a_mark_of_byte_order_is_no_part_of_the_text(tmp_path: Path) -> None:
    path = written(tmp_path / "measured.json", [trip(0, 10, 20), trip(1, 12, 20)])
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())

    assert len(delays_ms(path)) == 2
