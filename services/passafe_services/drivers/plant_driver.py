"""Interface of the drivers that read and move a robot for the plant node."""

from typing import Protocol

from msgspec import Struct
from passafe_protocol.messages import Vector

from passafe.sampled_plant import Sample


class Reading(Struct, frozen=True, gc=False):
    """State of the robot as its driver read it.

    Attributes:
        x: State, n numbers.
        at_ns: Time at which the robot was in that state, clock of the plant node, ns.
        sample: The model's own account of the period before, where the model is the robot; else ``None``, and the
            plant node derives outputs and energies from the states read.
        true_x: True state of a simulated robot, where x is read with errors; else empty.
    """

    x: Vector
    at_ns: int
    sample: Sample | None = None
    true_x: Vector = ()


class PlantDriver(Protocol):
    """The robot, as the plant node sees it: it reads a state, then applies an input, once a period.

    *Rates.* In each period there is one ``read`` and one ``apply``, in this order, at times on a grid of whole periods.
    Neither may block: a driver that waits for an answer takes the node's time, and after 2 s of it the process ends.
    What was applied last stays in force.

    *Clocks.* All times are those of the plant node's clock: the monotonic clock when live, virtual time in lockstep. A
    driver without a clock of its own is a simulation: it moves only when asked for a later time, equal calls give equal
    states, and it is at rest until its first input. One with a clock of its own goes on while nobody asks; it states
    when each state was read, as well as it knows, and it runs live alone.

    *Failure.* No answer, a wrong one or an old one is no exception: ``read`` returns the newest state that is to be
    trusted, with its own time, or ``None`` without any, and the plant node decides when that is too old.
    ``DriverError`` is for what waiting does not mend, and ends the process, as any other exception does. A robot must
    therefore stop by itself when ``apply`` is not called for some periods, and after ``close``.

    Attributes:
        has_own_clock: Whether the robot moves while nobody asks.
    """

    has_own_clock: bool

    def open(self) -> None:
        """Make ready to read and apply; the robot does not move.

        Raises:
            DriverError: There is no such robot.
        """
        ...

    def read(self, at_ns: int) -> Reading | None:
        """Return the newest trusted state: without a clock of its own, the state at exactly ``at_ns``.

        Args:
            at_ns: Time of the period that begins, ns.
        """
        ...

    def apply(self, u: Vector, at_ns: int) -> None:
        """Put an input in force.

        Args:
            u: Input, m numbers, within the limits.
            at_ns: Time from which it is in force, that of the ``read`` before, ns.
        """
        ...

    def close(self) -> None:
        """Let the robot stop and give back what ``open`` took; may be called twice."""
        ...
