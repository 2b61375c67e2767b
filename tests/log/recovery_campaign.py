"""Kills recorders, cuts logs off and damages them at random, recovers each, and checks what the recovery promises.

``make recovery`` runs it at full size; tests run a slice. A round is given by its seed.

A killed recorder runs in a child that is forked after the imports, with the recorder's loop, its thread, its priority
and its log; only its bus is made up: a message every 0.25 ms.
"""

import json
import mmap
import os
import signal
import struct
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Annotated, Final, NamedTuple, NoReturn

import typer
from mcap.reader import make_reader
from passafe_protocol.codec import encode
from passafe_protocol.messages import Event, Header
from passafe_protocol.topics import EVENT
from passafe_services.log.chain import Chain, RecorderCounts
from passafe_services.log.errors import LogReadError
from passafe_services.log.record_scan import IntactRecord, scan_records
from passafe_services.log.segmented_log import RawMessage, SegmentedLog
from passafe_services.log.verification import verify
from passafe_services.loop.realtime import RECORDER_PRIORITY, request_realtime
from passafe_services.recorder.background_log import BackgroundLog
from passafe_services.recorder.record_loop import record
from passafe_services.tools.recover import Recovery, recover

MS: Final = 1_000_000
PERIOD_NS: Final = 250_000
PROMISED_MS: Final = 300.0
START_NS: Final = 1_795_000_000_000_000_000
SOURCES: Final = ("plant", "filter", "operator")
CHUNK: Final = 6
"""Kind of a chunk's record."""


class Written(NamedTuple):
    """Message in a log: key expression, sequence, log time and data."""

    key: str
    sequence: int
    wall_ns: int
    data: bytes


@dataclass
class Tally:
    """Results of a campaign.

    Attributes:
        rounds: Rounds by what was done.
        lost_ms: What each kill cost, ms: from the last message kept to the last one that the recorder had received.
        broken: Promises that were broken, with the seed of the round.
    """

    rounds: Counter[str] = field(default_factory=Counter)
    lost_ms: list[float] = field(default_factory=list)
    broken: list[str] = field(default_factory=list)


def message(source: str, sequence: int, wall_ns: int) -> RawMessage:
    """Return a message that does not compress away."""
    text = f"{sequence * 2654435761 % 2**64:x}" * 8
    data = encode(Header(source, 1, sequence, 0, 0, 0, wall_ns), Event("info", text))
    return RawMessage(EVENT.key(source), data, sequence, wall_ns)


def kept_in(path: Path) -> list[Written]:
    """Return the messages of a log as mcap's own reader gives them, checksums checked; in the order of the file."""
    with path.open("rb") as stream:
        found = make_reader(stream, validate_crcs=True).iter_messages(log_time_order=False)
        return [Written(channel.topic, each.sequence, each.log_time, each.data) for _, channel, each in found]


class _Bus:
    """Makes the messages that were due since the last drain, and notes in shared memory how far it came."""

    def __init__(self, received: mmap.mmap) -> None:
        self._received = received
        self._sequence = 0
        self._next_ns = time.time_ns()

    def drain(self) -> list[tuple[str, bytes]]:
        """Return everything due by now."""
        made, now_ns = [], time.time_ns()
        while self._next_ns <= now_ns:
            each = message("plant", self._sequence, self._next_ns)
            made.append((each.key, each.data))
            self._sequence += 1
            self._next_ns += PERIOD_NS
        self._received[:8] = struct.pack("<q", self._next_ns - PERIOD_NS)
        return made


class _Never:
    """Stop request that does not come."""

    def wait(self, timeout_s: float | None = None) -> bool:
        """Wait."""
        time.sleep(timeout_s or 0.0)
        return False


def _record_until_killed(path: Path, received: mmap.mmap) -> NoReturn:
    request_realtime(RECORDER_PRIORITY)  # as the recorder's process does
    log = BackgroundLog(SegmentedLog(path, {}, Chain("killed")))
    record(_Bus(received), log, publish=lambda *_: None, stop=_Never())
    os._exit(1)


def killed(rng: Random, folder: Path) -> tuple[Path, float]:
    """Let a recorder run and kill it; return its log and the log time of the last message that it had received."""
    path = folder / "killed.mcap"
    received = mmap.mmap(-1, 8)
    child = os.fork()
    if child == 0:
        _record_until_killed(path, received)
    begun = time.monotonic()
    while struct.unpack("<q", received[:8])[0] == 0:
        time.sleep(0.005)
        if time.monotonic() - begun > 20:
            break
    time.sleep(rng.uniform(0.05, 1.2))
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return path, struct.unpack("<q", received[:8])[0]


def kill_round(rng: Random, folder: Path, tally: Tally) -> Iterator[str]:
    """Kill a recorder, recover its log; yield what is broken."""
    path, received_ns = killed(rng, folder)
    first_ns = received_ns
    out = folder / "out.mcap"
    recovery = recover(path, out)
    kept = kept_in(out)
    if [each.sequence for each in kept] != list(range(len(kept))) or len(kept) != recovery.messages:
        yield "messages between the first and the last are missing"
    newest_ns = kept[-1].wall_ns if kept else first_ns
    lost_ms = (received_ns - newest_ns) / MS
    tally.lost_ms.append(lost_ms)
    if lost_ms > PROMISED_MS:
        yield f"{lost_ms:.0f} ms lost"
    if verify(out).found:
        yield "a message is not as it was written"


def base_log(folder: Path) -> Path:
    """Write a log of 30 flushes with 60 messages of three sources each."""
    path = folder / "base.mcap"
    log = SegmentedLog(path, {"driver": {"kind": "live"}, "versions": {"passafe": "0"}}, Chain("base"))
    for k in range(1800):
        log.write(message(SOURCES[k % 3], k // 3, START_NS + k * MS))
        if k % 60 == 59:
            log.flush(RecorderCounts())
    log.close(RecorderCounts())
    return path


class Harm(NamedTuple):
    """Damage of a log: what is put in the place of the bytes from ``start`` to ``end``."""

    start: int
    end: int
    fill: bytes


def cut_off(rng: Random, content: bytes) -> Harm:
    """Return a truncation."""
    return Harm(rng.randrange(8, len(content)), len(content), b"")


def flipped(rng: Random, content: bytes) -> Harm:
    """Return a flipped bit."""
    at = rng.randrange(len(content))
    return Harm(at, at + 1, bytes([content[at] ^ 1 << rng.randrange(8)]))


def zeroed(rng: Random, content: bytes) -> Harm:
    """Return a block of zeros, such as a disk leaves after a loss of power."""
    size = rng.choice((1, 64, 512, 4096, 16384))
    start = rng.randrange(len(content)) // size * size
    return Harm(start, min(start + size, len(content)), bytes(min(size, len(content) - start)))


def cut_out(rng: Random, content: bytes) -> Harm:
    """Return bytes that are taken out."""
    start = rng.randrange(len(content))
    return Harm(start, min(start + rng.choice((1, 7, 100, 512, 4096, 20000)), len(content)), b"")


def scrambled(rng: Random, content: bytes) -> Harm:
    """Return a stretch of other bytes, also of another length."""
    start = rng.randrange(len(content))
    return Harm(start, min(start + rng.randrange(1, 3000), len(content)), rng.randbytes(rng.randrange(1, 3000)))


CORRUPTIONS: Final = (flipped, flipped, zeroed, cut_out, scrambled)


def damage_round(
    rng: Random, folder: Path, base: Path, harms: tuple[Callable[[Random, bytes], Harm], ...]
) -> Iterator[str]:
    """Damage the log, recover it; yield what is broken."""
    content = base.read_bytes()
    harm = rng.choice(harms)(rng, content)
    damaged, out = folder / "damaged.mcap", folder / "out.mcap"
    damaged.write_bytes(content[: harm.start] + harm.fill + content[harm.end :])
    if len(content) == harm.end - harm.start:
        return
    try:
        recovery = recover(damaged, out)
    except LogReadError:  # nothing is intact
        if out.exists() or [*_messages_outside(base, harm)]:
            yield "refused, though something is intact, or with a file left"
        return
    kept, whole = kept_in(out), kept_in(base)
    if len(kept) != recovery.messages:
        yield "the counts are wrong"
    if set(kept) - set(whole):
        yield "a message was altered"
    untouched = set(_messages_outside(base, harm))
    if untouched - set(kept):
        yield f"{len(untouched - set(kept))} intact messages were not kept"
    yield from _unnamed(set(whole) - set(kept), recovery)


def _messages_outside(base: Path, harm: Harm) -> Iterator[Written]:
    """Yield the messages of the chunks that the damage does not touch."""
    keys: dict[int, str] = {}
    with base.open("rb") as stream:
        for found in scan_records(stream, base.stat().st_size):
            if not isinstance(found, IntactRecord) or found.opcode != CHUNK:
                continue
            for each in found.records:
                if hasattr(each, "topic"):
                    keys[each.id] = each.topic
                elif hasattr(each, "channel_id") and (found.end <= harm.start or found.start >= harm.end):
                    yield Written(keys[each.channel_id], each.sequence, each.log_time, each.data)


def _unnamed(missing: set[Written], recovery: Recovery) -> Iterator[str]:
    """Yield what is missing and neither in the sequence numbers nor in the times that the recovery names."""
    for each in sorted(missing, key=lambda one: one.wall_ns):
        for loss in recovery.losses:
            ranges = loss.missing.get(each.key)
            after = loss.after_ns is None or loss.after_ns <= each.wall_ns
            before = loss.before_ns is None or each.wall_ns <= loss.before_ns
            if (ranges and ranges[0] <= each.sequence <= ranges[1]) or (after and before):
                break
        else:
            yield f"{each.key} {each.sequence} is missing, and not named"
            return


def campaign(kills: int, truncations: int, corruptions: int, seed: int) -> Tally:
    """Run so many rounds of each kind.

    Args:
        kills: Recorders that are killed.
        truncations: Logs that are cut off.
        corruptions: Logs that are damaged.
        seed: Seed of the first round of each kind.
    """
    tally = Tally()
    with TemporaryDirectory() as name:
        base = base_log(Path(name))
        plan = {
            "kill": (kills, lambda rng, folder: kill_round(rng, folder, tally)),
            "truncation": (truncations, lambda rng, folder: damage_round(rng, folder, base, (cut_off,))),
            "corruption": (corruptions, lambda rng, folder: damage_round(rng, folder, base, CORRUPTIONS)),
        }
        for kind, (rounds, play) in plan.items():
            for number in range(seed, seed + rounds):
                with TemporaryDirectory() as folder:
                    said = list(play(Random(f"{kind} {number}"), Path(folder)))
                tally.rounds[kind] += 1
                tally.broken += [f"{kind} {number}: {each}" for each in said]
    return tally


def main(
    kills: Annotated[int, typer.Option(min=0)] = 200,
    truncations: Annotated[int, typer.Option(min=0)] = 200,
    corruptions: Annotated[int, typer.Option(min=0)] = 200,
    seed: Annotated[int, typer.Option(help="Seed of the first round of each kind.")] = 0,
) -> None:
    """Run the campaign, print its results, and exit with 1 if a promise was broken."""
    tally = campaign(kills, truncations, corruptions, seed)
    worst = max(tally.lost_ms, default=0.0)
    median = sorted(tally.lost_ms)[len(tally.lost_ms) // 2] if tally.lost_ms else 0.0
    result = {"rounds": dict(tally.rounds), "lost_ms_worst": worst, "lost_ms_median": median, "broken": tally.broken}
    sys.stdout.write(json.dumps(result, indent=2) + "\n")
    raise typer.Exit(int(bool(tally.broken)))


if __name__ == "__main__":
    typer.run(main)
