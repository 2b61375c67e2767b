"""The search for an answer where none is known yet to keep the hard rows with their margins, or a choice by course."""

import numpy as np

from passafe.answers.attempts import Attempts
from passafe.answers.calmer_inputs import CalmerInputs
from passafe.answers.course_choice import CourseChoice
from passafe.answers.deepest_inputs import DeepestInputs
from passafe.answers.input_search import InputSearch
from passafe.answers.replaced_answer import BACKUP, ReplacedAnswer
from passafe.decision import ANSWERS, Attempt, Status
from passafe.decision_schema import keeps_barriers
from passafe.design import FilterDesign
from passafe.numerics.workspace import Array
from passafe.program.decision_block import DecisionBlock
from passafe.symbolic.trust_region import LEAST_TRUST


class Resolution:
    """Resolves the decision that is being made."""

    def __init__(
        self,
        design: FilterDesign,
        block: DecisionBlock,
        attempts: Attempts,
        replaced: ReplacedAnswer,
        deepest: DeepestInputs,
        choice: CourseChoice,
    ) -> None:
        """Hold what is tried.

        Args:
            design: The filter's.
            block: Holds request, program and answer.
            attempts: Makes attempts at the program of the block.
            replaced: Sends the backup law's input.
            deepest: Finds inputs to begin from.
            choice: Chooses where there is no answer.
        """
        self._block, self._attempts = block, attempts
        self._replaced, self._deepest, self._choice = replaced, deepest, choice
        self._calmer_inputs, self._has_sets = CalmerInputs(design), design.uncertainty is not None
        self._least_trust: Array = LEAST_TRUST * np.array(design.limits.magnitude)

    def resolve(self, *, has_margins: bool) -> Attempt:
        """Find out what the hard rows allow where no answer is known to keep them with their margins, and act on it.

        Args:
            has_margins: Whether rows have margins between samples.
        """
        block, attempts = self._block, self._attempts
        if not block.program.nan_guard[0] <= 1.0:
            return self._replaced.send_backup(Attempt(Status.UNCERTIFIED, BACKUP, False, block.read_assessment()))
        at_samples = attempts.about(block.request.u, with_margins=False)
        if at_samples.status is Status.INFEASIBLE and self._has_sets:
            # What members may take of a row was bounded about one input, and may be less about another.
            at_samples = attempts.about(block.request.u, with_margins=False, with_sets=False)
        if at_samples.status is Status.INFEASIBLE and self._deepest.search is not None:
            at_samples = self._search(at_samples, self._deepest.search)
        if at_samples.status in ANSWERS and not keeps_barriers(at_samples.assessment):  # tangents that do not settle
            at_samples = Attempt(Status.UNCERTIFIED, at_samples.solver, False, at_samples.assessment)
        if at_samples.status not in ANSWERS:
            return self._choice.choose(at_samples)
        if not has_margins:
            return at_samples
        return self._with_margins(at_samples)

    def _with_margins(self, at_samples: Attempt) -> Attempt:
        """Return an answer that keeps the rows with their margins, sought from several inputs; else choose by course.

        Args:
            at_samples: The answer without margins, whose numbers are in the block.
        """
        block, attempts = self._block, self._attempts
        request, program = block.request, block.program
        u_sample, low, high = block.evaluation.u_plus.copy(), program.low.copy(), program.high.copy()
        deepest, of_all = self._deepest.of_program(at_samples), self._deepest.of_rows()
        backup = self._replaced.backup_input()
        for u_lin in (u_sample, deepest, backup, *of_all):
            again = attempts.about(u_lin, with_margins=True)
            if again.is_settled:
                return again
        # Where the rows are best their tangents are level, and keep no answer near; nor does what members take.
        for u_lin in (deepest, backup, *of_all) if self._has_sets else of_all:
            again = attempts.confined(u_lin, self._least_trust)
            if again.is_settled:
                return again
        for wanted in (u_sample, deepest, *of_all):  # the second does not depend on the input before
            for u_lin, trust in self._calmer_inputs.towards(wanted, request.x, request.u, low, high):
                again = attempts.confined(u_lin, trust)
                if again.is_settled:
                    return again
        at_samples = self._at_samples(deepest if self._has_sets else u_sample)
        return self._choice.choose(Attempt(Status.AT_SAMPLES, at_samples.solver, False, at_samples.assessment))

    def _at_samples(self, u_lin: Array, *, with_sets: bool = True) -> Attempt:
        """Return the answer without margins that is found from an input, or near it.

        Where a drive saturates, rows lie level, and their tangents lead anywhere.
        """
        attempt = self._attempts.about(u_lin, with_margins=False, with_sets=with_sets)
        if attempt.status in ANSWERS and attempt.is_settled:
            return attempt
        return self._attempts.confined(u_lin, self._least_trust, with_margins=False, with_sets=with_sets)

    def _search(self, attempt: Attempt, search: InputSearch) -> Attempt:
        """Search all admissible inputs for one that keeps the hard rows, which are not affine in u.

        Tangents that conflict prove nothing of the rows themselves. Where the search neither finds an input nor proves
        that there is none, nothing is claimed.
        """
        found = search.find(self._block)
        if found.is_impossible:
            return attempt
        if found.u is not None and (again := self._at_samples(found.u, with_sets=False)).status in ANSWERS:
            return again
        return Attempt(Status.UNCERTIFIED, attempt.solver, False, self._block.read_assessment())
