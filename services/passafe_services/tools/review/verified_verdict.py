"""Verdict on a run with the verification of its log, as printed by ``passafe review --verify --json``."""

from typing import Self

from passafe_services.log.verification import Verification
from passafe_services.tools.review.verdict import Verdict


class VerifiedVerdict(Verdict):
    """Verdict on a run whose log was verified.

    Attributes:
        verification: Result of the verification; ``None`` if nobody asked for it.
    """

    verification: Verification | None = None

    @classmethod
    def with_verification(cls, verdict: Verdict, verification: Verification) -> Self:
        """Return a verdict with the verification of its log."""
        return cls(**{name: getattr(verdict, name) for name in type(verdict).model_fields}, verification=verification)
