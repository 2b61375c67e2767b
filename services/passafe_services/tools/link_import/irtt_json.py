"""Reads the JSON output of irtt: delays in each direction, as far as two clocks can tell them."""

from enum import StrEnum
from itertools import pairwise
from pathlib import Path
from typing import Final, Literal, NamedTuple

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from passafe_services.scenarios.field_problems import problems_of
from passafe_services.tools.link_import.errors import MeasurementError
from passafe_services.tools.link_import.probes import LOST, Measurement, Probe, from_begin


class Direction(StrEnum):
    """Direction of a probe: from client to server, or back."""

    SEND = "send"
    RECEIVE = "receive"


class Clocks(StrEnum):
    """Knowledge of whether the clocks of both ends agree."""

    UNKNOWN = "unknown"
    SYNCHRONIZED = "synchronized"


_S: Final = 1e-9
LEAST_PROBES: Final = 2
DRIFT_S: Final = 1e-3
"""Change of the clocks' offset over a measurement from which on it is reported."""


class _Foreign(BaseModel):
    """Part of a file of another program, of which what is not needed is passed over."""

    model_config = ConfigDict(extra="ignore", frozen=True)


class _Clock(_Foreign):
    wall: int = 0
    monotonic: int = 0


class _Stamps(_Foreign):
    send: _Clock = _Clock()
    receive: _Clock = _Clock()


class _Timestamps(_Foreign):
    client: _Stamps
    server: _Stamps = _Stamps()


class _Delays(_Foreign):
    send: int | None = None
    receive: int | None = None
    rtt: int | None = None


class _RoundTrip(_Foreign):
    seqno: int
    lost: Literal["false", "true", "true_down", "true_up"]
    timestamps: _Timestamps
    delay: _Delays = _Delays()


class _Stats(_Foreign):
    duplicates: int = 0
    late_packets: int = 0


class IrttOutput(_Foreign):
    """Output of one client.

    Attributes:
        round_trips: Every probe.
        stats: Counts.
    """

    round_trips: tuple[_RoundTrip, ...] = Field(min_length=LEAST_PROBES)
    stats: _Stats = _Stats()


class _Arrival(NamedTuple):
    sent_s: float
    send_s: float
    receive_s: float


def read_irtt(path: Path, text: str, direction: Direction, clocks: Clocks) -> Measurement:
    """Return the probes of one direction.

    The delay of one direction is the difference of two clocks. Where these are not known to agree, the offset is taken
    for the one with which the shortest delays of both directions are equal; that of a path which is longer in one
    direction cannot be distinguished from an offset.

    Args:
        path: The file, for messages.
        text: Its contents.
        direction: From client to server, or back.
        clocks: Whether both clocks are synchronized, so that delays are taken as they were measured.

    Raises:
        MeasurementError: It is no output of irtt, or its clocks contradict ``clocks``.
    """
    try:
        output = IrttOutput.model_validate_json(text)
    except ValidationError as error:
        first = problems_of(error, IrttOutput)[0]
        if error.errors()[0]["type"] == "json_invalid":
            raise MeasurementError(path, ", contents", error.errors()[0]["msg"], "JSON of irtt") from error
        raise MeasurementError(path, f", {first.field or 'contents'}", first.got, first.allowed) from error
    arrivals = _arrivals(output)
    if len(arrivals) < LEAST_PROBES:
        raise MeasurementError(path, "", f"{len(arrivals)} answers with times of both directions", "two or more")
    offset_s, assumptions = _offset(path, arrivals, clocks)
    is_send = direction is Direction.SEND
    probes = [Probe(one.sent_s, one.send_s - offset_s if is_send else one.receive_s + offset_s) for one in arrivals]
    lost, left_out, undirected = _losses(output, direction)
    if undirected:
        assumptions.append(f"{undirected} probes without an answer were lost in this direction")
    answered_s = [one.sent_s + one.send_s + one.receive_s for one in sorted(arrivals)]
    return Measurement(
        probes=from_begin(probes + lost),
        assumptions=tuple(assumptions),
        duplicates=output.stats.duplicates,
        reordered=sum(later < earlier for earlier, later in pairwise(answered_s)),
        left_out=left_out,
    )


def _arrivals(output: IrttOutput) -> list[_Arrival]:
    return [
        _Arrival(one.timestamps.client.send.wall * _S, one.delay.send * _S, one.delay.receive * _S)
        for one in output.round_trips
        if one.lost == "false"
        and one.delay is not None
        and one.delay.send is not None
        and one.delay.receive is not None
    ]


def _losses(output: IrttOutput, direction: Direction) -> tuple[list[Probe], int, int]:
    """Return the probes lost in a direction, the number of those it does not concern, and of those in doubt."""
    own = "true_up" if direction is Direction.SEND else "true_down"
    lost = [
        Probe(one.timestamps.client.send.wall * _S, LOST) for one in output.round_trips if one.lost in {"true", own}
    ]
    others = sum(one.lost not in {"false", "true", own} for one in output.round_trips)
    return lost, others, sum(one.lost == "true" for one in output.round_trips)


def _offset(path: Path, arrivals: list[_Arrival], clocks: Clocks) -> tuple[float, list[str]]:
    """Return how far the server's clock is ahead, s, and what is assumed of it."""
    if clocks is Clocks.SYNCHRONIZED:
        worst_s = min(min(one.send_s, one.receive_s) for one in arrivals)
        if worst_s < 0.0:
            raise MeasurementError(path, ", clocks", f"a delay of {1e3 * worst_s:.3f} ms", "0 or more if synchronized")
        return 0.0, ["both clocks are synchronized, as was said"]
    offset_s = _even_offset(arrivals)
    quarter = max(1, len(arrivals) // 4)
    drift_s = _even_offset(arrivals[-quarter:]) - _even_offset(arrivals[:quarter])
    assumptions = [
        f"the server's clock is {1e3 * offset_s:.3f} ms ahead: the shortest delays of both directions are then equal"
    ]
    if abs(drift_s) > DRIFT_S:
        assumptions.append(f"that offset is constant, although it seems to change by {1e3 * drift_s:.3f} ms")
    return offset_s, assumptions


def _even_offset(arrivals: list[_Arrival]) -> float:
    return (min(one.send_s for one in arrivals) - min(one.receive_s for one in arrivals)) / 2.0
