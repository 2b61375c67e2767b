"""Recovery of what the recorder missed, from the caches of its publishers: they are asked until they answer."""

from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple, Protocol

from passafe_protocol.sequence_window import MissingRange

RETRY_NS: Final = 200_000_000
"""Time between two questions for the same messages, ns."""

ATTEMPTS: Final = 100
"""Questions for the same messages: for longer than a cache reaches back at 1 kHz."""

ANSWERED_NS: Final = 1_000_000_000
"""Time after which an answer is not waited for: where a connection was lost meanwhile, it may never end, ns."""

AT_ONCE: Final = 4096
"""Messages in one question, at most."""

Samples = list[tuple[str, bytes]]
"""Key expressions and wire bytes."""


class AnswerInParts(Protocol):
    """Answer to a question, while it comes in, such as ``CacheAnswer``."""

    has_ended: bool

    def drain(self) -> Samples:
        """Return what came since the last call."""
        ...


class Caches(Protocol):
    """Caches of the publishers, such as ``RecordingReader``."""

    def ask(self, key: str, first: int, last: int) -> AnswerInParts:
        """Ask for some messages of a key's publishers, by their numbers."""
        ...


class _Asked(NamedTuple):
    """Number of questions for some messages, and when they may be asked for again, ns."""

    times: int
    due_ns: int


class _Question(NamedTuple):
    """Question that was asked, and until when its answer is waited for, ns."""

    answer: AnswerInParts
    until_ns: int


class CacheRecovery:
    """Asks for what is missing under each key, one question at a time.

    Args:
        caches: The caches.
    """

    def __init__(self, caches: Caches) -> None:
        self._caches = caches
        self._open: dict[str, _Question] = {}
        self._asked: dict[tuple[str, MissingRange], _Asked] = {}

    def drain(self, now_ns: int) -> Samples:
        """Return what caches answered since the last call; it may contain more than what is missing.

        Args:
            now_ns: Monotonic time, ns.
        """
        found: Samples = []
        for key, question in list(self._open.items()):
            came = question.answer.drain()
            found += came
            if question.answer.has_ended or (not came and now_ns > question.until_ns):
                del self._open[key]
        return found

    def ask(self, missing: Mapping[str, Sequence[MissingRange]], now_ns: int) -> None:
        """Ask for what is missing, where it is due.

        Args:
            missing: What is missing by key expression.
            now_ns: Monotonic time, ns.
        """
        new = _Asked(0, now_ns + RETRY_NS)  # the reader of the bus may still have an answer of its own
        known = {(key, each): self._asked.get((key, each), new) for key, ranges in missing.items() for each in ranges}
        self._asked = known
        for key, ranges in missing.items():
            due = [each for each in ranges if known[key, each].times < ATTEMPTS and now_ns >= known[key, each].due_ns]
            if not due or key in self._open:
                continue
            first = min(due, key=lambda each: known[key, each].times).first
            together = [each for each in due if first <= each.first < first + AT_ONCE]
            for each in together:
                known[key, each] = _Asked(known[key, each].times + 1, now_ns + RETRY_NS)
            last = min(max(each.last for each in together), first + AT_ONCE - 1)
            self._open[key] = _Question(self._caches.ask(key, first, last), now_ns + ANSWERED_NS)

    def expects(self, key: str, missing: MissingRange) -> bool:
        """Return whether messages may still be answered."""
        asked = self._asked.get((key, missing))
        return key in self._open or asked is None or asked.times < ATTEMPTS
