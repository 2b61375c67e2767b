"""One property of a run: whether it holds, its worst value and what is allowed."""

from pydantic import BaseModel, ConfigDict

from passafe_services.tools.review.extremum import Extremum


class Violation(BaseModel):
    """One violation of a property.

    Attributes:
        at_s: Plant time, s; ``None`` if it has none.
        text: The message concerned and what is wrong with it.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    at_s: float | None
    text: str


class Property(BaseModel):
    """Property of a run and whether it holds.

    Attributes:
        holds: Whether it holds; ``None`` if the log has no data for it.
        required: Whether the scenario's mode requires it; if not, it is reported but does not affect the verdict.
        worst: Worst value of the quantity in ``requirement``.
        at_s: Plant time of the worst value, s; for counts, of the first occurrence.
        requirement: The requirement in words.
        allowed: Values of that quantity with which it holds, tolerance included.
        note: What a reader of the verdict has to know; empty if there is nothing to add.
        count: Number of violations; ``None`` for a property of a worst value alone.
        violations: The first of them.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    holds: bool | None
    required: bool
    worst: float | None
    at_s: float | None
    requirement: str
    allowed: str = ""
    note: str = ""
    count: int | None = None
    violations: tuple[Violation, ...] = ()


def at_least(worst: Extremum | None, limit: float, *, required: bool, what: str) -> Property:
    """Return the property that a quantity is never below a limit, from its smallest value."""
    holds = None if worst is None else worst.value >= limit
    return _bound(worst, f"≥ {limit:g}", what, holds=holds, required=required)


def at_most(worst: Extremum | None, limit: float, *, required: bool, what: str) -> Property:
    """Return the property that a quantity is never above a limit, from its largest value."""
    holds = None if worst is None else worst.value <= limit
    return _bound(worst, f"≤ {limit:g}", what, holds=holds, required=required)


def _bound(worst: Extremum | None, allowed: str, what: str, *, holds: bool | None, required: bool) -> Property:
    value, at_s = (None, None) if worst is None else worst
    return Property(
        holds=holds, required=required, worst=value, at_s=at_s, requirement=f"{what} {allowed}", allowed=allowed
    )
