"""The newest command of an operator is echoed with the time since it arrived."""

from typing import cast

from closed_form import MS
from passafe_dashboard.live.command_echo import QUEUE, CommandEcho
from passafe_protocol.codec import encode
from passafe_protocol.messages import Header, OperatorCommand
from passafe_protocol.topics import Topic
from passafe_services.loop.bus import Bus


class Arrivals:
    """A bus, and its reader, that delivers what a test puts in."""

    def __init__(self) -> None:
        self.waiting: list[bytes] = []

    def reader(self, topic: Topic) -> "Arrivals":
        """Return the reader."""
        assert topic.queue == QUEUE
        return self

    def drain(self) -> list[bytes]:
        """Deliver."""
        arrived, self.waiting = self.waiting, []
        return arrived


def command(epoch: int, scheduled_ns: int) -> bytes:
    header = Header("operator", epoch, 0, scheduled_ns, 0, 0, 0)
    return encode(header, OperatorCommand(u_h=(0.0,), u_h_rate=(), enabled=True, device="lag"))


def test_the_newest_is_echoed_with_its_age() -> None:
    bus = Arrivals()
    echo = CommandEcho(cast("Bus", bus))
    assert echo.newest(MS) == (0, 0, 0)

    bus.waiting = [command(7, 3), command(8, 4)]
    assert echo.newest(2 * MS) == (8, 4, 0)
    assert echo.newest(5 * MS) == (8, 4, 3 * MS)


def test_what_is_no_command_is_passed_over() -> None:
    bus = Arrivals()
    echo = CommandEcho(cast("Bus", bus))
    bus.waiting = [command(7, 3)]
    echo.newest(MS)
    bus.waiting = [b"none"]
    assert echo.newest(2 * MS) == (7, 3, MS)
