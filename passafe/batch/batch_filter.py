"""Decisions for many states at once, each with the certificate that ``SafetyPassivityFilter`` asks for.

The filter's own functions are evaluated for all lanes at once, the answer is guessed in closed form, and the filter's
own certificate judges it. What it does not accept is given to the filter itself. A strictly convex program has one
answer, so that both ways lead to the same decision, up to the certificate's tolerance.
"""

import numpy as np
from numpy.typing import NDArray

from passafe.batch.batch_workspace import BatchWorkspace
from passafe.batch.nearest_points import NearestPoints
from passafe.decision import Status
from passafe.derivation import NORM_TOLERANCE
from passafe.filter import SafetyPassivityFilter
from passafe.workspace import Array


class BatchFilter:
    """Decides for many lanes; what it decided stays until it decides again.

    Attributes:
        core: The filter.
        lanes: Parts of all decisions, those of a ``Decision``, a column for each lane.
        duties: Number of duties' rows.
        hard: Number of hard ones among them; they come first.
        gradients: Gradients of the duties' rows in u, shape (m, duties, count).
        status: Numbers of ``Status``, shape (count,).
        singly: Which lanes the filter itself decided, shape (count,).
    """

    def __init__(self, core: SafetyPassivityFilter, count: int) -> None:
        """Bind the filter's functions.

        Args:
            core: The filter.
            count: BatchWorkspace that are needed.

        Raises:
            DesignError: The filter's functions have an operation that arrays do not know.
        """
        self.core = core
        derivation, m = core.derivation, core.design.system.m
        self.lanes = lanes = BatchWorkspace(core.layout, count)
        given, derived, judged = derivation.sizes_given, derivation.sizes_derived, derivation.sizes_judged
        self._prepare = lanes.bind(derivation.prepare_usual, list(given), list(derived))
        self._judge = lanes.bind(derivation.judge, derivation.judge_reads, list(judged))
        self.duties, self.hard, self._m = derivation.duties, derivation.hard, m
        self._G = lanes.matrix("G", (self.duties, derivation.k))
        self.gradients = self._G[:m]
        self.status: NDArray[np.int8] = np.zeros(lanes.count, dtype=np.int8)
        self.singly: NDArray[np.bool_] = np.zeros(lanes.count, dtype=np.bool_)
        cuts = derivation.sizes_solved["cuts"] // m
        self._cuts = lanes.matrix("cuts", (cuts, m))
        self._too_long = NORM_TOLERANCE * (core.design.limits.norm or 0.0)
        # Tangents of the norm are the same before one is needed: one of them is enough.
        self._points = points = NearestPoints(derivation.k, self.duties + 2 * m + min(cuts, 1), lanes.count)
        axes = np.eye(derivation.k, m)[:, :, None]
        points.rows[:, self.duties : self.duties + m] = axes
        points.rows[:, self.duties + m : self.duties + 2 * m] = -axes
        points.rows[0, self.duties + 2 * m :] = -1.0

    def part(self, name: str) -> Array:
        """Return a part of all decisions, shape (size, count): see ``SafetyPassivityFilter`` for the names."""
        return self.lanes.part(name)

    def decide(
        self,
        x: Array,
        u: Array,
        u_h: Array,
        u_h_rate: Array | float,
        tank_j: Array | float = 0.0,
        t_s: Array | float = 0.0,
        *,
        start: bool = False,
        singly: bool = False,
    ) -> None:
        """Decide for every lane; the arguments are those of ``SafetyPassivityFilter.decide``, a column for each.

        Args:
            x: States, shape (n, lanes).
            u: Inputs in force, shape (m, lanes).
            u_h: Operators' parts, shape (m, lanes).
            u_h_rate: Their time derivatives, shape (m, lanes).
            tank_j: Energies in the tanks, J, shape (lanes,).
            t_s: Plant times, s, shape (lanes,).
            start: Whether there was no input before; then the filter itself decides.
            singly: Whether the filter itself shall decide for every lane.
        """
        given = {"x": x, "u": u, "u_h": u_h, "u_h_rate": u_h_rate, "tank": tank_j, "t": t_s}
        for name, value in given.items():
            self.part(name)[:, : self.lanes.used] = value
        if start or singly:
            self.singly[:] = True
        else:
            with np.errstate(all="ignore"):  # what is no number fails the certificate
                self._decide_at_once()
        for lane in np.flatnonzero(self.singly[: self.lanes.used]).tolist():
            self._decide_singly(lane, start=start)

    def _decide_at_once(self) -> None:
        for name in ("start", "trust_asked", "lam", "conflict", "relax"):
            self.part(name).fill(0.0)
        self.part("u_lin")[:] = self.part("u")
        self.part("cushion")[:] = self.core.derivation.first_cushion
        self._cuts[:] = 0.0
        self._cuts[:1] = 1.0
        self._prepare()
        self._guess()
        self._judge()
        self._accept()

    def _guess(self) -> None:
        """Put the guess of the filter's whole program, limits included, where its answer belongs."""
        points, duties, m = self._points, self.duties, self._m
        u_ref, bounds = self.part("u_ref"), points.bounds
        points.rows[:, :duties] = self._G
        bounds[:duties] = self.part("d")
        np.subtract(self.part("low"), u_ref, bounds[duties : duties + m])
        np.subtract(u_ref, self.part("high"), bounds[duties + m : duties + 2 * m])
        np.subtract(u_ref[:1], self.core.derivation.norm_asked, bounds[duties + 2 * m :])
        points.find(self.part("z"), self.part("lam")[: len(bounds)])

    def _accept(self) -> None:
        """Say of every lane whether the filter would accept the guess, and with what status."""
        too_long, slack, shortfall, strayed = (
            self.part(name)[0] for name in ("norm_overreach", "slack", "shortfall", "strayed")
        )
        tolerance = self.core.design.tolerance
        primal, dual, gap = self.part("residuals")
        certified = (primal <= tolerance.residual) & (dual <= tolerance.residual) & (gap <= tolerance.gap)
        suits = (too_long <= self._too_long) & (shortfall <= 0.0) & (strayed <= 0.0)
        self.singly[:] = ~(certified & suits)
        untouched = ~self.part("lam").any(axis=0)
        modified = np.where(slack > self.core.design.passivity.relaxed_above, Status.RELAXED, Status.MODIFIED)
        self.status[:] = np.where(untouched, Status.PASSED, modified)

    def _decide_singly(self, lane: int, *, start: bool) -> None:
        x, u, u_h, u_h_rate = (self.part(name)[:, lane].tolist() for name in ("x", "u", "u_h", "u_h_rate"))
        tank_j, t_s = (float(self.part(name)[0, lane]) for name in ("tank", "t"))
        decision = self.core.decide(x, u, u_h, u_h_rate, tank_j, t_s, start=start)
        self.lanes.block[:, lane] = decision.block
        self.status[lane] = decision.status
