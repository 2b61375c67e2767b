"""Errors of checks; the tree of all errors is in ``passafe.errors``."""

from passafe.errors import NotAllowedError
from passafe.finding import Finding


class UnusableScenarioError(NotAllowedError):
    """A scenario that a check refuses.

    Attributes:
        finding: Why.
    """

    def __init__(self, scenario: str, finding: Finding) -> None:
        self.finding = finding
        self.prefix = f"scenario {scenario}: "
        super().__init__(f"{finding.topic}, {finding.subject}", finding.found, finding.advice)
