"""Driver of another distribution: whatever it raises becomes a ``DriverError``, after it was asked to stop."""

from collections.abc import Callable
from contextlib import suppress
from typing import Any, Final

from passafe_protocol.messages import Vector

from passafe.arguments.numbers import described
from passafe_services.drivers.errors import DriverError
from passafe_services.drivers.plant_driver import PlantDriver, Reading
from passafe_services.foreign_errors import is_ctrl_c, words_of

METHODS: Final = ("open", "read", "apply", "close")


class StrangeDriver:
    """Hands every call on; ``close`` once.

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
        self._calls = 0
        self._method = ""
        self._is_closed = False

    @property
    def call(self) -> tuple[int, str] | None:
        """Number and name of the call that has not returned yet and should at once; ``None`` between calls."""
        calls, method = self._calls, self._method
        return (calls, f"driver {self._name}: {method}") if method else None

    def open(self) -> None:
        """Make ready to read and apply, which may take its time."""
        try:
            self.driver.open()
        except BaseException as error:
            self._close_silently()
            raise _error(self._name, "open", error) from error

    def read(self, at_ns: int) -> Reading | None:
        """Return what it reads; nobody has checked that yet. Only the model accounts for its own energies."""
        reading = self._call("read", lambda: self.driver.read(at_ns))
        if isinstance(reading, Reading) and reading.sample is not None:
            return Reading(reading.x, reading.at_ns, None, reading.true_x)
        return reading  # type: ignore[no-any-return]  # of any type: ReadingCheck says what is none

    def apply(self, u: Vector, at_ns: int) -> None:
        """Put an input in force."""
        self._call("apply", lambda: self.driver.apply(u, at_ns))

    def close(self) -> None:
        """Let the robot stop."""
        if not self._is_closed:
            self._is_closed = True
            self._call("close", self.driver.close)

    def _call(self, method: str, run: Callable[[], Any]) -> Any:  # noqa: ANN401 - a stranger's driver returns anything
        self._calls += 1
        self._method = method
        try:
            return run()
        except BaseException as error:
            self._close_silently()
            raise _error(self._name, method, error) from error
        finally:
            self._method = ""

    def _close_silently(self) -> None:
        """Let the robot stop after an error, which is the one to report."""
        with suppress(DriverError):
            self.close()


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
    except BaseException as error:
        raise _error(name, "made", error) from error
    return StrangeDriver(name, driver)


def _error(name: str, method: str, error: BaseException) -> BaseException:
    """Return what a stranger's code raised, in one line; its own ``DriverError`` and the user's Ctrl-C as they are."""
    if isinstance(error, DriverError) or is_ctrl_c(error):
        return error
    return DriverError(f"{name}: {method}", words_of(error), "no exception but DriverError")
