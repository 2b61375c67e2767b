"""LogAgreement of a log with what can be recomputed from it: differences counted, the first ones listed."""

from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import NDArray

from passafe_services.tools.review.plant_evaluator import FloatArray
from passafe_services.tools.review.property import Property, Violation

MOST_LISTED: Final = 20
"""Differences that a property lists."""


class LogAgreement:
    """Differences of one kind, as they are found.

    Args:
        requirement: What has to agree, in words.
    """

    def __init__(self, requirement: str) -> None:
        self._requirement = requirement
        self._listed: list[Violation] = []
        self._counts: dict[str, int] = {}
        self._worst = 0.0
        self.compared = 0
        self.left_out = 0

    def compare(
        self, what: str, difference: FloatArray, at_s: FloatArray, allowed: float, name: Callable[[int], str]
    ) -> NDArray[np.bool_]:
        """Note the differences beyond what is allowed; a NaN is one. Return which, shape (N,).

        Args:
            what: The quantity, in words.
            difference: Differences, shape (N,).
            at_s: Plant time of each, s, shape (N,).
            allowed: Largest difference that rounding may leave.
            name: Names the message of a column.
        """
        self.compared += difference.size
        beyond: NDArray[np.bool_] = ~(difference <= allowed)
        rows = np.flatnonzero(beyond)
        if rows.size:
            self._counts[what] = self._counts.get(what, 0) + rows.size
            self._worst = max(self._worst, float(np.nan_to_num(difference[rows], nan=np.inf).max()))
            for row in rows[: MOST_LISTED - len(self._listed)].tolist():
                text = f"{name(row)}: {what} differs by {difference[row]:.3g}"
                self._listed.append(Violation(at_s=float(at_s[row]), text=text))
        return beyond

    def refute(self, what: str, wrong: NDArray[np.bool_], at_s: FloatArray, name: Callable[[int], str]) -> None:
        """Note messages that cannot be so.

        Args:
            what: What they say and cannot be, in words.
            wrong: Which they are, shape (N,).
            at_s: Plant time of each, s, shape (N,).
            name: Names the message of a column.
        """
        self.compared += wrong.size
        rows = np.flatnonzero(wrong)
        if rows.size:
            self._counts[what] = self._counts.get(what, 0) + rows.size
        for row in rows[: MOST_LISTED - len(self._listed)].tolist():
            self._listed.append(Violation(at_s=float(at_s[row]), text=f"{name(row)}: {what}"))

    def note(self, what: str, text: str, at_s: float | None = None) -> None:
        """Note one difference that is not a number."""
        self._counts[what] = self._counts.get(what, 0) + 1
        if len(self._listed) < MOST_LISTED:
            self._listed.append(Violation(at_s=at_s, text=text))

    def property(self, *, required: bool = True) -> Property:
        """Return the property that nothing differs; unknown and not required if nothing was compared."""
        count = sum(self._counts.values())
        kinds = ", ".join(f"{what} {number}" for what, number in self._counts.items())
        first = self._listed[0] if self._listed else None
        said = [] if first is None else [f"{count} differences ({kinds}), first: {first.text}"]
        if self.left_out:
            said.append(f"{self.compared} of {self.compared + self.left_out} logged numbers could be recomputed")
        return Property(
            holds=count == 0 if self.compared or count else None,
            required=required and bool(self.compared or count),
            worst=float(count) if self.compared or count else None,
            at_s=None if first is None else first.at_s,
            requirement=self._requirement,
            allowed="= 0",
            note="; ".join(said),
            count=count,
            violations=tuple(self._listed),
        )


def relative(found: FloatArray, expected: FloatArray) -> FloatArray:
    """Return the largest difference of each column, each relative to 1 + the number expected, shape (N,)."""
    if not expected.shape[0]:
        return np.zeros(expected.shape[1])
    with np.errstate(invalid="ignore", over="ignore"):
        difference: FloatArray = (np.abs(found - expected) / (1 + np.abs(expected))).max(axis=0)
    return difference
