"""Errors of the command line.

* ``OptionError``: an option whose value cannot be used here
"""


class OptionError(Exception):
    """An option whose value cannot be used here.

    Attributes:
        option: Its name, as typed.
        got: What it was given.
        allowed: What is allowed, in words.
    """

    def __init__(self, option: str, got: object, allowed: str) -> None:
        self.option = option
        self.got = got
        self.allowed = allowed
        super().__init__(f"{option}: got {got}, allowed {allowed}")
