"""Shares of a run by what became of the operator's command."""

from damped_point_run import tick
from passafe_protocol.messages import CommandState, FilterTick
from passafe_services.tools.review.command_use import WORDS, CommandUse


def ticks_of(**counts: int) -> list[FilterTick]:
    return [tick(k, (0.0, 0.0), command_state=state) for state, count in counts.items() for k in range(count)]


def test_shares_in_words_begin_with_what_counted() -> None:
    use = CommandUse.of(ticks_of(delayed=50, counts=30, resumes=10, none=10))

    assert use.shares == {"counts": 0.3, "resumes": 0.1, "delayed": 0.5, "none": 0.1}
    assert use.text == (
        "counted 30 %, ramped in after a stale stretch 10 %, too old when they arrived 50 %, none yet 10 %"
    )


def test_one_tick_of_many_is_neither_nothing_nor_rounded_away() -> None:
    assert CommandUse.of(ticks_of(counts=2000, silent=1)).text == "counted > 99.9 %, no newer one came < 0.1 %"
    assert CommandUse.of(ticks_of(counts=5)).text == "counted 100 %"


def test_log_that_does_not_tell_has_no_shares() -> None:
    assert CommandUse.of(ticks_of(**{"": 3})) == CommandUse(shares={}, text="not in this log")


def test_every_state_has_words() -> None:
    assert set(WORDS) == set(CommandState)
