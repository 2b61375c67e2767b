"""Check of what ticks report of the reasons for their decisions, beside the same computed anew."""

from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from passafe.filter import SafetyPassivityFilter
from passafe.override import ACTIVE_DUAL, Explainer
from passafe_services.filter.member_rows import BarrierMembers, barrier_members
from passafe_services.log.column import Places, Texts
from passafe_services.log.message_block import MessageBlock
from passafe_services.tools.review.agreement import relative
from passafe_services.tools.review.plant_evaluator import FloatArray

_CLEAR: Final = 10.0
"""How many times the push from which a row is active a push has to be, so that no rounding decides about it."""

SLIGHT: Final = 5e-3
"""Share of the change that may be between two answers to one program that the certificate accepts."""


class ExplanationCheck:
    """Differences of logged explanations from those of decisions that were made anew.

    The distance to infeasibility is left out: it is of an earlier decision, and takes a linear program for each.

    Args:
        core: The filter.
    """

    wants: ClassVar[tuple[str, ...]] = (
        *("barriers.name", "barriers.eps", "rows.name", "rows.active", "rows.share", "rows.relaxed"),
        *("override.held_back", "override.allowed_fraction", "override.unavoidable"),
    )

    def __init__(self, core: SafetyPassivityFilter) -> None:
        self._parts = core.layout.parts
        self._m, self._constraints = core.design.system.m, core.constraints
        self._gain = core.design.dt_s * core.design.k_i
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
        contested: NDArray[np.bool_],
        apart: FloatArray,
    ) -> dict[str, FloatArray]:
        """Return the largest difference of each tick by quantity, shape (N,) each.

        Args:
            block: Ticks.
            rows: Those of which decisions were made anew.
            blocks: Blocks of these decisions, shape (N, numbers of a decision).
            passed: Which of them have passed what was asked for, shape (N,).
            contested: Rows whose push may be that of a limit or of a parallel row as well, shape (rows, N).
            apart: Logged inputs less those of the new decisions, both within the certificate's tolerance, shape (m, N).
        """
        found = self._explainer.explain(blocks)
        is_plain = passed & ~found.change.any(axis=1)
        fraction = found.allowed_fraction[:, 0]
        # Held back is the change of the input over a gain, which may be small: that of the logged input is meant.
        gain = np.where(blocks[:, self._parts["start"]] != 0.0, 1.0, self._gain)
        held_back = np.where(is_plain[:, None], found.change, found.held_back + apart.T / gain)
        return {
            "margin ε of a barrier": self._eps(block, rows, blocks),
            **self._of_rows(block, rows, blocks, found.push, found.share, is_plain, contested),
            "held back": relative(block.ragged("override.held_back").take(rows).matrix(self._m).T, held_back.T),
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

    def _of_rows(
        self,
        block: MessageBlock,
        rows: Places,
        blocks: FloatArray,
        push: FloatArray,
        share: FloatArray,
        is_plain: NDArray[np.bool_],
        contested: NDArray[np.bool_],
    ) -> dict[str, FloatArray]:
        count = self._constraints

        def logged(path: str) -> FloatArray:
            found: FloatArray = block.ragged(path).take(rows).matrix(count).T.astype(np.float64)
            return found

        push, share = push[:, :count].T, share[:, :count].T
        active = (push > ACTIVE_DUAL) & ~is_plain
        flags, logged_share = logged("rows.active"), logged("rows.share")
        sure = (is_sure(push, share, flags > 0.0, logged_share) & ~contested) | is_plain
        relaxed = np.zeros((count, rows.size))
        relaxed[: self._hard] = blocks[:, self._parts["relax"]].T
        return {
            "active row": _largest(np.where(sure, np.abs(flags - active), 0.0), rows.size),
            "share of a row": _largest(np.where(sure, np.abs(logged_share - active * share), 0.0), rows.size),
            "relaxed row": relative(logged("rows.relaxed"), relaxed),
        }


def is_sure(
    push: FloatArray, share: FloatArray, logged_active: NDArray[np.bool_], logged_share: FloatArray
) -> NDArray[np.bool_]:
    """Return of which rows it is certain whether they are active, same shape as all arguments.

    Two answers that are both accepted may differ by what the certificate tolerates: one of them may have a slight push
    by a row that the other one has none by.

    Args:
        push: Of every row, computed anew.
        share: Its share of the change, computed anew.
        logged_active: Whether the log calls it active.
        logged_share: Its share in the log.
    """
    is_clear = (push > _CLEAR * ACTIVE_DUAL) | (push < ACTIVE_DUAL / _CLEAR)
    is_slight = ~logged_active & (push > ACTIVE_DUAL) & (np.abs(share) <= SLIGHT)
    is_logged_slight = logged_active & (push <= ACTIVE_DUAL) & (logged_share != 0.0) & (np.abs(logged_share) <= SLIGHT)
    sure: NDArray[np.bool_] = is_clear & ~is_slight & ~is_logged_slight
    return sure


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
