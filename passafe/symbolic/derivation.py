"""From a design to compiled functions: what the filter evaluates before and after it solves its quadratic program."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, TypeVar

import casadi as ca

from passafe.barrier_chain import BarrierChain
from passafe.decision_schema import Answer, Linearization, NormTangents, Program, Request
from passafe.design import FilterDesign, Law
from passafe.margins.plant_family import PlantFamily
from passafe.numerics.stage import Stage
from passafe.numerics.workspace import BlockLayout, expressions, expressions_by_name, named_function
from passafe.symbolic.conflict_proof import conflict
from passafe.symbolic.constraint_program import Deviations, constraint_program, constraint_rows
from passafe.symbolic.decision_functions import DecisionFunctions
from passafe.symbolic.enforced_barriers import EnforcedBarriers
from passafe.symbolic.enforced_passivity import EnforcedPassivity
from passafe.symbolic.evaluation import evaluate
from passafe.symbolic.reference_input import reference_input
from passafe.symbolic.trust_region import trust_radius
from passafe.symbolic.whole_program import RowLayout, first_cuts

TIGHTENING: Final = 2.0
"""Distance by which constraints are kept beyond what is asked, in units of the residual that an answer may have."""

Symbols = TypeVar("Symbols", bound=Stage[ca.SX])


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Derivation:
    """Functions and shapes that follow from a design.

    Attributes:
        layout: Places and shapes of all parts.
        rows: The whole program's rows.
        barriers: The enforced barriers.
        has_margins: Whether there are margins between samples.
        is_affine: Whether the hard rows without margins are affine in u.
        functions: The compiled functions.
    """

    layout: BlockLayout
    rows: RowLayout
    barriers: EnforcedBarriers
    has_margins: bool
    is_affine: bool
    functions: DecisionFunctions[ca.Function]

    @classmethod
    def of(
        cls, design: FilterDesign, chains: Sequence[BarrierChain], family: PlantFamily | None = None
    ) -> "Derivation":
        """Derive everything.

        Args:
            design: What to derive it from.
            chains: One for each of its barriers.
            family: The plants for which rows are to hold; ``None`` for the model alone.
        """
        request, linearization = _request(design), _linearization(design)
        barriers = EnforcedBarriers.of(design, chains, family)
        reference = reference_input(design, request)
        trust = trust_radius(design.limits, linearization, reference.u_ref)
        passivity = EnforcedPassivity.of(design, request.tank, family)
        deviations = Deviations.of(barriers, passivity, linearization.u_lin, trust, request.x_error)
        constraints = constraint_rows(barriers, passivity, linearization, reference, deviations)
        program, root = constraint_program(design, constraints, request, reference, trust, deviations)
        rows = RowLayout.of(constraints, design.limits)

        posed, tangents = symbols_like(program), NormTangents(ca.SX.sym("cuts", rows.tangents, design.system.m))
        sizes = {"z": rows.columns, "lam": len(rows.names), "relax": rows.hard, "conflict": 1}
        sizes["limit_weights"] = len(design.limits.half_spaces) + rows.tangents
        answer = Answer.of(lambda name: ca.SX.sym(name, sizes[name]))
        evaluation, assessment = evaluate(
            chains, barriers, passivity, request, linearization, posed, tangents, answer, root
        )
        about_u, blank = _about_u(design, request), zeros_like(answer)
        first = expressions_by_name(about_u, NormTangents(first_cuts(design.limits)))
        usual = _usual(program, request, linearization, about_u)
        functions = DecisionFunctions(
            linearize=named_function("linearize", request.fields(), first),
            prepare=named_function(
                "prepare", expressions_by_name(request, linearization), expressions_by_name(program, blank)
            ),
            prepare_usual=named_function("prepare_usual", request.fields(), first | expressions_by_name(usual, blank)),
            evaluate=named_function(
                "evaluate",
                expressions_by_name(request, linearization, posed, tangents, answer),
                expressions_by_name(evaluation, assessment),
            ),
            prove_conflict=named_function(
                "prove_conflict",
                posed.fields() | tangents.fields() | {"relax": answer.relax, "limit_weights": answer.limit_weights},
                {"conflict": conflict(design.limits, posed, tangents, answer)},
            ),
            fail_safe=named_function("fail_safe", {"x": design.system.x}, {"u_plus": design.fail_safe}),
        )
        return cls(
            layout=BlockLayout.of_stages(request, linearization, program, tangents, answer, evaluation, assessment),
            rows=rows,
            barriers=barriers,
            has_margins=barriers.has_margins or (passivity is not None and passivity.has_margin),
            is_affine=design.law is Law.CONTINUOUS or barriers.are_affine,
            functions=functions,
        )


def first_tightening(design: FilterDesign) -> float:
    """Return the tightening that is tried first, units of u."""
    return TIGHTENING * design.tolerance.residual if design.between_samples else 0.0


def symbols_like(stage: Symbols) -> Symbols:
    """Return symbols with the shapes of a stage's expressions."""
    shapes = {name: expression.shape for name, expression in stage.fields().items()}
    return stage.of(lambda name: ca.SX.sym(name, *shapes[name]))


def zeros_like(stage: Symbols) -> Symbols:
    """Return zeros with the shapes of a stage's expressions."""
    shapes = {name: expression.shape for name, expression in stage.fields().items()}
    return stage.of(lambda name: ca.SX.zeros(*shapes[name]))


def _request(design: FilterDesign) -> Request[ca.SX]:
    system, m = design.system, design.system.m
    return Request(
        x=system.x,
        u=system.u,
        u_h=ca.SX.sym("u_h", m),
        u_h_rate=ca.SX.sym("u_h_rate", m),
        tank=ca.SX.sym("tank"),
        t=system.t,
        start=ca.SX.sym("start"),
        x_error=ca.SX.sym("x_error", 0 if design.uncertainty is None else system.n),
    )


def _linearization(design: FilterDesign) -> Linearization[ca.SX]:
    m = design.system.m
    return Linearization(
        u_lin=ca.SX.sym("u_lin", m),
        trust_asked=ca.SX.sym("trust_asked", m),
        tightening=ca.SX.sym("tightening"),
        with_margins=ca.SX.sym("with_margins"),
        with_sets=ca.SX.sym("with_sets", 0 if design.uncertainty is None else 1),
    )


def _about_u(design: FilterDesign, request: Request[ca.SX]) -> Linearization[ca.SX]:
    """Return the linearization that is tried first."""
    return Linearization(
        u_lin=request.u,
        trust_asked=ca.SX.zeros(request.u.numel()),
        tightening=ca.SX(first_tightening(design)),
        with_margins=ca.SX(1),
        with_sets=ca.SX.ones(0 if design.uncertainty is None else 1),
    )


def _usual(
    program: Program[ca.SX],
    request: Request[ca.SX],
    linearization: Linearization[ca.SX],
    about_u: Linearization[ca.SX],
) -> Program[ca.SX]:
    """Return the program of nearly every decision: not the first of all, linearized about u."""
    own = [request.start, *expressions(linearization)]
    return Program(*ca.substitute(expressions(program), own, [ca.SX(0), *expressions(about_u)]))
