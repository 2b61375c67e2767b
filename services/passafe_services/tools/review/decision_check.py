"""Check of the filter's decisions: each is derived anew from what its tick says it was asked, and compared.

The core's batch filter states the same program, answers it, and proves its answer with the certificate of the filter;
so every number of a tick that follows from x̂, u_h, the tank and the time is recomputed, its ψ chain, rows, duals,
slack and input included. The input before the decision is u − dt (v + φ).
"""

from contextlib import suppress
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray
from passafe_protocol.messages import FilterStatus
from passafe_protocol.topics import TICK

from passafe.batch.batch_filter import BatchFilter
from passafe.decision import Status
from passafe.errors import DesignError
from passafe.filter import SafetyPassivityFilter
from passafe_services.filter.member_rows import barrier_members
from passafe_services.filter.telemetry import STATUS
from passafe_services.log.chunk_decoding import Wants
from passafe_services.log.column import Places
from passafe_services.log.log_pass import LogSlice
from passafe_services.log.message_block import MessageBlock
from passafe_services.scenarios.design import design_of, robot_of
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.review.agreement import LogAgreement, relative
from passafe_services.tools.review.explanation_check import ExplanationCheck
from passafe_services.tools.review.filter_claims import ANSWERED, IntArray
from passafe_services.tools.review.limit_pushes import unlike_pull
from passafe_services.tools.review.plant_evaluator import FloatArray
from passafe_services.tools.review.trajectory import NS_PER_S

TOLERANCE: Final = 5e-3
"""Relative difference that the certificate's tolerance leaves between two answers to one program: a gap of 1e-6 leaves
√2e-6 of the input, and a ψ may change by more than that."""

EXACT: Final = 1e-6
"""Relative difference that rounding leaves where nothing depends on the answer."""

ROUNDED: Final = 1e-12
"""Relative rounding error of an input that is recovered from its change."""

_ALLOWED: Final = {"u_nominal": EXACT, "φ": EXACT, "ψ": EXACT, "held back": EXACT}
"""Differences that are allowed by the quantity; ``TOLERANCE`` for others."""

AT_ONCE: Final = 1024
MOST_SCALAR: Final = 5000
"""Decisions that arrays cannot make and the scalar filter makes again; of more, the rest are left out and counted."""

_VECTORS: Final = ("x_hat", "u", "u_h", "u_h_rate", "u_nominal", "phi", "v")


class _BoundedFilter(BatchFilter):
    """Batch filter that makes only so many decisions one by one."""

    left: int = MOST_SCALAR
    asked: int = AT_ONCE
    """Number of elements that are decisions of a log; the others fill the arrays up."""

    def _decide_scalar(self, element: int, *, start: bool) -> None:
        if element < self.asked and self.left > 0:
            self.left -= 1
            super()._decide_scalar(element, start=start)
            self.scalar[element] = False


class DecisionCheck:
    """Check of the decisions of a run, as its ticks come.

    Args:
        scenario: The scenario.

    Attributes:
        agreement: Differences.
    """

    wants: ClassVar[Wants] = {
        TICK.name: (
            *("tick", *_VECTORS, "tank_j", "effective_plant_ns", "power_margin", "slack", "mode", "law", "status"),
            "x_error",
            *("barriers.psi", "barriers.length", "rows.margin", "rows.dual", "rows.length"),
            *ExplanationCheck.wants,
        )
    }

    def __init__(self, scenario: Scenario) -> None:
        self.agreement = LogAgreement("decisions that differ from those derived anew from what their ticks say = 0")
        self._period_s = scenario.dt_s
        self._mode, self._law = scenario.filter.mode, scenario.filter.law
        core = SafetyPassivityFilter(design_of(scenario, robot_of(scenario)))
        self._n, self._m = core.design.system.n, core.design.system.m
        self._barriers = barrier_members(core)
        lengths = [members.places[0].stop - members.places[0].start for members in self._barriers]
        self._is_last = np.array([level == length - 1 for length in lengths for level in range(length)], dtype=np.bool_)
        self._explanation = ExplanationCheck(core)
        self._filter: _BoundedFilter | None = None
        with suppress(DesignError):  # an operation that arrays do not know: nothing is looked at, which is said
            self._filter = _BoundedFilter(core, AT_ONCE)
        self._newest: dict[int, int] = {}

    def take(self, part: LogSlice) -> None:
        """Take the next ticks."""
        for block in part.blocks(TICK.name):
            self._take_names(block)
            self._take_names_of_rows(block)
            ticks = block.numbers("tick").astype(np.int64)
            # A step without a new decision repeats the last one.
            new = np.diff(ticks, prepend=self._newest.get(block.epoch, -1)) != 0
            self._newest[block.epoch] = int(ticks[-1])
            rows = np.flatnonzero(new)
            if self._filter is None:
                self.agreement.left_out += rows.size
                continue
            for begin in range(0, rows.size, AT_ONCE):
                self._check(block, rows[begin : begin + AT_ONCE], ticks, self._filter)

    def _take_names(self, block: MessageBlock) -> None:
        for path, allowed in (("mode", self._mode), ("law", self._law)):
            wrong = ~block.texts(path).are(allowed)
            if wrong.any():
                row = int(np.flatnonzero(wrong)[0])
                text = f"tick {int(block.numbers('tick')[row])}: {path} is not {allowed} as in the scenario"
                self.agreement.note(path, text, float(block.numbers("effective_plant_ns")[row] / NS_PER_S))

    def _take_names_of_rows(self, block: MessageBlock) -> None:
        for row in np.flatnonzero(self._explanation.misnamed(block)).tolist():
            text = f"tick {int(block.numbers('tick')[row])}: barriers or rows of other names than the filter's"
            self.agreement.note("names", text, float(block.numbers("effective_plant_ns")[row] / NS_PER_S))

    def _check(self, block: MessageBlock, rows: Places, ticks: IntArray, batch: _BoundedFilter) -> None:
        logged = _Logged(block, rows, self._n, self._m, batch, self._period_s, self._is_last.size)
        if not logged.fits:
            self.agreement.note("shape", f"tick {int(ticks[rows[0]])} or after: another number of rows or barriers")
            return
        self._decide(batch, logged, rows.size)
        differences = self._differences(batch, logged, rows.size)
        unsure = batch.scalar[: rows.size].copy()
        shares = [difference / _ALLOWED.get(what, TOLERANCE) for what, difference in differences.items()]
        for row in np.flatnonzero(~(np.max(shares, axis=0) <= 1.0) & ~unsure).tolist():
            if batch.left > 0:  # perhaps there was no input before it
                self._retry(batch, logged, row, differences)
        self.agreement.left_out += int(unsure.sum())
        sure = ~unsure
        self._check_status(block, rows, ticks, batch, sure)
        at_s, numbers = logged.at_s[sure], ticks[rows][sure]
        for what, difference in differences.items():
            allowed = _ALLOWED.get(what, TOLERANCE)
            self.agreement.compare(what, difference[sure], at_s, allowed, lambda row: f"tick {int(numbers[row])}")

    def _check_status(
        self, block: MessageBlock, rows: Places, ticks: IntArray, batch: _BoundedFilter, sure: NDArray[np.bool_]
    ) -> None:
        """Compare statuses that claim a solution with what was found anew."""
        logged = block.numbers("status")[rows]
        found = np.array(STATUS, dtype=np.int64)[batch.status[: rows.size]]
        wrong = sure & np.isin(logged, ANSWERED) & (logged != found)
        for row in np.flatnonzero(wrong).tolist():
            names = FilterStatus(int(logged[row])).name, FilterStatus(int(found[row])).name
            at_s = float(block.numbers("effective_plant_ns")[rows[row]] / NS_PER_S)
            self.agreement.note("status", f"tick {int(ticks[rows[row]])}: {names[0]}, derived {names[1]}", at_s)

    def _decide(self, batch: _BoundedFilter, logged: "_Logged", size: int, *, start: bool = False) -> None:
        def padded(columns: FloatArray) -> FloatArray:
            more = np.repeat(columns[..., -1:], AT_ONCE - size, axis=-1)
            return np.concatenate((columns, more), axis=-1)

        batch.asked = size
        batch.decide(
            padded(logged.x_hat),
            padded(logged.before),
            padded(logged.u_h),
            padded(logged.u_h_rate),
            padded(logged.tank_j),
            padded(logged.at_s),
            None if logged.x_error is None else padded(logged.x_error),
            start=start,
        )

    def _differences(self, batch: _BoundedFilter, logged: "_Logged", size: int) -> dict[str, FloatArray]:
        used = slice(size)
        psi = self._lowest(batch.evaluation.psi[:, used])
        lam = batch.part("lam")[: batch.constraints, used]
        return {
            "u_nominal": relative(logged.u_nominal, batch.program.u_nominal[:, used]),
            "φ": relative(logged.phi, batch.program.phi[:, used]),
            "u": relative(logged.u, batch.evaluation.u_plus[:, used]),
            "ψ": relative(logged.psi[~self._is_last], psi[~self._is_last]),
            "last ψ": relative(logged.psi[self._is_last], psi[self._is_last]),
            "power margin": relative(logged.power_margin, batch.evaluation.h_u[:, used]),
            "margin of a row": self._apart(batch, logged.margin, size),
            "dual of a row": unlike_pull(batch, logged.dual - lam, logged.dual),
            "slack": relative(logged.slack, batch.assessment.slack[:, used]),
            **self._explanation.differences(
                logged.block,
                logged.rows,
                batch.batch.block[:, used].T,
                batch.status[used] == Status.PASSED,
                batch.program.G[: self._m, :, used],
            ),
        }

    def _lowest(self, psi: FloatArray) -> FloatArray:
        """Return ψ₀ … ψ_r of every barrier, the lowest of its members, as ticks have them."""
        parts = [np.min([psi[place] for place in members.places], axis=0) for members in self._barriers]
        return np.concatenate([psi[:0], *parts])

    @staticmethod
    def _apart(batch: _BoundedFilter, margin: FloatArray, size: int) -> FloatArray:
        """Return by how much the margins of rows differ: gradients have unit length, so by no more than the answers."""
        if not margin.shape[0]:
            return np.zeros(size)
        apart = np.abs(margin - batch.evaluation.margins[: batch.constraints, :size]).max(axis=0)
        found: FloatArray = apart / (1 + np.linalg.norm(batch.part("z")[:, :size], axis=0))
        return found

    def _retry(self, batch: _BoundedFilter, logged: "_Logged", row: int, differences: dict[str, FloatArray]) -> None:
        """Replace the differences of a tick by those without an input before it, if they are smaller."""
        one = logged.only(row)
        size = 1
        batch.scalar[:] = False
        core = batch.core
        decision = core.decide(
            one.x_hat[:, 0].tolist(),
            one.before[:, 0].tolist(),
            one.u_h[:, 0].tolist(),
            one.u_h_rate[:, 0].tolist(),
            float(one.tank_j[0]),
            float(one.at_s[0]),
            start=True,
            x_error=None if one.x_error is None else one.x_error[:, 0].tolist(),
        )
        batch.left -= 1
        batch.batch.block[:, 0] = decision.block
        status, batch.status[0] = batch.status[0], decision.status
        found = self._differences(batch, one, size)
        batch.status[0] = status
        if all(value[0] <= _ALLOWED.get(what, TOLERANCE) for what, value in found.items()):
            batch.status[row] = decision.status
            for what, value in found.items():
                differences[what][row] = value[0]


class _Logged:
    """Numbers of ticks, one column a tick."""

    def __init__(
        self, block: MessageBlock, rows: Places, n: int, m: int, batch: BatchFilter, period_s: float, length: int
    ) -> None:
        widths = dict.fromkeys(_VECTORS, m) | {"x_hat": n}
        parts = {path: block.ragged(path).take(rows) for path in _VECTORS}
        psi = block.ragged("barriers.psi").take(rows)
        constraints = batch.constraints
        self.block, self.rows = block, rows
        self.fits = bool(
            all((part.counts == widths[path]).all() for path, part in parts.items())
            and (psi.counts == length).all()
            and (block.numbers("rows.length")[rows] >= constraints).all()
        )
        self.x_hat, self.u, self.u_h, self.u_h_rate, self.u_nominal, self.phi, self.v = (
            parts[path].matrix(widths[path]).T for path in _VECTORS
        )
        self.x_error: FloatArray | None = None
        if batch.core.design.uncertainty is not None:
            self.x_error = block.ragged("x_error").take(rows).matrix(n).T
        self.before = _before(self.u, period_s * (self.v + self.phi))
        self.psi: FloatArray = psi.matrix(length).T
        self.margin: FloatArray = block.ragged("rows.margin").take(rows).matrix(constraints).T
        self.dual: FloatArray = block.ragged("rows.dual").take(rows).matrix(constraints).T
        self.tank_j: FloatArray = block.numbers("tank_j")[rows]
        self.at_s: FloatArray = block.numbers("effective_plant_ns")[rows] * 1e-9
        self.power_margin: FloatArray = block.numbers("power_margin")[None, rows]
        self.slack: FloatArray = block.numbers("slack")[None, rows]

    def only(self, row: int) -> "_Logged":
        """Return the numbers of one tick."""
        one = object.__new__(_Logged)
        for name, value in vars(self).items():
            setattr(one, name, value if name in ("fits", "block") or value is None else value[..., row : row + 1])
        return one


def _before(u: FloatArray, change: FloatArray) -> FloatArray:
    """Return the inputs in force before each decision, exactly where they are zero or the decision before.

    A rounding error would decide between answers that are as good as one another.
    """
    before = u - change
    newest = np.concatenate((before[:, :1], u[:, :-1]), axis=1)
    before = np.where(np.abs(before - newest) <= ROUNDED * (1 + np.abs(newest)), newest, before)
    found: FloatArray = np.where(np.abs(before) <= ROUNDED * (1 + np.abs(u)), 0.0, before)
    return found
