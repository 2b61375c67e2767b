"""One attempt at a decision: one quadratic program, solved and judged."""

from msgspec import Struct

from passafe.decision import Status
from passafe.decision_schema import Assessment


class Attempt(Struct, frozen=True, eq=False, gc=False):
    """Outcome of one quadratic program.

    Attributes:
        status: Grade of its answer; ``UNCERTIFIED`` if none was accepted.
        solver: Whose answer it is.
        is_settled: Whether margins and tangents suit the answer.
        assessment: Of the answer that was evaluated last.
    """

    status: Status
    solver: str
    is_settled: bool
    assessment: Assessment[float]
