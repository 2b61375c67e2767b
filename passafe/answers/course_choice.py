"""The choice of what is sent by the courses that inputs lead to: where rows cannot be kept, and by the gatekeeper."""

from passafe.answers.deepest_inputs import DeepestInputs
from passafe.answers.replaced_answer import BETWEEN, DEEPEST, ReplacedAnswer
from passafe.courses.fallback import Fallback, between
from passafe.decision import Attempt, Status
from passafe.program.decision_block import DecisionBlock
from passafe.symbolic.evaluation import UNPROTECTED


class CourseChoice:
    """Sends an attempt's answer or another input, whichever keeps the barriers longer.

    Attributes:
        compares: Whether answers outside of the protected set are compared with the backup law.
    """

    def __init__(
        self,
        block: DecisionBlock,
        replaced: ReplacedAnswer,
        deepest: DeepestInputs,
        fallback: Fallback | None,
        *,
        compares: bool,
        is_for_sets: bool,
    ) -> None:
        """Hold what is compared.

        Args:
            block: Holds request, program and answer.
            replaced: Sends other inputs.
            deepest: Finds candidates.
            fallback: Compares courses; ``None`` where the design has none.
            compares: Whether answers outside of the protected set are compared with the backup law.
            is_for_sets: Whether the plant may be other than its model, of which alone courses prove something.
        """
        self._proves = not is_for_sets
        self.compares = compares and fallback is not None
        self._block, self._replaced, self._deepest, self._fallback = block, replaced, deepest, fallback

    def choose(self, attempt: Attempt) -> Attempt:
        """Send the answer of an attempt, unless another input or the backup law keeps the barriers longer.

        Where only the margins cannot be kept, but every barrier is proven to be kept on the course of what is sent,
        that is no fallback; nor is it where a gatekeeper has kept the robot to such courses. Of a plant that may be
        other than its model no course is proven.

        Args:
            attempt: It, whose numbers are in the block; no answer, or one at the sample alone.
        """
        block, fallback = self._block, self._fallback
        if fallback is None:
            return attempt if attempt.status is not Status.UNCERTIFIED else self._replaced.send_backup(attempt)
        if attempt.status is Status.UNCERTIFIED:
            return self._replaced.send_backup(attempt)
        candidates = [block.evaluation.u_plus.copy(), self._deepest.of_program(attempt)]
        request, others = block.request, len(candidates)
        candidates += between(self._replaced.backup_input(), candidates)
        best = fallback.best(request.x, float(request.t[0]), self._replaced.input_before(), candidates)
        if best.place is None:
            chosen = self._replaced.send_backup(attempt)
        elif best.place == 0:
            chosen = attempt
        else:
            chosen = self._replaced.send(candidates[best.place], DEEPEST if best.place < others else BETWEEN, attempt)
        is_proven = self._proves and best.is_safe and (attempt.status is Status.AT_SAMPLES or fallback.has_gatekeeper)
        return _by_course(chosen) if is_proven else chosen

    def guard(self, attempt: Attempt) -> Attempt:
        """Send an answer that keeps every row, unless the backup law's input is better.

        Outside of the protected set rows only lead back to it: there the answer is sent if no barrier is lost earlier
        on its course than on the backup law's, nor by more. Within it a gatekeeper sends an answer only if from where
        it leads the backup law keeps every barrier; where that law does not keep them either, nothing is guarded.

        Args:
            attempt: It, whose numbers are in the block.
        """
        block, fallback = self._block, self._fallback
        if fallback is None:
            return attempt
        request, u_plus, before = block.request, block.evaluation.u_plus.copy(), self._replaced.input_before()
        state = request.x, float(request.t[0])
        if attempt.assessment.lowest_psi < UNPROTECTED:
            is_good = not self.compares or fallback.best(*state, before, [u_plus]).place is not None
        else:
            is_good = fallback.is_backed(*state, u_plus) or not fallback.keeps(*state, before)
            is_good = is_good and fallback.is_lasting(*state, before, u_plus)
        if is_good:
            return attempt
        return _by_course(self._replaced.send_backup(attempt))


def _by_course(attempt: Attempt) -> Attempt:
    """Return an attempt whose input is sent because of its course."""
    return Attempt(Status.BACKUP, attempt.solver, True, attempt.assessment)
