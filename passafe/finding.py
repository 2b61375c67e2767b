"""Findings of a check of a design before anything moves: what, with which value, and what to change."""

from dataclasses import dataclass
from enum import Enum


class Severity(Enum):
    """Weight of a finding."""

    REFUSED = "refused"
    """The design cannot be used."""

    WARNING = "warning"
    """A guarantee does not hold, or not everywhere."""

    NOTE = "note"
    """A value to know; nothing is wrong."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Finding:
    """One finding.

    Attributes:
        severity: How much it matters.
        topic: What was looked at, for example ``relative degree``.
        subject: Of which part, for example ``barrier 'disk'``.
        found: What was found, with its value and unit.
        advice: What to change; empty where nothing has to be.
    """

    severity: Severity
    topic: str
    subject: str
    found: str
    advice: str = ""

    def __str__(self) -> str:
        """Return it in one line."""
        return f"{self.topic}, {self.subject}: {self.found}" + (f"; {self.advice}" if self.advice else "")


def worst(findings: "tuple[Finding, ...]") -> Severity:
    """Return the worst severity of some findings, ``NOTE`` if there are none."""
    found = {finding.severity for finding in findings}
    return next((severity for severity in Severity if severity in found), Severity.NOTE)
