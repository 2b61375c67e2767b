"""The passivity row of the sampled law, and the slack that an input really takes."""

from dataclasses import dataclass

import casadi as ca

from passafe.design import FilterDesign, Law
from passafe.enclosures.reachable_tube import Tube
from passafe.margins.intersample_margin import HeldRow, held_power
from passafe.margins.member_bound import MemberBound, member_bound
from passafe.margins.plant_family import PlantFamily
from passafe.passivity import Passivity
from passafe.symbolic.rows import PASSIVITY_ROW, ConstraintRow, row_at
from passafe.system import System


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class EnforcedPassivity:
    """The energy's demand on a held input: h_u ≥ −κ(E − E_r) − δ, or h_u ≥ −δ without a tank, for the whole period.

    What a parameter may do to the power is bounded over the trust region, for a soft row need not be exact at its ends.

    Attributes:
        system: The plant.
        passivity: What is demanded.
        held: Its two conditions; of the member in the middle of a family.
        general: The plants for which the demand is to be met, and the conditions with the symbols of their coordinates
            in them; ``None`` for the model alone.
        dt_s: T, s: the period. What an input takes that is held for longer is the plant's own doing, like its
            fail-safe.
        has_margin: Whether the row has a margin between samples.
    """

    system: System
    passivity: Passivity
    held: HeldRow
    general: tuple[PlantFamily, HeldRow] | None
    dt_s: float
    has_margin: bool

    @classmethod
    def of(cls, design: FilterDesign, tank_j: ca.SX, family: PlantFamily | None = None) -> "EnforcedPassivity | None":
        """Return the demand of a design under the sampled law; ``None`` where its mode demands nothing.

        Args:
            design: The design.
            tank_j: E, symbol, J.
            family: The plants for which it is to be met; ``None`` for the model alone.
        """
        if not design.mode.enforces_passivity or design.law is not Law.SAMPLED:
            return None
        passivity, dt_s = design.passivity, design.dt_s
        member = design.system if family is None else family.system
        return cls(
            system=design.system,
            passivity=passivity,
            held=held_power(member, passivity, tank_j, dt_s),
            general=None if family is None else (family, held_power(member, passivity, tank_j, dt_s, general=True)),
            dt_s=dt_s,
            has_margin=design.between_samples,
        )

    def deviation(self, tube: Tube, u_lin: ca.SX, trust: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Return the deviation for all inputs within ``trust`` of u_lin, W, and 1 where it is unknown, else 0.

        Args:
            tube: Around x for these inputs, expressions of the system's u.
            u_lin: Shape (m, 1).
            trust: Radius in each axis, shape (m, 1).
        """
        both = self.held.deviation(self.system, tube, self.dt_s, trust)
        size, known = ca.substitute([*both], [self.system.u], [u_lin])
        return ca.if_else(known, size, 0), 1 - known

    def member_bound(
        self, general: tuple[PlantFamily, HeldRow], tube: Tube, x_radius: ca.SX, u_lin: ca.SX, trust: ca.SX
    ) -> MemberBound:
        """Return deviation and uncertainty for all members of the family, W.

        Args:
            general: That of this demand.
            tube: Of all members for inputs within ``trust`` of u_lin, expressions of the system's u.
            x_radius: Error of x, shape (n, 1).
            u_lin: Shape (m, 1).
            trust: Radius in each axis, shape (m, 1).
        """
        bound = member_bound(*general, tube, self.dt_s, x_radius, trust, at_ends=False)
        return MemberBound(*ca.substitute([*bound], [self.system.u], [u_lin]))

    def row(self, u_ref: ca.SX, u_lin: ca.SX, deviation: ca.SX, uncertainty: ca.SX) -> ConstraintRow:
        """Return the soft row, in w: that of the two conditions which asks for more at u_lin, or its tangent there.

        Args:
            u_ref: Where w is zero, shape (m, 1).
            u_lin: Where the tangent touches, shape (m, 1).
            deviation: W.
            uncertainty: What members of a family take, W; empty without one.
        """
        function = self.held.value if self.general is None else self.held.value - uncertainty
        if self.has_margin:
            bends = ca.substitute(self.held.bend, self.system.u, u_lin) < deviation
            function = function + ca.if_else(bends, 1, 0) * (self.held.bend - deviation)
        row = row_at(self.system, PASSIVITY_ROW, function, u_ref, u_lin)
        return ConstraintRow(
            name=row.name, value=row.value, gradient=row.gradient, slack_price=self.passivity.slack_weight
        )

    def slack(self, u_plus: ca.SX, deviation: ca.SX, uncertainty: ca.SX) -> ca.SX:
        """Return the δ ≥ 0 with which u⁺ keeps the row for the whole period, W, whatever the program took it for.

        Args:
            u_plus: Shape (m, 1).
            deviation: W.
            uncertainty: What members of a family take, W; empty without one.
        """
        value, bend = ca.substitute([self.held.value, self.held.bend], [self.system.u], [u_plus])
        margin = ca.fmax(deviation - bend, 0) if self.has_margin else ca.SX(0)
        return ca.fmax(margin - value if self.general is None else margin + uncertainty - value, 0)
