"""Session that presses and clears the emergency stop of a running system."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final

from passafe_protocol.codec import decode
from passafe_protocol.errors import ProtocolError
from passafe_protocol.keys import DEFAULT_ROBOT
from passafe_protocol.messages import EmergencyStop, PlantState, StopClear
from passafe_protocol.stop_request import StopRequest, press_id
from passafe_protocol.topics import CLEAR, STATE, STOP

from passafe_services.loop.bus import Bus, open_bus
from passafe_services.loop.errors import PlantSilentError, StopPressedAgainError
from passafe_services.loop.outlet import Outlet
from passafe_services.loop.router_endpoint import RouterEndpoint

SOURCE: Final = "console"
ANSWER_S: Final = 5.0
"""Time to wait for a plant state that acknowledges a request."""

_POLL_S: Final = 0.001


class StopConsole:
    """Presses and clears the emergency stop; created by ``open_stop_console``."""

    def __init__(self, bus: Bus, *, epoch: int, answer_s: float) -> None:
        self._reader = bus.reader(STATE)
        self._outlet = Outlet(bus, SOURCE, epoch)
        self._answer_s = answer_s
        self._presses = 0

    def press(self, reason: str) -> PlantState:
        """Press the emergency stop until the plant has latched it; return the state that says so.

        Raises:
            PlantSilentError: No plant acknowledged it within the timeout.
        """
        self._presses += 1
        return self._repeat(StopRequest(EmergencyStop(press_id(self._outlet.epoch, self._presses), reason)))

    def clear(self, reason: str) -> PlantState | None:
        """Clear the stop that is latched now; return the state that shows it cleared, ``None`` if none was latched.

        Raises:
            PlantSilentError: No plant acknowledged it within the timeout.
            StopPressedAgainError: Somebody pressed it again meanwhile: it is still latched.
        """
        before = self._newest_state(lambda _: True, lambda: None)
        if not before.stop:
            return None
        after = self._repeat(StopRequest(StopClear(before.stop, reason)))
        if after.stop:
            raise StopPressedAgainError(after.stop_source)
        return after

    def _repeat(self, request: StopRequest) -> PlantState:
        topic = STOP if isinstance(request.body, EmergencyStop) else CLEAR

        def send() -> None:
            now_ns = time.monotonic_ns()
            body = request.due(now_ns)
            if body is not None:
                self._outlet.publish(topic, body, scheduled_ns=now_ns, started_ns=now_ns)

        def is_done(state: PlantState) -> bool:
            request.observe(state)
            return request.is_done

        return self._newest_state(is_done, send)

    def _newest_state(self, is_wanted: Callable[[PlantState], bool], work: Callable[[], None]) -> PlantState:
        """Return the first newest state that is wanted; do the work while it does not come."""
        self._reader.drain()  # what came before is no answer
        end_s = time.monotonic() + self._answer_s
        while time.monotonic() < end_s:
            work()
            time.sleep(_POLL_S)
            for data in self._reader.drain()[-1:]:
                try:
                    _, state = decode(STATE, data)
                except ProtocolError:
                    continue  # damaged or of another version: no answer
                if isinstance(state, PlantState) and is_wanted(state):
                    return state
        raise PlantSilentError(self._answer_s)


@contextmanager
def open_stop_console(
    endpoint: RouterEndpoint, *, robot: str = DEFAULT_ROBOT, answer_s: float = ANSWER_S
) -> Iterator[StopConsole]:
    """Open a session with the plant of a system and close it at the end of the block.

    Args:
        endpoint: Address of the router.
        robot: Robot to stop.
        answer_s: Timeout of each answer, s.

    Raises:
        BusError: There is no router.
    """
    with open_bus(endpoint, robot=robot) as bus:
        yield StopConsole(bus, epoch=time.time_ns(), answer_s=answer_s)
