"""Errors of somebody's code: in one line whatever they are, and no Ctrl-C where there was none."""

import signal

import pytest
from passafe_services.foreign_errors import is_ctrl_c, words_of


class Mute(Exception):  # noqa: N818 - named as strangers name theirs
    def __str__(self) -> str:
        raise ValueError("no words")


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (RuntimeError("two\nlines"), "RuntimeError in line 3: two lines"),
        (MemoryError(), "MemoryError in line 3"),
        (Mute(), "Mute in line 3: its text raises ValueError"),
        (SystemExit(0), "SystemExit in line 3: 0"),
    ],
)
def test_any_error_is_one_line(error: BaseException, words: str) -> None:
    assert words_of(error, " in line 3") == words


def test_interrupt_that_code_raises_is_no_ctrl_c() -> None:
    with pytest.raises(KeyboardInterrupt) as caught:
        raise KeyboardInterrupt

    assert not is_ctrl_c(caught.value)


def test_interrupt_by_a_signal_is_ctrl_c() -> None:
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt) as caught:
            signal.raise_signal(signal.SIGINT)
    finally:
        signal.signal(signal.SIGINT, before)

    assert is_ctrl_c(caught.value)
    assert not is_ctrl_c(SystemExit(1))
