"""One running system: a second operator, then an emergency stop that outlasts all that dies, until it is cleared."""

import os
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import cast

import pytest
from passafe_protocol.codec import decode
from passafe_protocol.messages import OperatorCommand, OperatorLease, PlantPhase, PlantState
from passafe_protocol.topics import COMMAND, LEASE, STATE
from passafe_services.cli.app import app
from passafe_services.loop.bus import Bus, TopicReader, open_bus
from passafe_services.loop.outlet import Outlet
from passafe_services.loop.router_endpoint import RouterEndpoint
from running_demo import RunningDemo, running_demo
from typer.testing import CliRunner

pytestmark = pytest.mark.live

PATIENCE_S = 60.0
STRANGER = 7


def wait_for(newest: Callable[[], object | None], wanted: Callable[[object], bool]) -> None:
    end_s = time.monotonic() + PATIENCE_S
    while time.monotonic() < end_s:
        found = newest()
        if found is not None and wanted(found):
            return
        time.sleep(0.002)
    raise AssertionError(f"nothing of the kind within {PATIENCE_S:g} s")


class Watch:
    """Reads states and leases, and sends as a second operator."""

    def __init__(self, bus: Bus) -> None:
        self.states = bus.reader(STATE)
        self.leases = bus.reader(LEASE)
        self.stranger = Outlet(bus, "operator", STRANGER)

    def command(self, *, take_over: int = 0) -> None:
        """Send a command of the second operator."""
        now_ns = time.monotonic_ns()
        body = OperatorCommand((0.0, 0.0), (), enabled=False, device="stranger", take_over=take_over)
        self.stranger.publish(COMMAND, body, scheduled_ns=now_ns, started_ns=now_ns)

    def newest(self, reader: TopicReader) -> object | None:
        """Return the newest message that came since the last call."""
        found = reader.drain()
        return decode(STATE if reader is self.states else LEASE, found[-1])[1] if found else None

    def until_lease(self, wanted: Callable[[OperatorLease], bool], **command: int) -> OperatorLease:
        """Return the first lease that is wanted, sending commands until then if any are given."""
        kept: list[OperatorLease] = []

        def newest() -> object | None:
            if command:
                self.command(**command)
            return self.newest(self.leases)

        wait_for(newest, lambda lease: kept.append(cast("OperatorLease", lease)) or wanted(kept[-1]))
        return kept[-1]

    def until_state(self, wanted: Callable[[PlantState], bool]) -> None:
        """Wait for a state."""
        wait_for(lambda: self.newest(self.states), lambda state: wanted(cast("PlantState", state)))

    def phases(self, states: int) -> set[PlantPhase]:
        """Return the phases of that many states from now on, or a few more."""
        self.states.drain()
        found: list[PlantPhase] = []

        def take() -> object:
            found.extend(cast("PlantState", decode(STATE, data)[1]).phase for data in self.states.drain())
            return found

        wait_for(take, lambda _: len(found) >= states)
        return set(found)


def runs(state: PlantState) -> bool:
    return state.phase is PlantPhase.RUNNING


def second_operator_joins_takes_over_and_quits(watch: Watch) -> None:
    first = watch.until_lease(lambda lease: lease.holder != 0)
    joined = watch.until_lease(lambda lease: lease.refused == STRANGER, take_over=0)
    assert (joined.holder, joined.number) == (first.holder, first.number)
    taken = watch.until_lease(lambda lease: lease.holder == STRANGER, take_over=first.number)
    assert taken.number == first.number + 1
    back = watch.until_lease(lambda lease: lease.holder == first.holder)  # the stranger is silent
    assert back.number == first.number + 2


def stop_outlasts_its_operator_and_filter(watch: Watch, demo: RunningDemo) -> None:
    children = demo.children()
    for name in ("operator", "filter"):  # neither can stop anything, or knows
        os.kill(children[name], signal.SIGSTOP)
    pressed = CliRunner().invoke(app, ["stop", "a person in the way", "--router", demo.router])
    assert pressed.exit_code == 0, pressed.output
    assert "it stays stopped until `passafe clear`" in pressed.output
    watch.states.drain()
    os.kill(children["filter"], signal.SIGKILL)  # another one is started
    os.kill(children["operator"], signal.SIGCONT)
    watch.until_lease(lambda lease: lease.number == 1)
    assert watch.phases(50) == {PlantPhase.FAIL_SAFE}  # whatever is driven, nothing may move it
    cleared = CliRunner().invoke(app, ["clear", "--router", demo.router])
    assert cleared.exit_code == 0, cleared.output
    watch.until_state(runs)
    assert "no emergency stop is latched" in CliRunner().invoke(app, ["clear", "--router", demo.router]).output


def test_lease_and_stop_of_a_running_system(tmp_path: Path) -> None:
    with running_demo(tmp_path, "--restart", "--headless", "--rate", "250") as demo:
        demo.wait_for("running; end with Ctrl-C")
        with open_bus(RouterEndpoint.of_demo(demo.router_port, "operator")) as bus:
            watch = Watch(bus)
            watch.until_state(runs)
            second_operator_joins_takes_over_and_quits(watch)
            stop_outlasts_its_operator_and_filter(watch, demo)
        demo.process.send_signal(signal.SIGINT)
        demo.end()
        assert "an emergency stop (console) was latched from" in " ".join(demo.lines)
