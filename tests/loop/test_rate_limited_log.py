"""RateLimitedLog in words."""

import pytest
from passafe_protocol.messages import Event
from passafe_services.loop.rate_limited_log import PERIOD_NS, RateLimitedLog


def test_repeated_messages_are_logged_once_and_counted(capsys: pytest.CaptureFixture[str]) -> None:
    log = RateLimitedLog()
    assert log.report("garbage", "warning", "got garbage", 0) == Event("warning", "got garbage")
    for now_ns in (1, 2, PERIOD_NS - 1):
        assert log.report("garbage", "warning", "got garbage", now_ns) is None
    reported = log.report("garbage", "warning", "got garbage", PERIOD_NS)
    assert reported == Event("warning", "got garbage (and 3 more like it)")
    assert log.report("garbage", "warning", "got garbage", 2 * PERIOD_NS) == Event("warning", "got garbage")
    assert capsys.readouterr().err.splitlines() == [
        "warning: got garbage",
        "warning: got garbage (and 3 more like it)",
        "warning: got garbage",
    ]


def test_kinds_have_limits_of_their_own() -> None:
    log = RateLimitedLog()
    assert log.report("a", "info", "first", 0) is not None
    assert log.report("b", "error", "second", 0) == Event("error", "second")
