"""Errors that the code of others raises: in words, and distinguished from the user's Ctrl-C."""

import dis
from typing import Final

_RAISE: Final = dis.opmap["RAISE_VARARGS"]


def words_of(error: BaseException, where: str = "") -> str:
    """Return what somebody's code raised, in one line.

    Args:
        error: The error; its own text may raise, too.
        where: Which line of that code raised it, in words that begin with a space; empty if unknown.
    """
    try:
        text = " ".join(str(error).split())
    except Exception as broken:  # noqa: BLE001 - the method is as strange as the rest of that code
        text = f"its text raises {type(broken).__name__}"
    name = type(error).__name__
    return f"{name}{where}: {text}" if text else f"{name}{where}"


def is_ctrl_c(error: BaseException) -> bool:
    """Return whether an error is the user's Ctrl-C, and no ``raise KeyboardInterrupt`` of somebody's code.

    The interpreter raises that of a signal between two instructions; a ``raise`` is an instruction.
    """
    trace = error.__traceback__
    if not isinstance(error, KeyboardInterrupt) or trace is None:
        return False
    while trace.tb_next is not None:
        trace = trace.tb_next
    return trace.tb_frame.f_code.co_code[trace.tb_lasti] != _RAISE
