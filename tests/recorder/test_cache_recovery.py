"""Questions of the recorder to the caches of publishers, for what it missed."""

from passafe_protocol.sequence_window import MissingRange
from passafe_services.recorder.cache_recovery import ANSWERED_NS, AT_ONCE, ATTEMPTS, RETRY_NS, CacheRecovery, Samples

KEY = "passafe/robot/plant/state"
OTHER = "passafe/robot/filter/tick"
LOST = MissingRange(1, 7, 9)


class Answer:
    """Answer that comes bit by bit, and ends with the last bit if it ends at all."""

    def __init__(self, *parts: Samples, ends: bool = True) -> None:
        self.parts = list(parts)
        self.ends = ends
        self.has_ended = False

    def drain(self) -> Samples:
        """Return the next bit."""
        part = self.parts.pop(0) if self.parts else []
        self.has_ended = self.ends and not self.parts
        return part


class Caches:
    """Caches that have these answers, and nothing after them."""

    def __init__(self, *answers: Answer) -> None:
        self.answers = list(answers)
        self.asked: list[tuple[str, int, int]] = []

    def ask(self, key: str, first: int, last: int) -> Answer:
        """Keep the question for the test."""
        self.asked.append((key, first, last))
        return self.answers.pop(0) if self.answers else Answer()


def steps(recovery: CacheRecovery, missing: dict[str, list[MissingRange]], until_ns: int, first_ns: int = 0) -> Samples:
    """Return all that came while a recorder missed the same all the time, 50 times a second."""
    found: Samples = []
    for now_ns in range(first_ns, until_ns, 20_000_000):
        found += recovery.drain(now_ns)
        recovery.ask(missing, now_ns)
    return found


def test_the_bus_has_time_to_answer_first() -> None:
    caches = Caches()
    recovery = CacheRecovery(caches)

    steps(recovery, {KEY: [LOST]}, RETRY_NS)
    assert caches.asked == []
    steps(recovery, {KEY: [LOST]}, RETRY_NS + 1, RETRY_NS)
    assert caches.asked == [(KEY, 7, 9)]


def test_nobodys_answer_is_asked_for_again() -> None:
    caches = Caches(Answer(), Answer(), Answer([(KEY, b"7"), (KEY, b"8")], [(KEY, b"9")]))
    found = steps(CacheRecovery(caches), {KEY: [LOST]}, 3 * RETRY_NS + 60_000_000)

    assert caches.asked == [(KEY, 7, 9)] * 3
    assert found == [(KEY, b"7"), (KEY, b"8"), (KEY, b"9")]


def test_an_answer_without_end_keeps_no_other_back() -> None:
    caches = Caches(Answer([(KEY, b"7")], ends=False), Answer([(KEY, b"8")]))
    found = steps(CacheRecovery(caches), {KEY: [LOST]}, RETRY_NS + ANSWERED_NS + 80_000_000)

    assert caches.asked == [(KEY, 7, 9)] * 2
    assert found == [(KEY, b"7"), (KEY, b"8")]


def test_what_is_found_is_asked_for_no_more() -> None:
    caches = Caches()
    recovery = CacheRecovery(caches)
    steps(recovery, {KEY: [LOST]}, RETRY_NS + 1)

    steps(recovery, {}, 10 * RETRY_NS, RETRY_NS)

    assert caches.asked == [(KEY, 7, 9)]


def test_neighbours_are_asked_for_together() -> None:
    caches = Caches()
    far = 30 + AT_ONCE
    missing = [LOST, MissingRange(1, 20, 29), MissingRange(1, far, far + 2 * AT_ONCE)]
    steps(CacheRecovery(caches), {KEY: missing, OTHER: [MissingRange(2, 1, 1)]}, RETRY_NS + 60_000_000)

    assert caches.asked == [(KEY, 7, 29), (OTHER, 1, 1), (KEY, far, far + AT_ONCE - 1)]


def test_what_nobody_has_is_given_up() -> None:
    caches = Caches()
    recovery = CacheRecovery(caches)
    missing = {KEY: [LOST]}
    assert recovery.expects(KEY, LOST)

    steps(recovery, missing, (ATTEMPTS - 1) * RETRY_NS + 1)
    assert recovery.expects(KEY, LOST)
    steps(recovery, missing, (ATTEMPTS + 10) * RETRY_NS, ATTEMPTS * RETRY_NS)

    assert len(caches.asked) == ATTEMPTS
    assert not recovery.expects(KEY, LOST)
    assert recovery.expects(KEY, MissingRange(1, 11, 12))
