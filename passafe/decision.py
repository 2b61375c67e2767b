"""One decision of the filter, the attempts that lead to it, and the evidence for it."""

from collections.abc import Iterable
from enum import IntEnum
from typing import Final

from msgspec import Struct

from passafe.decision_schema import Answer, Assessment, Evaluation, Program, Request
from passafe.numerics.workspace import Array, BlockLayout


class Status(IntEnum):
    """Outcome of one decision. Its numbers are those on the wire, where 6 is taken, and in no order."""

    PASSED = 1
    """u⁺ = u_ref: no row stood in the way; v = 0 unless the input bound did."""

    MODIFIED = 2
    """v ≠ 0, every row kept."""

    RELAXED = 3
    """Every hard row kept, the passivity row relaxed by the slack."""

    UNCERTIFIED = 4
    """No answer passed the certificate, or a search of all inputs ended without a result: u is the fail-safe law's,
    within the limits."""

    INFEASIBLE = 5
    """Proven: no input within the limits keeps the hard rows, margins left aside. u loses no barrier earlier than the
    backup law, nor by more: a fallback."""

    AT_SAMPLES = 7
    """The hard rows can be kept at the sample, but no admissible input is known to keep them with their margin for the
    whole period, nor any whose course is proven to keep every barrier: a fallback. For a family of plants also: the one
    in the middle and those at the ends can keep them at the sample, but no input is known with which all members do."""

    BACKUP = 8
    """What is sent is judged by the backup law's course instead of by rows with margins. In the protected set every
    barrier is proven to be kept on that course: the margins cannot be kept, but the barriers can; or a gatekeeper
    refuses an answer, or finds that no input keeps the rows. Outside of it an answer keeps the rows, but the backup law
    loses barriers later, or by less. No fallback."""

    @property
    def is_fallback(self) -> bool:
        """True if a hard row is violated, or may be."""
        return self in FALLBACKS

    @property
    def is_certified(self) -> bool:
        """True if a program's answer passed the certificate; ``Decision.solver`` says whether it is what is sent."""
        return self in CERTIFIED


ANSWERS: Final = (Status.PASSED, Status.MODIFIED, Status.RELAXED)
"""Outcomes in which u is the certified answer that keeps every hard row with its margin."""

FALLBACKS: Final = (Status.AT_SAMPLES, Status.UNCERTIFIED, Status.INFEASIBLE)
"""Outcomes in which a hard row is violated, or may be."""

CERTIFIED: Final = (*ANSWERS, Status.INFEASIBLE)
"""Outcomes in which a program's answer passed the certificate, with hard rows relaxed or not."""


_MEANINGS: Final = {
    Status.PASSED: "nothing stood in the way",
    Status.MODIFIED: "changed so that every row is kept",
    Status.RELAXED: "every hard row is kept, the passivity row is relaxed by the slack",
    Status.UNCERTIFIED: "no answer was certified, the fail-safe law's input is sent: a fallback",
    Status.INFEASIBLE: "proven that no input within the limits keeps the hard rows: a fallback",
    Status.AT_SAMPLES: "the hard rows can be kept at the sample, for the whole period it is not known: a fallback",
    Status.BACKUP: "judged by the course of the backup law instead of by rows",
}

_NEGLIGIBLE: Final = 1e-9
"""Size below which a number is printed as 0."""


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


class Decision(Struct, frozen=True, eq=False, gc=False):
    """One decision. Vectors are views of one block of numbers, copied once, never written again.

    A msgspec struct: a frozen dataclass costs ten times as much to make (``docs/decisions/0003-msgspec-structs.md``).

    Attributes:
        block: Everything that was computed, shape (layout.size,).
        layout: Where each part lies in ``block``.
        status: Outcome.
        solver: Whose input is sent: a solver's, ``none`` where v = 0 is optimal by inspection, or what was preferred
            to an answer: ``backup``, ``deepest`` or ``between`` (``passafe.filter``).
        assessment: Numbers by which the answer was accepted and graded.
        u: The input to hold over the next period, within the bound and finite, m numbers.
    """

    block: Array
    layout: BlockLayout
    status: Status
    solver: str
    assessment: Assessment[float]
    u: tuple[float, ...]

    def __str__(self) -> str:
        """Return the decision as a person reads it: outcome, input, and what it was closest to."""
        enforced = self.part("eps").size
        barriers = f"lowest ψ {_number(self.assessment.lowest_psi)}" if enforced else "none enforced"
        asked = f"nominal {_numbers(self.u_nominal)}, operator {_numbers(self.request.u_h)}"
        return "\n".join(
            [
                f"{self.status.name}: {_MEANINGS[self.status]}",
                f"  input     {_numbers(self.u)} ({asked})",
                f"  barriers  {barriers}",
                f"  power     margin {_number(self.power_margin)} W, slack {_number(self.slack)} W",
                f"  solver    {self.solver}",
            ]
        )

    def __repr__(self) -> str:
        """Return the decision in one line; its numbers are in ``part`` and ``view``."""
        return f"Decision(status={self.status.name}, u={self.u}, solver={self.solver!r})"

    def part(self, name: str) -> Array:
        """Return a part by name, flat: see ``passafe.decision_schema`` for the names and shapes."""
        return self.block[self.layout.parts[name]]

    def view(self, name: str) -> Array:
        """Return a part by name in its shape."""
        return self.layout.view(self.block, name)

    @property
    def request(self) -> Request[Array]:
        """Arguments of the decision."""
        return Request.of(self.view)

    @property
    def program(self) -> Program[Array]:
        """The quadratic program that was solved last."""
        return Program.of(self.view)

    @property
    def answer(self) -> Answer[Array]:
        """Its answer."""
        return Answer.of(self.view)

    @property
    def evaluation(self) -> Evaluation[Array]:
        """Evaluation of the answer."""
        return Evaluation.of(self.view)

    @property
    def v(self) -> Array:
        """(u⁺ − u)/dt − φ, shape (m,), units of u per second."""
        return self.part("v")

    @property
    def phi(self) -> Array:
        """Tracking term φ, shape (m,), units of u per second."""
        return self.part("phi")

    @property
    def u_nominal(self) -> Array:
        """û = u_fb(x) + u_h, shape (m,)."""
        return self.part("u_nominal")

    @property
    def psi(self) -> Array:
        """ψ₀ … ψ_r of every barrier at (x, u⁺), one barrier after the other."""
        return self.part("psi")

    @property
    def power_margin(self) -> float:
        """h_u(x, u⁺), W."""
        return float(self.part("h_u")[0])

    @property
    def slack(self) -> float:
        """δ of the passivity row, W; 0 where there is none."""
        return self.assessment.slack

    @property
    def margins(self) -> Array:
        """Distance of the decision to each row, shape (N,), units of u; negative means violated."""
        return self.part("margins")

    @property
    def duals(self) -> Array:
        """Multiplier of each unit-length row, shape (N,)."""
        return self.part("lam")

    @property
    def primal_residual(self) -> float:
        """Largest violation of a row, relative to 1 + ‖z‖."""
        return self.assessment.primal

    @property
    def dual_residual(self) -> float:
        """Distance from stationarity and dual feasibility, relative to 1 + ‖z‖."""
        return self.assessment.dual

    @property
    def gap(self) -> float:
        """Duality gap, relative to 1 + ‖z‖²."""
        return self.assessment.gap


def _numbers(values: Iterable[float]) -> str:
    return f"({', '.join(map(_number, values))})"


def _number(value: float) -> str:
    return "0" if abs(value) < _NEGLIGIBLE else f"{value:.4g}"
