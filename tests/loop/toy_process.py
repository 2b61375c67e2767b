"""Small processes for the tests of the live runtime: ``python toy_process.py KIND …``."""

import argparse
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence

from passafe_protocol.codec import decode
from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.messages import OperatorCommand, PlantInput, Received
from passafe_protocol.topics import COMMAND, INPUT, TOPIC_OF_NAME
from passafe_services.loop.bus import TopicReader, open_bus
from passafe_services.loop.live import run_live
from passafe_services.loop.readiness import announce_ready
from passafe_services.loop.router_endpoint import RouterEndpoint
from passafe_services.loop.stop import stop_requests
from passafe_services.node import Outgoing
from passafe_services.router.process import run_router

from passafe.errors import PassafeError

FOREVER_S = 60.0
BEFORE_THE_FIRST = -1


class Metronome:
    """An operator whose command holds the number of the step and the time that the step was given."""

    name = "operator"
    subscribes = ()

    def __init__(
        self,
        *,
        non_finite: bool = False,
        broken_at: int | None = None,
        hangs_at: int | None = None,
        hangs_s: float = FOREVER_S,
    ) -> None:
        """``non_finite``: every tenth command is not finite. ``broken_at``: step that raises; ``hangs_at``: waits."""
        self.steps = 0
        self.call: tuple[int, str] | None = None
        self._non_finite, self._broken_at, self._hangs_at, self._hangs_s = non_finite, broken_at, hangs_at, hangs_s

    def step(self, now_ns: int, inbox: Sequence[Received]) -> Sequence[Outgoing]:
        """Send one command."""
        del inbox
        if self.steps == self._broken_at:
            raise ValueError("no such\nstick")
        self.call = (self.steps, "stick: move")
        begun_s = time.monotonic()
        while self.steps == self._hangs_at and time.monotonic() - begun_s < self._hangs_s:
            pass  # without a pause, as the worst do
        self.call = None
        count = float("nan") if self._non_finite and self.steps % 10 == 9 else float(self.steps)
        self.steps += 1
        body = OperatorCommand((count, now_ns / 1.0), (), enabled=True, device="metronome")
        return ((COMMAND, lambda: body),)


class Echo:
    """A filter that answers each command with how it received it."""

    name = "filter"
    subscribes = (COMMAND,)

    def __init__(self) -> None:
        self.seen = 0

    def step(self, now_ns: int, inbox: Sequence[Received]) -> Sequence[Outgoing]:
        """Answer each command."""
        out: list[Outgoing] = []
        for received in inbox:
            header, received_ns = received.header, received.received_ns
            self.seen += 1
            times = (float(header.sequence), float(received_ns), float(now_ns), float(header.sent_ns))
            out.append((INPUT, PlantInput(self.seen, times, 0, 0)))
        return out


def hold_up(seconds: float) -> None:
    """Let every look at what came take so long before it begins, as where a process has to wait for a processor."""
    drain = TopicReader.drain

    def held_up(reader: TopicReader, at_most: int | None = None) -> list[bytes]:
        time.sleep(seconds)
        return drain(reader, at_most)

    TopicReader.drain = held_up


def metronome_of(options: argparse.Namespace) -> Metronome:
    return Metronome(
        non_finite=options.non_finite,
        broken_at=options.broken_at,
        hangs_at=options.hangs_at,
        hangs_s=options.hangs_s,
    )


def begin(options: argparse.Namespace) -> None:
    if options.broken_at == BEFORE_THE_FIRST:
        raise ValueError("no stick")


def live(options: argparse.Namespace) -> None:
    if options.held_up:
        hold_up(options.held_up)
    node = Echo() if options.kind == "filter" else metronome_of(options)
    steps_wanted = options.steps
    report = run_live(
        node,
        rate_hz=options.rate,
        endpoint=RouterEndpoint(port=options.port),
        links={"operator-to-filter": LinkSettings(delay_s=options.delay, loss=options.loss)},
        duration_s=options.duration,
        epoch=options.epoch,
        lifeline=options.lifeline,
        finished=None if steps_wanted is None else lambda: node.steps >= steps_wanted,
        begun=lambda: begin(options),
        ended=lambda: say(ended=node.steps) if options.broken_at is not None else None,
        waits_in=(lambda: node.call) if isinstance(node, Metronome) else None,
    )
    say(steps=report.steps, missed=report.steps_skipped, withheld=report.withheld, reason=report.reason.name)


def record(options: argparse.Namespace) -> None:
    """Read everything; when the lifeline ends, say which numbers came by key."""
    numbers: dict[str, list[int]] = {}
    with stop_requests(lifeline=True) as stop, open_bus(RouterEndpoint(port=options.port)) as bus:
        lossless = bus.recording_reader()
        ring = bus.reader(COMMAND)
        announce_ready("recorder")
        while not stop.wait(0.02):
            note(lossless.drain(), numbers)
            note([("ring", data) for data in ring.drain()], numbers)
        while not time.sleep(0.3) and (rest := lossless.drain()):  # nothing for so long: nothing is under way
            note(rest, numbers)
    say(**numbers)


def note(messages: list[tuple[str, bytes]], numbers: dict[str, list[int]]) -> None:
    for key, data in messages:
        topic = TOPIC_OF_NAME.get(key.rpartition("/")[2], COMMAND)
        numbers.setdefault(key, []).append(decode(topic, data)[0].sequence)


def stubborn(options: argparse.Namespace) -> None:
    """Ignore SIGTERM and start a child that does so too."""
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    sleeper = f"import time; time.sleep({FOREVER_S})"
    child = subprocess.Popen([sys.executable, "-c", sleeper])
    say(pid=os.getpid(), child=child.pid)
    announce_ready(options.name)
    time.sleep(FOREVER_S)


def plain(options: argparse.Namespace) -> None:
    """Print the pid, report readiness if requested, and wait for the end."""
    with stop_requests(lifeline=True) as stop:
        say(pid=os.getpid())
        sys.stderr.write("to standard error\n")
        if options.kind != "slow":
            announce_ready(options.name)
        if options.kind == "brief":
            sys.exit(options.code)
        stop.wait(FOREVER_S)
        say(stopped=options.name)


def say(**values: object) -> None:
    sys.stdout.write(f"{json.dumps(values)}\n")
    sys.stdout.flush()


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("kind")
    parser.add_argument("--port", type=int, default=0)
    parser.add_argument("--name", default="toy")
    parser.add_argument("--rate", type=float, default=1000.0)
    parser.add_argument("--duration", type=float)
    parser.add_argument("--steps", type=int)
    parser.add_argument("--broken-at", type=int)
    parser.add_argument("--hangs-at", type=int)
    parser.add_argument("--hangs-s", type=float, default=FOREVER_S)
    parser.add_argument("--epoch", type=int)
    parser.add_argument("--delay", type=float, default=0.0)
    parser.add_argument("--loss", type=float, default=0.0)
    parser.add_argument("--held-up", type=float, default=0.0)
    parser.add_argument("--code", type=int, default=0)
    parser.add_argument("--non-finite", action="store_true")
    parser.add_argument("--lifeline", action="store_true")
    options = parser.parse_args()
    try:
        match options.kind:
            case "router":
                reason = run_router(RouterEndpoint(port=options.port), lifeline=options.lifeline)
                say(reason=None if reason is None else reason.name)
            case "operator" | "filter":
                live(options)
            case "recorder":
                record(options)
            case "stubborn":
                stubborn(options)
            case _:
                plain(options)
    except PassafeError as fault:
        say(fault=type(fault).__name__, text=str(fault))
        sys.exit(2)


if __name__ == "__main__":
    main()
