"""Keyboard as a command source: converts key presses into a smooth command with a known rate."""

from collections.abc import Callable, Sequence
from math import hypot
from typing import ClassVar, Final, NamedTuple

from passafe_protocol.messages import Vector

from passafe_services.operator.keyboard.keys import DIRECTIONS, Key
from passafe_services.operator.sources.command import Command
from passafe_services.operator.sources.follower import Follower
from passafe_services.operator.sources.source import SourceClock

RAMP_S: Final = 0.1
"""Time constant with which u_h follows the keys: u̇_h = (target − u_h)/RAMP_S."""
PRESS_HOLD_S: Final = 0.7
"""Time for which a first press counts as held: longer than the usual delay (up to 0.66 s) before a key repeats."""
REPEAT_HOLD_S: Final = 0.2
"""Time for which a repeating key counts as held after its last repeat; keys repeat every 0.03 to 0.1 s."""
REST_SHARE: Final = 1e-3
"""A released command counts as zero below this share of the authority."""


class _Hold(NamedTuple):
    """Key that counts as held: time of its last event and time until which it counts."""

    seen_s: float
    until_s: float


class Keyboard:
    """Moves u_h towards ``authority`` in the direction of the held keys, first-order with ``RAMP_S``.

    A terminal reports presses and repeats, never releases. So a key counts as held for ``PRESS_HOLD_S`` after a press,
    and for ``REPEAT_HOLD_S`` after an event within ``REPEAT_HOLD_S`` of the previous one, which must be a repeat. A key
    releases those that oppose it. When none is held, u_h fades to zero with the same time constant; the dead-man switch
    counts as held until then. ``STOP`` zeroes u_h at once; keys count again only after ``REPEAT_HOLD_S`` without any,
    so that pending repeats cannot undo it. ``QUIT`` stops for good and sets ``finished``. ``EMERGENCY_STOP`` stops
    likewise and is counted for the node to press, ``TAKE_OVER`` is counted only.

    Between key events u_h is the exact solution, so that it does not depend on the rate of the commands.

    Attributes:
        finished: Whether the person has ended the session.
        stops: Presses of the emergency stop.
        take_overs: Requests to take the lease over.
    """

    device: ClassVar[str] = "keyboard"
    clock: ClassVar[SourceClock] = SourceClock.LOCAL

    def __init__(self, *, authority: float, inputs: int, keys: Callable[[], Sequence[Key]]) -> None:
        """Start at rest.

        Args:
            authority: ‖u_h‖ that held keys tend to, units of u.
            inputs: m, 1 (left and right only) or 2.
            keys: Returns the keys since its last call, in order; must not block. It is the only input of the source,
                so playing back a list of keys reproduces the commands.
        """
        self.finished = False
        self.stops = self.take_overs = 0
        self._authority = authority
        self._keys = keys
        self._rest: Vector = (0.0,) * inputs
        self._u_h = Follower(inputs, RAMP_S)
        self._t_s = 0.0
        self._held: dict[Key, _Hold] = {}
        self._quiet_until_s: float | None = None

    def command(self, t_s: float) -> Command:
        """Process the keys received by ``t_s`` and return the command.

        Args:
            t_s: Local time, s; non-decreasing.
        """
        self._advance(t_s)
        for key in self._keys():
            if key in DIRECTIONS:
                self._press(key, t_s)
            elif key is Key.TAKE_OVER:
                self.take_overs += 1
            else:
                self._stop(t_s)
                self.stops += key is Key.EMERGENCY_STOP
                self.finished = self.finished or key is Key.QUIT
        return Command(self._u_h.value, self._u_h.rate, bool(self._held) or self._u_h.value != self._rest)

    def _advance(self, t_s: float) -> None:
        """Advance u_h to ``t_s``, releasing each key exactly when its time is over."""
        while self._held:
            over_s = min(hold.until_s for hold in self._held.values())
            if over_s > t_s:
                break
            self._ramp(over_s)
            self._held = {key: hold for key, hold in self._held.items() if hold.until_s > over_s}
            self._update_target()
        self._ramp(t_s)

    def _ramp(self, t_s: float) -> None:
        self._u_h.advance(t_s - self._t_s)
        self._t_s = t_s
        if self._u_h.target == self._rest and hypot(*self._u_h.value) < REST_SHARE * self._authority:
            self._u_h.rest()

    def _update_target(self) -> None:
        """Set the target to the sum of the directions of the held keys."""
        pushes = [DIRECTIONS[key][: len(self._rest)] for key in self._held]
        total = [sum(push[axis] for push in pushes) for axis in range(len(self._rest))]
        length = hypot(*total)
        self._u_h.aim([c * self._authority / length for c in total] if length else self._rest)

    def _press(self, key: Key, t_s: float) -> None:
        if self.finished:
            return
        if self._quiet_until_s is not None:
            if t_s < self._quiet_until_s:
                self._quiet_until_s = t_s + REPEAT_HOLD_S
                return
            self._quiet_until_s = None
        before = self._held.get(key)
        repeated = before is not None and t_s - before.seen_s <= REPEAT_HOLD_S
        x, y = DIRECTIONS[key]
        self._held = {
            other: hold
            for other, hold in self._held.items()
            if DIRECTIONS[other][0] * x + DIRECTIONS[other][1] * y >= 0
        }
        self._held[key] = _Hold(t_s, t_s + (REPEAT_HOLD_S if repeated else PRESS_HOLD_S))
        self._update_target()

    def _stop(self, t_s: float) -> None:
        self._held = {}
        self._u_h.rest()
        self._quiet_until_s = t_s + REPEAT_HOLD_S
