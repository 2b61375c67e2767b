"""Keys that drive the robot and their decoding from terminal input."""

from enum import Enum
from typing import Final


class Key(Enum):
    """Meaning of a key press.

    Diagonals have their own keys because a terminal repeats only the key pressed last: two arrows held together look
    like one.
    """

    LEFT = "left"
    RIGHT = "right"
    UP = "up"
    DOWN = "down"
    UP_LEFT = "up-left"
    UP_RIGHT = "up-right"
    DOWN_LEFT = "down-left"
    DOWN_RIGHT = "down-right"
    STOP = "stop"
    EMERGENCY_STOP = "emergency stop"
    TAKE_OVER = "take over"
    QUIT = "quit"


DIRECTIONS: Final[dict[Key, tuple[float, float]]] = {
    Key.LEFT: (-1.0, 0.0),
    Key.RIGHT: (1.0, 0.0),
    Key.UP: (0.0, 1.0),
    Key.DOWN: (0.0, -1.0),
    Key.UP_LEFT: (-1.0, 1.0),
    Key.UP_RIGHT: (1.0, 1.0),
    Key.DOWN_LEFT: (-1.0, -1.0),
    Key.DOWN_RIGHT: (1.0, -1.0),
}
"""Direction of each key that moves the robot, in the plane of the first two inputs; not normalized."""

_LETTERS: Final = {
    **dict.fromkeys(b"aAhH", Key.LEFT),
    **dict.fromkeys(b"dDlL", Key.RIGHT),
    **dict.fromkeys(b"wWkK", Key.UP),
    **dict.fromkeys(b"sSjJ", Key.DOWN),
    **dict.fromkeys(b"yY", Key.UP_LEFT),
    **dict.fromkeys(b"uU", Key.UP_RIGHT),
    **dict.fromkeys(b"bB", Key.DOWN_LEFT),
    **dict.fromkeys(b"nN", Key.DOWN_RIGHT),
    **dict.fromkeys(b" ", Key.STOP),
    **dict.fromkeys(b"xX", Key.EMERGENCY_STOP),
    **dict.fromkeys(b"tT", Key.TAKE_OVER),
    **dict.fromkeys(b"qQ\x03\x04", Key.QUIT),  # also Ctrl-C and Ctrl-D if the terminal passes them on
}
_ARROWS: Final = {ord("A"): Key.UP, ord("B"): Key.DOWN, ord("C"): Key.RIGHT, ord("D"): Key.LEFT}

_ESCAPE: Final = 0x1B
_CONTROL_SEQUENCE: Final = ord("[")
_SINGLE_SHIFT: Final = ord("O")
_FINAL_BYTES: Final = range(0x40, 0x7F)
_INNER_BYTES: Final = range(0x20, 0x40)


class KeyReader:
    """Decodes terminal input into keys; a sequence may be split between two reads.

    Arrows are sent as ``ESC [ A`` … ``D``, with numbers before the letter when shift or control is held, or as
    ``ESC O A`` … ``D`` in application mode. Other sequences and letters are ignored.
    """

    def __init__(self) -> None:
        self._introducer: int | None = None  # None, ESC, or the byte after it while a sequence is open

    def feed(self, data: bytes) -> list[Key]:
        """Return the keys that ``data`` completes, in order."""
        keys = []
        for byte in data:
            key = self._decode(byte)
            if key is not None:
                keys.append(key)
        return keys

    def _decode(self, byte: int) -> Key | None:
        introducer = self._introducer
        if byte == _ESCAPE:
            self._introducer = _ESCAPE
            return None
        if introducer == _ESCAPE and byte in (_CONTROL_SEQUENCE, _SINGLE_SHIFT):
            self._introducer = byte
            return None
        if introducer == _CONTROL_SEQUENCE and byte in _INNER_BYTES:
            return None
        self._introducer = None
        if introducer in (_CONTROL_SEQUENCE, _SINGLE_SHIFT) and byte in _FINAL_BYTES:
            return _ARROWS.get(byte)
        return _LETTERS.get(byte)
