"""Sets of what a robot may do otherwise than its model: parameters, disturbance, state error and input error."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite

from passafe.arguments.numbers import described, numbers
from passafe.arguments.ranges import require_not_negative
from passafe.errors import DesignError
from passafe.system import System


@dataclass(frozen=True, kw_only=True, slots=True)
class Uncertainty:
    """Sets for whose every member a design's rows hold (``docs/theory.md``, section 13).

    The true plant is ẋ = f(x, u + du, θ) + w, and the filter knows x up to an error e: parameters θ are constant, all
    the rest may change at any time.

    Attributes:
        parameters: Interval (low, high) of parameters by name, which contains the nominal value.
        disturbance: Largest |wᵢ| of every state's rate, n numbers, state units per second; empty for none.
        state_error: Largest |eᵢ| of every state, n numbers, state units: noise, quantisation; empty for none.
        input_error: Largest |duᵢ| of every input, m numbers, units of u; empty for none.
        actuator_lag_s: Largest first-order lag between the input sent and the one that acts, s. It makes an input error
            of as much times the rate limit, which the design must have.
    """

    parameters: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    disturbance: Sequence[float] = ()
    state_error: Sequence[float] = ()
    input_error: Sequence[float] = ()
    actuator_lag_s: float = 0.0

    def __post_init__(self) -> None:
        """Take the numbers in every form that is allowed, and refuse what is no set."""
        if not isinstance(self.parameters, Mapping):
            raise DesignError("uncertainty parameters", described(self.parameters), "intervals by name")
        intervals = {name: _interval(name, given) for name, given in self.parameters.items()}
        object.__setattr__(self, "parameters", intervals)
        for part in ("disturbance", "state_error", "input_error"):
            object.__setattr__(self, part, _bounds(part, getattr(self, part)))
        require_not_negative("uncertainty actuator_lag_s", self.actuator_lag_s, "s")
        object.__setattr__(self, "actuator_lag_s", float(self.actuator_lag_s))

    def require_fits(self, system: System) -> None:
        """Refuse sets that are not of this system.

        Args:
            system: The plant.

        Raises:
            DesignError: A parameter that it does not have, an interval without the nominal value, or bounds of another
                number than it has states or inputs.
        """
        nominal = {parameter.name: parameter.value for parameter in system.parameters}
        for name, (low, high) in self.parameters.items():
            part = f"uncertainty parameters {name!r}"
            if name not in nominal:
                raise DesignError(part, "a parameter that the system does not have", f"names among {sorted(nominal)}")
            if not low <= nominal[name] <= high:
                raise DesignError(part, f"({low:g}, {high:g})", f"an interval that contains {nominal[name]:g}")
        for part, size in (("disturbance", system.n), ("state_error", system.n), ("input_error", system.m)):
            given = getattr(self, part)
            if given and len(given) != size:
                raise DesignError(f"uncertainty {part}", f"{len(given)} numbers", f"{size} numbers, or none")


def _interval(name: str, given: object) -> tuple[float, float]:
    found = numbers(f"uncertainty parameters {name!r}", given, "two numbers, low and high")
    if len(found) != 2 or not all(map(isfinite, found)) or found[0] > found[1]:  # noqa: PLR2004 - low and high
        raise DesignError(f"uncertainty parameters {name!r}", described(given), "two finite numbers, low ≤ high")
    return found[0], found[1]


def _bounds(part: str, given: object) -> tuple[float, ...]:
    found = numbers(f"uncertainty {part}", given)
    if not all(isfinite(bound) and bound >= 0 for bound in found):
        raise DesignError(f"uncertainty {part}", described(given), "finite numbers, zero or more")
    return found
