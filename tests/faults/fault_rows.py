"""Every fault of the table: what is done to whom, for how long, and what is promised."""

import signal
from collections.abc import Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import partial

from fault_system import CLOCKED, PROCESSES, FaultSystem
from injections import (
    Injection,
    clock_jump,
    clock_set_back_restart,
    deleted_folder,
    duplicate,
    full_disk,
    hogged_processors,
    no_descriptors,
    no_memory,
    signalled,
    suspended,
)
from passafe_protocol.topics import COMMAND, INPUT, STATE
from strangers import (
    corrupted,
    far_future,
    flood,
    in_background,
    many_keys,
    other_version,
    oversized,
    silent_pages,
    slow_reader,
)

HOUR_S = 3600.0
STOPPED = 3
"""Exit code of a demo in which a process died or left."""

DRIVES_ON = "drives on"
LOOP = ("router", "operator", "filter", "plant")
"""Processes without which the robot is not driven."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Fault:
    """One row of the table.

    Attributes:
        name: What happens.
        target: To which process or topic.
        promise: In words.
        inject: Begins and ends it.
        length_s: How long it lasts, s.
        settle_s: How long the run is left alone afterwards, s.
        safe_s: Time within which nothing old or unknown drives the robot any more, s.
        recover_s: Time after its end within which the robot is driven again for good, s.
        exit_code: Of a run that it ends; ``None``: the run goes on.
        stranger: Whether it needs a bus that anybody may write on.
    """

    name: str
    target: str
    promise: str
    inject: Injection
    length_s: float = 0.0
    settle_s: float = 1.5
    safe_s: float = 0.3
    recover_s: float = 1.0
    exit_code: int | None = None
    stranger: bool = False

    @property
    def drives_on(self) -> bool:
        """True if the robot may not stop being driven at all."""
        return self.promise.endswith(DRIVES_ON) and not self.exit_code

    @property
    def key(self) -> str:
        """Name and target."""
        return f"{self.name}, {self.target}"


def survived() -> Iterator[Fault]:
    """Yield the faults of processes and of the machine through which a run goes on."""
    restarted = {"settle_s": 7.0, "recover_s": 6.0}
    for name in ("router", "operator", "filter"):
        yield Fault(
            name="kill -9",
            target=name,
            inject=signalled(name, signal.SIGKILL),
            promise="fail-safe or faded command within 0.3 s; restarted, drives within 6 s",
            **restarted,
        )
    yield Fault(
        name="kill -9",
        target="dashboard",
        inject=signalled("dashboard", signal.SIGKILL),
        promise=DRIVES_ON,
        settle_s=7.0,
    )
    for name in (*PROCESSES, "demo"):
        promise = "within 0.3 s safe; drives 1 s after SIGCONT" if name in LOOP else DRIVES_ON
        yield Fault(
            name="SIGSTOP 3 s, SIGCONT",
            target=name,
            inject=suspended(name),
            promise=promise,
            length_s=3.0,
            settle_s=2.0,
        )
    for name in CLOCKED:
        for offset_s in (HOUR_S, -HOUR_S):
            sign = "+" if offset_s > 0 else "−"
            yield Fault(
                name=f"wall clock {sign}1 h, then back",
                target=name,
                inject=clock_jump(name, offset_s),
                promise=DRIVES_ON,
                length_s=0.7,
                settle_s=0.8,
            )
    for name in ("operator", "filter"):
        yield Fault(
            name="kill -9, clock 1 h back",
            target=name,
            inject=clock_set_back_restart(name, -HOUR_S),
            promise="as without the clock: not locked out",
            **restarted,
        )
    for name in PROCESSES:
        yield Fault(
            name="no more file descriptors, 1 s",
            target=name,
            inject=no_descriptors(name),
            promise=DRIVES_ON,
            length_s=1.0,
        )
    for name in ("router", "dashboard", "operator", "filter"):
        yield Fault(
            name="no more memory, 1 s",
            target=name,
            inject=no_memory(name),
            length_s=1.0,
            promise=f"{DRIVES_ON}, or dies and is restarted",
            **restarted,
        )
    yield Fault(
        name="4 busy processes, 2 s",
        target="machine",
        inject=hogged_processors,
        length_s=2.0,
        safe_s=3.0,
        promise="drives on, or safe and back within 1 s",
    )


def from_strangers() -> Iterator[Fault]:
    """Yield the faults that others on an open bus, or at the page, bring about."""
    nothing = f"refused and reported; {DRIVES_ON}"
    load = "refused and reported; drives on, or safe and back within 1 s"
    for topic in (COMMAND, INPUT, STATE):
        for name, inject, promise in (
            ("20,000 garbage messages/s, 1 s", flood(topic), load),
            ("flipped bits", corrupted(topic), nothing),
            ("6 messages of 50 MB", oversized(topic), load),
            ("forged, epoch 2⁶⁴ − 1", far_future(topic), nothing),
            ("schema version 99", other_version(topic), nothing),
        ):
            yield Fault(
                name=name,
                target=topic.name,
                inject=inject,
                promise=promise,
                length_s=1.0,
                safe_s=2.0,  # when the load is felt is chance
                stranger=True,
            )
    for name in ("operator", "filter", "plant"):
        yield Fault(
            name="a second process",
            target=name,
            inject=partial(_duplicate, name),
            promise=f"the first stays; {DRIVES_ON}",
            length_s=6.0,
            stranger=True,
        )
    yield Fault(
        name="thousands of keys",
        target="bus",
        inject=in_background(many_keys),
        promise=nothing,
        length_s=1.0,
        stranger=True,
    )
    yield Fault(
        name="reader that never reads",
        target="bus",
        inject=in_background(slow_reader),
        promise=DRIVES_ON,
        length_s=2.0,
        stranger=True,
    )
    yield Fault(
        name="200 pages that read nothing",
        target="page",
        inject=silent_pages,
        promise=DRIVES_ON,
        length_s=2.0,
        stranger=True,
    )


def ending() -> Iterator[Fault]:
    """Yield the faults that end a run: said at once, exit code not 0, and a verdict on what there is."""
    promise = f"run ends, reason and verdict said, exit {STOPPED}"
    for name in ("recorder", "plant"):
        yield Fault(
            name="kill -9", target=name, inject=signalled(name, signal.SIGKILL), promise=promise, exit_code=STOPPED
        )
    for name in PROCESSES[:-1]:
        yield Fault(
            name="SIGTERM", target=name, inject=signalled(name, signal.SIGTERM), promise=promise, exit_code=STOPPED
        )
    yield Fault(
        name="SIGTERM",
        target="plant",
        inject=signalled("plant", signal.SIGTERM),
        exit_code=1,
        promise="run ends; verdict: not a whole run; exit 1",
    )
    promise = f"said at once, the run goes on; verdict on what there is, exit {STOPPED}"
    yield Fault(name="full disk", target="recorder", inject=full_disk, promise=promise, exit_code=STOPPED)
    yield Fault(name="folder deleted", target="recorder", inject=deleted_folder, promise=promise, exit_code=STOPPED)
    yield Fault(
        name="kill -9",
        target="demo",
        inject=signalled("demo", signal.SIGKILL),
        exit_code=-signal.SIGKILL,
        promise="all processes end within 15 s; the log is finished",
    )


def _duplicate(name: str, system: FaultSystem) -> AbstractContextManager[None]:
    return duplicate(system, name)
