"""The functions that a decision is made of, compiled from a design or bound to the memory of one decision."""

from passafe.numerics.stage import Stage, T


class DecisionFunctions(Stage[T], frozen=True, eq=False, gc=False):
    """Functions between the stages of ``passafe.decision_schema``; inputs and outputs are named for the parts.

    Attributes:
        linearize: Request → first linearization, about u for a trust region that reaches u_ref, and first tangents.
        prepare: Request and linearization → program and a blank answer, all zero.
        prepare_usual: Request → first linearization and tangents, program and blank answer, where start is 0.
        evaluate: Request, linearization, program, tangents and answer → evaluation and assessment.
        prove_conflict: Program and ``relax`` → ``conflict``.
        fail_safe: x → ``u_plus``, the fail-safe law's input, not clipped.
    """

    linearize: T
    prepare: T
    prepare_usual: T
    evaluate: T
    prove_conflict: T
    fail_safe: T
