"""Check of what ticks report of the reasons for their decisions, beside the same computed anew."""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from passafe.filter import SafetyPassivityFilter
from passafe.override import ACTIVE_DUAL, Explainer
from passafe_services.filter.member_rows import BarrierMembers, barrier_members
from passafe_services.log.column import Places, Texts
from passafe_services.log.message_block import MessageBlock
from passafe_services.tools.review.agreement import relative
from passafe_services.tools.review.plant_evaluator import FloatArray


class ExplanationCheck:
    """Differences of logged explanations from what follows from their ticks, and from decisions that were made anew.

    The distance to infeasibility is left out: it is of an earlier decision, and takes a linear program for each.

    Args:
        core: The filter.
    """

    wants: ClassVar[tuple[str, ...]] = (
        *("v", "u", "u_nominal"),
        *("barriers.name", "barriers.eps", "rows.name", "rows.dual", "rows.active", "rows.share", "rows.relaxed"),
        *("override.held_back", "override.allowed_fraction", "override.unavoidable"),
    )

    def __init__(self, core: SafetyPassivityFilter) -> None:
        self._parts = core.layout.parts
        self._m, self._constraints = core.design.system.m, core.constraints
        self._k_i, self._dt_s = core.design.k_i, core.design.dt_s
        self._explainer = Explainer(core)
        self._hard = core.derivation.rows.hard
        self._barriers: tuple[BarrierMembers, ...] = barrier_members(core)
        self._barrier_names = tuple(each.name for each in self._barriers)
        self._row_names = tuple(core.row_names)
        self._has_eps = bool(core.layout.shapes["eps"][0])

    def misnamed(self, block: MessageBlock) -> NDArray[np.bool_]:
        """Return which ticks name their barriers or rows otherwise than the filter does, shape (N,)."""
        barriers = _named(block.texts("barriers.name"), self._barrier_names, len(self._barrier_names))
        return barriers | _named(block.texts("rows.name"), self._row_names, self._constraints)

    def differences(
        self,
        block: MessageBlock,
        rows: Places,
        blocks: FloatArray,
        passed: NDArray[np.bool_],
        gradients: FloatArray,
    ) -> dict[str, FloatArray]:
        """Return the largest difference of each tick by quantity, shape (N,) each.

        Args:
            block: Ticks.
            rows: Those of which decisions were made anew.
            blocks: Blocks of these decisions, shape (N, numbers of a decision).
            passed: Which of them have passed what was asked for, shape (N,).
            gradients: Gradients of the rows, without slack, shape (m, rows, N).
        """
        found = self._explainer.explain(blocks)
        is_plain = passed & ~found.change.any(axis=1)
        fraction = found.allowed_fraction[:, 0]
        return {
            "margin ε of a barrier": self._eps(block, rows, blocks),
            **self._of_rows(block, rows, blocks, gradients),
            "held back": self._held_back(block, rows, blocks),
            "allowed fraction": np.abs(
                block.numbers("override.allowed_fraction")[rows] - np.where(is_plain, 1.0, np.maximum(fraction, 0.0))
            ),
            "unavoidable": (block.numbers("override.unavoidable")[rows] != ((fraction < 0.0) & ~is_plain)).astype(
                float
            ),
        }

    def _eps(self, block: MessageBlock, rows: Places, blocks: FloatArray) -> FloatArray:
        eps = blocks[:, self._parts["eps"]]
        found = [eps[:, list(each.chains)].max(axis=1) if self._has_eps else eps[:, :0] for each in self._barriers]
        logged = block.ragged("barriers.eps").take(rows).matrix(len(self._barriers)).T
        return relative(logged, np.stack(found) if self._has_eps and found else np.zeros_like(logged))

    def _held_back(self, block: MessageBlock, rows: Places, blocks: FloatArray) -> FloatArray:
        """Return differences of what was held back from what the change of the input says, v = k_i · held back."""
        v, u, u_nominal, logged = (
            block.ragged(path).take(rows).matrix(self._m).T for path in ("v", "u", "u_nominal", "override.held_back")
        )
        start = blocks[:, self._parts["start"]].T
        return relative(logged, np.where(start, u - u_nominal, v / self._k_i))

    def _of_rows(
        self, block: MessageBlock, rows: Places, blocks: FloatArray, gradients: FloatArray
    ) -> dict[str, FloatArray]:
        """Return differences of what ticks say of rows from what follows from their duals and from what they held back.

        It follows from the answer of the tick: another one that the certificate accepts as well may push by other rows.
        """

        def logged(path: str, count: int = self._constraints) -> FloatArray:
            found: FloatArray = block.ragged(path).take(rows).matrix(count).T.astype(np.float64)
            return found

        dual = logged("rows.dual")
        active = dual > ACTIVE_DUAL
        ratio, along = self._push(dual, logged("override.held_back", self._m), blocks, gradients)
        relaxed = np.zeros((self._constraints, rows.size))
        relaxed[: self._hard] = blocks[:, self._parts["relax"]].T
        return {
            "active row": _largest(np.abs(logged("rows.active") - active), rows.size),
            "share of a row": _largest(np.abs(logged("rows.share") - active * ratio * along) / (1 + ratio), rows.size),
            "relaxed row": relative(logged("rows.relaxed"), relaxed),
        }

    def _push(
        self, dual: FloatArray, held_back: FloatArray, blocks: FloatArray, gradients: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return each push over the size of the change, and the part of the row's gradient along the change."""
        start = blocks[:, self._parts["start"]].T
        size = np.linalg.norm(held_back, axis=0)
        change = np.where(start, 1.0, self._k_i * self._dt_s) * size
        is_changed = (size > 0.0) & (change > 0.0)
        unit = np.divide(held_back, size, where=is_changed, out=np.zeros_like(held_back))
        ratio = np.divide(np.abs(dual), change, where=np.broadcast_to(is_changed, dual.shape), out=np.zeros_like(dual))
        return ratio, np.einsum("kce,ke->ce", gradients, unit)


def _largest(difference: FloatArray, size: int) -> FloatArray:
    return difference.max(axis=0) if difference.shape[0] else np.zeros(size)


def _named(texts: Texts, names: tuple[str, ...], count: int) -> NDArray[np.bool_]:
    """Return which ticks do not have the first ``count`` names, shape (N,)."""
    codes = texts.codes
    if isinstance(codes, np.ndarray):
        raise TypeError("names: got one a message, allowed lists")
    number_of = {word: number for number, word in enumerate(texts.words)}
    expected = np.array([number_of.get(name, -1) for name in names[:count]], dtype=np.int64)
    wrong: NDArray[np.bool_] = codes.counts < count
    if count:
        wrong |= (codes.matrix(count) != expected).any(axis=1)
    return wrong
