"""A console for lockstep loops: presses and clears the emergency stop at given times."""

from collections.abc import Sequence

from passafe_protocol.messages import EmergencyStop, PlantState, Received, StopClear
from passafe_protocol.stop_request import StopRequest, press_id
from passafe_protocol.topics import CLEAR, STATE, STOP, Topic
from passafe_services.node import Outgoing


class StopConsole:
    """Presses at the times of even index and clears at those of odd index, each until a plant state acknowledges it."""

    name = "console"
    subscribes: tuple[Topic, ...] = (STATE,)

    def __init__(self, at_ns: Sequence[int]) -> None:
        """Start before the first time.

        Args:
            at_ns: Monotonic times, ns, growing.
        """
        self._at_ns = list(at_ns)
        self._done = 0
        self._request: StopRequest | None = None
        self._state: PlantState | None = None

    def step(self, now_ns: int, inbox: Sequence[Received]) -> Sequence[Outgoing]:
        """As ``Node.step``."""
        for received in inbox:
            if isinstance(received.body, PlantState):
                self._state = received.body
                if self._request is not None:
                    self._request.observe(received.body)
        if (self._request is None or self._request.is_done) and self._at_ns and now_ns >= self._at_ns[0]:
            self._begin()
        body = None if self._request is None else self._request.due(now_ns)
        if body is None:
            return ()
        return ((STOP if isinstance(body, EmergencyStop) else CLEAR, body),)

    def _begin(self) -> None:
        state = self._state
        if self._done % 2 == 0:
            self._request = StopRequest(EmergencyStop(press_id(99, self._done + 1), "test"))
        elif state is not None and state.stop:
            self._request = StopRequest(StopClear(state.stop, "test"))
        else:
            return
        self._done += 1
        del self._at_ns[0]
