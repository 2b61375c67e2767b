"""The compiled functions of a derivation, bound to the memory of one decision."""

from passafe.decision_schema import Answer, Assessment, Evaluation, Linearization, NormTangents, Program, Request
from passafe.derivation import Derivation
from passafe.stage import part_names
from passafe.workspace import Workspace


class BoundFunctions:
    """Functions without arguments: each reads its arguments from a workspace and writes its results there.

    Attributes:
        linearize: Request → first linearization and tangents.
        prepare: Request and linearization → program and a blank answer, all zero.
        prepare_usual: Request → first linearization and tangents, program and blank answer, where start is 0.
        evaluate: Request, linearization, program, tangents and answer → evaluation and assessment.
        prove_conflict: Program and ``relax`` → ``conflict``.
        fail_safe: x → ``u_plus``, the fail-safe law's input, not clipped.
    """

    def __init__(self, derivation: Derivation, space: Workspace) -> None:
        """Bind the functions.

        Args:
            derivation: Their source.
            space: Laid out as the derivation says; it must be held for as long as the functions are used.
        """
        request, linearization = part_names(Request), part_names(Linearization)
        posed = part_names(Request, Linearization, Program, NormTangents, Answer)
        first = part_names(Linearization, NormTangents)
        self.linearize = space.bind(derivation.linearize, request, first)
        self.prepare = space.bind(derivation.prepare, [*request, *linearization], part_names(Program, Answer))
        self.prepare_usual = space.bind(derivation.prepare_usual, request, [*first, *part_names(Program, Answer)])
        self.evaluate = space.bind(derivation.evaluate, posed, part_names(Evaluation, Assessment))
        self.prove_conflict = space.bind(derivation.prove_conflict, [*part_names(Program), "relax"], ["conflict"])
        self.fail_safe = space.bind(derivation.fail_safe, ["x"], ["u_plus"])
