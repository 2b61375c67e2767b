"""The memory of the decision that is being made: every stage's numbers in one block, with typed access to each."""

from passafe.certificate import Residuals
from passafe.decision import Attempt, Decision
from passafe.decision_schema import (
    Answer,
    Assessment,
    Evaluation,
    Linearization,
    NormTangents,
    Program,
    Request,
)
from passafe.numerics.workspace import Array, BlockLayout, Workspace, Writer


class DecisionBlock:
    """Views of the stages in one block; the compiled functions read and write the same memory.

    Attributes:
        space: The block.
        layout: Places of the parts in it.
        numbers: All its numbers, shape (layout.size,).
        write_request: What writes all numbers of the request.
        request: The request's parts.
        linearization: The linearization's.
        program: The quadratic program's parts.
        tangents: Tangents of the norm's limit.
        answer: The answer's parts.
        evaluation: What follows from the answer.
        residuals: Residuals of the assessment.
        read_input: Returns u⁺, m numbers.
        read_assessment: Returns the assessment of the answer.
    """

    def __init__(self, layout: BlockLayout) -> None:
        """Make room for the parts of a decision."""
        self.space = space = Workspace(layout)
        self.layout = layout
        self.numbers: Array = space.block
        self.write_request: Writer = space.span_writer(Request.names())
        self.request: Request[Array] = Request.of(space.view)
        self.linearization: Linearization[Array] = Linearization.of(space.view)
        self.program: Program[Array] = Program.of(space.view)
        self.tangents: NormTangents[Array] = NormTangents.of(space.view)
        self.answer: Answer[Array] = Answer.of(space.view)
        self.evaluation: Evaluation[Array] = Evaluation.of(space.view)
        self.residuals: Residuals[Array] = Residuals.of(space.view)
        self.read_input = space.reader("u_plus")
        self.read_assessment = space.scalar_reader(Assessment[float])

    @property
    def answer_numbers(self) -> Array:
        """View of all numbers of the answer."""
        return self.space.block[self.space.layout.span(Answer.names())]

    def decision(self, attempt: Attempt) -> Decision:
        """Return what the block holds as the decision of an attempt."""
        return Decision(
            self.numbers.copy(), self.layout, attempt.status, attempt.solver, attempt.assessment, self.read_input()
        )
