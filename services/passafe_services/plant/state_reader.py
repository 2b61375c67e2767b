"""Reads the robot's state through its driver, at the times of the plant's periods."""

from collections import deque
from collections.abc import Sequence
from math import isfinite
from typing import Final

from passafe_protocol.messages import Vector

from passafe.sampled_plant import Sample, SampledPlant
from passafe_services.drivers.plant_driver import PlantDriver, Reading
from passafe_services.plant.port_account import PortAccount
from passafe_services.plant.reading_check import OLDEST_NS, ReadingCheck

MOST_LED: Final = 1000
"""Periods through which the model leads at once: after a long stall it must not take the node's time."""


class StateReader:
    """Reads one sample a period; an old reading is led to the present by the model, through the inputs applied since.

    Attributes:
        sample: The newest sample; of a blind robot, where the model is by now.
        is_blind: Whether there is no reading that is young enough to lead from.
        refusal: Why the last reading was refused, in words; empty if it was not.
        true_x: True state of a simulated robot that is read with errors; else empty.
    """

    def __init__(
        self, driver: PlantDriver, plant: SampledPlant, *, x0: Sequence[float], u: Vector, period_ns: int
    ) -> None:
        """Start at x0, before the first reading.

        Args:
            driver: The open driver.
            plant: Model of the robot, stepped with the period.
            x0: State that counts until the first reading, n numbers.
            u: Input until the first one is applied, m numbers.
            period_ns: Period, ns.
        """
        self._driver, self._plant, self._period_ns = driver, plant, period_ns
        self.sample = plant.at(x0)
        self.is_blind = False
        self.true_x: Vector = ()
        self._u = u
        self._read_ns: int | None = None
        self._applied: deque[tuple[int, Vector]] = deque(maxlen=-(-OLDEST_NS // period_ns) + 1)
        self._account: PortAccount | None = None
        self._check = ReadingCheck(plant.system.n, has_own_clock=driver.has_own_clock)

    def read(self, at_ns: int) -> Sample:
        """Return the sample at ``at_ns``; if the robot is blind, the one to which the model leads from the last known.

        Raises:
            DriverError: The driver returned what is no reading of this robot.
        """
        reading = self._driver.read(at_ns)
        if type(reading) is Reading and reading.sample is not None:
            self.is_blind = False
            self.sample = reading.sample
        else:
            self._account_for(self._check.check(reading, at_ns), at_ns)
        return self.sample

    @property
    def refusal(self) -> str:
        """Return why the last reading was refused, in words; empty if it was not."""
        return self._check.refusal

    def apply(self, u: Vector, at_ns: int) -> None:
        """Apply an input from ``at_ns`` on."""
        self._u = u
        self._applied.append((at_ns, u))
        self._driver.apply(u, at_ns)

    def _account_for(self, reading: Reading | None, at_ns: int) -> None:
        self.is_blind = reading is None or at_ns - reading.at_ns > OLDEST_NS
        if reading is None or self.is_blind:
            if self._read_ns is not None:  # so that the law that brakes does not push what has come to rest
                self._move_to(self._led(self.sample.x, self._read_ns, at_ns), at_ns)
            return
        if self._move_to(self._led(reading.x, reading.at_ns, at_ns), at_ns):
            self.true_x = reading.true_x
        else:
            self._check.refuse(f"x: got {reading.x}, allowed a state with finite output and energy")
            self.is_blind = True

    def _move_to(self, x: Vector, at_ns: int) -> bool:
        """Take a state as that of the present; return whether its output and energies are finite."""
        if self._account is None:
            self._account = PortAccount(self._plant)
        elapsed_s = 0.0 if self._read_ns is None else (at_ns - self._read_ns) * 1e-9
        sample = self._account.sample(self.sample.x, self._u, x, elapsed_s)
        is_finite = isfinite(sum((*sample.x, *sample.y, sample.stored_j, sample.energy_in_j)))
        if is_finite:
            self.sample, self._read_ns = sample, at_ns
        return is_finite

    def _led(self, x: Vector, from_ns: int, to_ns: int) -> Vector:
        """Return the state that the model reaches in the whole periods between, rounded to the nearest number."""
        periods = min(round((to_ns - from_ns) / self._period_ns), MOST_LED)
        for period in range(periods, 0, -1):
            begun_ns = to_ns - period * self._period_ns
            u = next((u for since_ns, u in reversed(self._applied) if since_ns <= begun_ns), None)
            if u is not None:
                x = self._plant.advance(x, u).x
        return x
