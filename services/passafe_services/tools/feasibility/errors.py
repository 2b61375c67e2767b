"""Errors of the feasibility atlas.

* ``FeasibilityError``: a map that cannot be made, because of what it was asked for
"""


class FeasibilityError(Exception):
    """A map that cannot be made, because of what it was asked for.

    Attributes:
        field: What is wrong.
        got: What it is.
        allowed: What is allowed, in words.
    """

    def __init__(self, field: str, got: object, allowed: str) -> None:
        self.field = field
        self.got = got
        self.allowed = allowed
        super().__init__(f"{field}: got {got}, allowed {allowed}")
