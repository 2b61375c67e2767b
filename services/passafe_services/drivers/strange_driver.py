"""Driver of another distribution: whatever it raises becomes a ``DriverError``, after it was asked to stop."""

from collections.abc import Callable
from contextlib import suppress
from typing import Any, Final

from passafe_protocol.messages import Vector

from passafe.arguments.numbers import described
from passafe_services.drivers.errors import DriverError
from passafe_services.drivers.plant_driver import PlantDriver, Reading

METHODS: Final = ("open", "read", "apply", "close")


class StrangeDriver:
    """Hands every call on.

    Attributes:
        has_own_clock: That of the driver.
    """

    def __init__(self, name: str, driver: PlantDriver) -> None:
        """Check that a driver has what is expected of one.

        Args:
            name: Its name, for people.
            driver: What its entry point returned.

        Raises:
            DriverError: A method is missing, or ``has_own_clock`` is.
        """
        missing = [method for method in METHODS if not callable(getattr(driver, method, None))]
        clock = getattr(driver, "has_own_clock", None)
        missing += [] if isinstance(clock, bool) else ["has_own_clock"]
        if missing:
            got = f"{described(driver)} without {', '.join(missing)}"
            raise DriverError(name, got, f"{', '.join(METHODS)}, and has_own_clock as a bool")
        self._name, self.driver = name, driver
        self.has_own_clock = bool(clock)

    def open(self) -> None:
        """Make ready to read and apply."""
        self._call("open", self.driver.open)

    def read(self, at_ns: int) -> Reading | None:
        """Return what it reads; nobody has checked that yet."""
        return self._call("read", lambda: self.driver.read(at_ns))  # type: ignore[no-any-return]  # see ReadingCheck

    def apply(self, u: Vector, at_ns: int) -> None:
        """Put an input in force."""
        self._call("apply", lambda: self.driver.apply(u, at_ns))

    def close(self) -> None:
        """Let the robot stop."""
        try:
            self.driver.close()
        except Exception as error:
            raise _error(self._name, "close", error) from error

    def _call(self, method: str, run: Callable[[], Any]) -> Any:  # noqa: ANN401 - a stranger's driver returns anything
        try:
            return run()
        except Exception as error:
            with suppress(Exception):  # the first error is the one to report
                self.driver.close()
            raise _error(self._name, method, error) from error


def made(name: str, make: Callable[[], PlantDriver]) -> StrangeDriver:
    """Return the driver that an entry point makes.

    Args:
        name: Its name.
        make: Loads it and calls it.

    Raises:
        DriverError: It cannot be loaded, raises, or makes no driver.
    """
    try:
        driver = make()
    except Exception as error:
        raise _error(name, "made", error) from error
    return StrangeDriver(name, driver)


def _error(name: str, method: str, error: Exception) -> DriverError:
    """Return what a stranger's code raised, in one line; its own ``DriverError`` as it is."""
    if isinstance(error, DriverError):
        return error
    words = " ".join(f"{type(error).__name__}: {error}".split())
    return DriverError(f"{name}: {method}", words, "no exception but DriverError")
