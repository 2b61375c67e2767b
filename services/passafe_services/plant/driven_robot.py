"""The robot in plant time, under the input in force."""

from collections.abc import Callable, Sequence
from typing import Final

from passafe_protocol.messages import Event, GuardAction, PlantPhase, PlantState, Vector
from passafe_protocol.topics import EVENT, STATE

from passafe.sampled_plant import SampledPlant
from passafe_services.drivers.plant_driver import PlantDriver
from passafe_services.node import Outgoing
from passafe_services.plant.guard import Guard, Guarded
from passafe_services.plant.input_account import InputAccount
from passafe_services.plant.state_reader import StateReader
from passafe_services.plant.stop_latch import StopLatch
from passafe_services.plant_contract.fail_safe import FailSafe

# Members by name: reaching one through its enumeration takes 0.7 µs on Python 3.11.
WAITING: Final = PlantPhase.WAITING
RUNNING: Final = PlantPhase.RUNNING
FAIL_SAFE: Final = PlantPhase.FAIL_SAFE

REPORT_NS: Final = 1_000_000_000
"""Shortest time between two events about refused readings, ns: a driver may refuse at its rate."""


class DrivenRobot:
    """Moves the robot through its driver, one period at a time; the plant node chooses the input of each period.

    The robot rests (``WAITING``) until plant time begins with the first input. When inputs stop, the last one is
    held (``HOLDING``), then the model's fail-safe law takes over (``FAIL_SAFE``). While an emergency stop is latched,
    the law is in force whatever the node would choose: no input has a way around the latch, nor does a guard change it.

    A driver without a clock of its own is stepped through every period that passed; one with a clock has moved on
    meanwhile, so that only the newest of them reads, applies and is reported.

    Attributes:
        plant_ns: Plant time, ns.
        phase: Origin of the input in force.
        applied_tick: Tick of the input in force.
        has_origin: Whether the beginning of plant time is set.
        account: Counts and times of the inputs received, for the state messages.
        latch: Emergency stop.
        period_ns: Period of a step, ns.
    """

    def __init__(
        self,
        driver: PlantDriver,
        plant: SampledPlant,
        fail_safe: FailSafe,
        *,
        x0: Sequence[float],
        period_ns: int,
        playout_ns: int,
        latch: StopLatch | None = None,
        guard: Guard | None = None,
    ) -> None:
        """Begin before the first input.

        Args:
            driver: Reads and moves the robot; open.
            plant: Model of the robot, stepped with the period.
            fail_safe: Rule for missing inputs.
            x0: State that counts before the first reading, n numbers.
            period_ns: Period of a step, ns.
            playout_ns: Time between arrival and effect of the first input, ns.
            latch: Emergency stop; one that is not latched if not given.
            guard: Judges every input before it is applied; none if not given.
        """
        self._fail_safe = fail_safe
        self._guard = guard
        self._guarded = _unguarded((0.0,) * plant.system.m)
        self.account = InputAccount()
        self.latch = StopLatch() if latch is None else latch
        self.period_ns = period_ns
        self._playout_ns = playout_ns
        self._origin_ns = 0
        self.has_origin = False
        self.plant_ns = 0
        self._u: Vector = (0.0,) * plant.system.m
        self._reader = StateReader(driver, plant, x0=x0, u=self._u, period_ns=period_ns)
        self._has_own_clock = driver.has_own_clock
        self.applied_tick = 0
        self._since_ns = 0
        self._hold_ns = 0
        self.phase = WAITING
        self._energy_in_j = 0.0
        self._refused_ns = -REPORT_NS

    @property
    def is_blind(self) -> bool:
        """Return whether the driver has no state that could be led to the present."""
        return self._reader.is_blind

    def begin_at(self, first_ns: int, received_ns: int) -> None:
        """Begin plant time with an input, one play-out time after its arrival, unless it is set already.

        Args:
            first_ns: Plant time of the input, ns.
            received_ns: Time of its arrival, monotonic, ns.
        """
        if not self.has_origin or first_ns != self.plant_ns:
            self.plant_ns, self.has_origin = first_ns, True
            # Steps lie on a grid: the first one after the play-out time is plant time `first_ns`.
            self._origin_ns = received_ns + self._playout_ns - first_ns

    def plant_time_of(self, monotonic_ns: int) -> int:
        """Return the plant time at a monotonic time, ns."""
        return monotonic_ns - self._origin_ns

    def run_to(self, now_ns: int, choose_input: Callable[[], None]) -> Sequence[Outgoing]:
        """Return the states of every period since the previous call, or the current one.

        Args:
            now_ns: Monotonic time, ns.
            choose_input: Sets the input of the period that begins, with ``apply`` or ``apply_fail_safe``.
        """
        if self.phase is WAITING:
            self._reader.read(now_ns)
            if self.latch.is_latched or self.is_blind:
                self.has_origin = False
        if not self.has_origin or now_ns < self._origin_ns + self.plant_ns:
            return () if self.is_blind else ((STATE, self._state()),)
        outgoing: list[Outgoing] = []
        if self.phase is WAITING:
            self._begin_period(choose_input, outgoing)
            if self.phase is WAITING:  # the first input did not take effect
                self.has_origin = False
                return outgoing
        due_ns = self._origin_ns + self.plant_ns + self.period_ns
        while due_ns <= now_ns:
            self.plant_ns += self.period_ns
            is_reported = not self._has_own_clock or due_ns + self.period_ns > now_ns
            if is_reported:
                self._energy_in_j += self._reader.read(due_ns).energy_in_j
            self._begin_period(choose_input, outgoing, is_reported=is_reported)
            due_ns += self.period_ns
        return outgoing or (() if self.is_blind else ((STATE, self._state()),))

    def apply(self, u: Vector, tick: int, hold_ns: int, since_ns: int) -> None:
        """Apply an input.

        Args:
            u: The input, m numbers.
            tick: Filter tick of its decision.
            hold_ns: Longest time for which it may be in force, ns.
            since_ns: Plant time from which it counts as in force, ns.
        """
        self._u, self.applied_tick, self._hold_ns = u, tick, hold_ns
        self._since_ns, self.phase = since_ns, RUNNING

    def apply_fail_safe(self) -> None:
        """Hold the last input for its hold time, then apply the fail-safe law; wait before the first input."""
        if self.phase is not WAITING:
            self.phase, self._u = self._fail_safe.without_input(
                self._u, self._since_ns, self.plant_ns, self._reader.sample.x, self._hold_ns
            )

    def apply_law(self) -> None:
        """Apply the fail-safe law at once; wait before the first input."""
        if self.phase is not WAITING:
            self.phase, self._u = FAIL_SAFE, self._fail_safe.law(self._reader.sample.x)
            self._since_ns = self.plant_ns - self._fail_safe.hold_ns  # nothing is held afterwards

    def _begin_period(
        self, choose_input: Callable[[], None], outgoing: list[Outgoing], *, is_reported: bool = True
    ) -> None:
        """Choose and apply the input of the period; add an event if the law starts or ends, and the state if known."""
        before = self.phase
        if self.latch.is_latched:
            self.apply_law()
        else:
            choose_input()
        if is_reported and self.phase is not WAITING:
            self._pass_guard(outgoing)
            self._reader.apply(self._guarded.u, self._origin_ns + self.plant_ns)
        if self.phase is not before and (before is FAIL_SAFE or self.phase is FAIL_SAFE):
            outgoing.append((EVENT, self._fail_safe_event()))
        if is_reported and self._reader.refusal and self.plant_ns - self._refused_ns >= REPORT_NS:
            self._refused_ns = self.plant_ns
            outgoing.append((EVENT, Event("warning", f"refused what was read of the robot: {self._reader.refusal}")))
        if is_reported and not self.is_blind:
            outgoing.append((STATE, self._state()))

    def _pass_guard(self, outgoing: list[Outgoing]) -> None:
        """Have the guard judge the input of the period; add an event if it acts for another cause."""
        guard = self._guard
        if guard is None or self.latch.is_latched or self.is_blind:
            self._guarded = _unguarded(self._u)
            return
        self._guarded = guarded = guard.judge(self._reader.sample.x, self._guarded.u, self._u, self.plant_ns)
        event = guard.event(guarded, self.plant_ns)
        if event is not None:
            outgoing.append((EVENT, event))

    def _fail_safe_event(self) -> Event:
        at = f"plant time {self.plant_ns / 1e9:.3f} s"
        if self.phase is FAIL_SAFE:
            cause = "no state from the robot" if self.is_blind else "inputs stopped"
            cause = "emergency stop" if self.latch.is_latched else cause
            return Event("warning", f"{cause}: fail-safe law in force at {at}")
        return Event("info", f"inputs are back: fail-safe law released at {at}")

    def _state(self) -> PlantState:
        sample, account, latch = self._reader.sample, self.account, self.latch
        transit, guarded, guard = account.transit, self._guarded, self._guard
        return PlantState(
            self.plant_ns,
            sample.x,
            sample.y,
            guarded.u,
            self.applied_tick,
            self.phase,
            self._energy_in_j,
            sample.stored_j,
            account.lead_ns,
            account.late,
            account.refused,
            sample.integration_error,
            account.received_tick,
            account.sequence_break_ns,
            self._since_ns,
            transit.largest_ns,
            transit.epoch,
            latch.stop,
            latch.source,
            latch.cleared,
            guarded.action,
            () if guarded.u == self._u else self._u,
            guarded.cause,
            0 if guard is None else guard.changed,
            self._reader.true_x,
        )


def _unguarded(u: Vector) -> Guarded:
    return Guarded(u, GuardAction.NONE, "")
