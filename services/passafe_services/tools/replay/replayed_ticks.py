"""Columns of replayed ticks: to the last bit the numbers of ``Telemetry.message``, of many ticks at once.

A message for each of them, to be compared with a decoded one, would take ten times as long as the decision. A test
holds these columns against the messages; and where they differ from the log, the messages decide.
"""

from collections.abc import Sequence
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray
from passafe_protocol.topics import TOPIC_OF_BODY

from passafe.decision import Status
from passafe.numerics.workspace import Array
from passafe.override import ACTIVE_DUAL, Explainer, Explanation
from passafe.program.infeasibility import DistanceToInfeasibility
from passafe_services.filter.build import CompiledFilter
from passafe_services.filter.member_rows import BarrierMembers, barrier_members
from passafe_services.filter.telemetry import TickRecord
from passafe_services.log.column import Column, Ragged, Texts
from passafe_services.log.message_field import LENGTH

Columns = dict[str, Column]


class ReplayedTicks:
    """Makes columns of tick records.

    Args:
        compiled: The filter whose records they are.
    """

    def __init__(self, compiled: CompiledFilter) -> None:
        core = compiled.core
        self._design = core.design
        self._explainer: Explainer = compiled.explainer
        self._row_names, self._constraints = core.row_names, core.constraints
        self._barriers: tuple[BarrierMembers, ...] = barrier_members(core)
        self._parts = core.layout.parts
        self._distance = DistanceToInfeasibility(core.design.limits, core.derivation.rows.hard)
        self._has_eps = bool(core.layout.shapes["eps"][0])

    def columns(self, records: Sequence[TickRecord]) -> Columns:
        """Return the columns of every field of a tick's message but its header's, by path."""
        blocks = np.concatenate([record.decision.block for record in records]).reshape(len(records), -1)
        explanation = self._explainer.explain(blocks)
        is_plain = _numbers([record.decision.status is Status.PASSED for record in records], np.bool_)
        is_plain &= ~explanation.change.any(axis=1)
        return {
            **_of_records(records),
            **self._of_request(blocks, records),
            **self._of_barriers(blocks),
            **self._of_rows(blocks, explanation, is_plain),
            **self._of_override(explanation, is_plain, records),
            **_of_certificate(records),
            **_of_consumed(records),
        }

    def _of_request(self, blocks: Array, records: Sequence[TickRecord]) -> Columns:
        names = {"x_hat": "x", "phi": "phi", "u_nominal": "u_nominal", "v": "v", "x_error": "x_error"}
        names |= {"u_h": "u_h", "u_h_rate": "u_h_rate"}
        found: Columns = {}
        for path, name in names.items():
            found |= _vectors(path, blocks[:, self._parts[name]])
        return {
            **found,
            **_vectors("u", np.array([record.decision.u for record in records])),
            "mode": _same(self._design.mode.value, len(blocks)),
            "law": _same(self._design.law.value, len(blocks)),
            "power_margin": blocks[:, self._parts["h_u"]][:, 0],
        }

    def _of_barriers(self, blocks: Array) -> Columns:
        count, members = len(blocks), self._barriers
        psi, eps = blocks[:, self._parts["psi"]], blocks[:, self._parts["eps"]]
        if not self._has_eps:
            eps = np.zeros((count, sum(len(each.chains) for each in members)))
        lowest = [np.minimum.reduce([psi[:, place] for place in each.places]) for each in members]
        widths = np.array([each.shape[1] for each in lowest], dtype=np.int64)
        largest = [eps[:, list(each.chains)].max(axis=1) for each in members]
        names = tuple(dict.fromkeys(each.name for each in members))
        codes = np.array([names.index(each.name) for each in members], dtype=np.int32)
        return {
            f"barriers.{LENGTH}": np.full(count, len(members)),
            "barriers.name": Texts(_rows_of(np.tile(codes, (count, 1))), names),
            f"barriers.psi.{LENGTH}": _rows_of(np.tile(widths, (count, 1))),
            "barriers.psi": _rows_of(np.concatenate([np.zeros((count, 0)), *lowest], axis=1)),
            "barriers.eps": _rows_of(np.stack(largest, axis=1) if largest else np.zeros((count, 0))),
        }

    def _of_rows(self, blocks: Array, explanation: Explanation[Array], is_plain: NDArray[np.bool_]) -> Columns:
        margins, relax = blocks[:, self._parts["margins"]], blocks[:, self._parts["relax"]]
        active = (explanation.push > ACTIVE_DUAL) & ~is_plain[:, None]
        reported = active | (np.arange(margins.shape[1]) < self._constraints)
        counts = reported.sum(axis=1)
        names = tuple(dict.fromkeys(self._row_names))
        codes = np.array([names.index(name) for name in self._row_names], dtype=np.int32)
        relaxed = np.zeros_like(margins)
        relaxed[:, : relax.shape[1]] = relax
        return {
            f"rows.{LENGTH}": counts,
            "rows.name": Texts(Ragged(np.broadcast_to(codes, margins.shape)[reported], counts), names),
            "rows.margin": Ragged(margins[reported], counts),
            "rows.dual": Ragged(blocks[:, self._parts["lam"]][reported], counts),
            "rows.active": Ragged(active[reported], counts),
            "rows.share": Ragged(np.where(active, explanation.share, 0.0)[reported], counts),
            "rows.relaxed": Ragged(relaxed[reported], counts),
        }

    def _of_override(
        self,
        explanation: Explanation[Array],
        is_plain: NDArray[np.bool_],
        records: Sequence[TickRecord],
    ) -> Columns:
        fraction = explanation.allowed_fraction[:, 0]
        return {
            **_vectors("override.held_back", np.where(is_plain[:, None], explanation.change, explanation.held_back)),
            "override.allowed_fraction": np.where(is_plain, 1.0, np.where(fraction < 0.0, 0.0, fraction)),
            "override.unavoidable": (fraction < 0.0) & ~is_plain,
            "override.distance_to_infeasibility": self._distances(records),
        }

    def _distances(self, records: Sequence[TickRecord]) -> NDArray[Any]:
        """Return the distances to infeasibility at the records' bases, each of which serves a stretch of ticks."""
        bases = [record.basis for record in records]
        begins = [k for k, basis in enumerate(bases) if k == 0 or basis is not bases[k - 1]]
        distances = _numbers([self._distance.of(bases[k]).lower for k in begins], np.float64)
        return np.repeat(distances, np.diff([*begins, len(bases)]))


def _of_records(records: Sequence[TickRecord]) -> Columns:
    return {
        "tick": _numbers([record.tick for record in records], np.uint64),
        "status": _numbers([record.status for record in records], np.int64),
        "effective_plant_ns": _numbers([record.effective_plant_ns for record in records], np.int64),
        "tank_j": _numbers([record.tank_j for record in records], np.float64),
        "slack": _numbers([record.decision.slack for record in records], np.float64),
        "state_age_ns": _numbers([record.state_age_ns for record in records], np.int64),
        "command_age_ns": _numbers([record.request.age_ns for record in records], np.int64),
        "horizon_ns": _numbers([record.horizon_ns for record in records], np.int64),
        "command_state": _texts([record.request.state.value for record in records]),
        "command_share": _numbers([record.request.share for record in records], np.float64),
        "residual": Ragged(
            np.array([*chain.from_iterable(record.residual for record in records)], dtype=np.float64),
            _numbers([len(record.residual) for record in records], np.int64),
        ),
        f"residual.{LENGTH}": _numbers([len(record.residual) for record in records], np.int64),
    }


def _of_certificate(records: Sequence[TickRecord]) -> Columns:
    return {
        "certificate.solver": _texts([record.decision.solver for record in records]),
        "certificate.accepted": _numbers([record.decision.status.is_certified for record in records], np.bool_),
        "certificate.primal_residual": _numbers([record.decision.primal_residual for record in records], np.float64),
        "certificate.dual_residual": _numbers([record.decision.dual_residual for record in records], np.float64),
        "certificate.gap": _numbers([record.decision.gap for record in records], np.float64),
    }


def _of_consumed(records: Sequence[TickRecord]) -> Columns:
    counts = _numbers([len(record.inbox) for record in records], np.int64)
    found = [received for record in records for received in record.inbox]
    topics, words = _coded([TOPIC_OF_BODY[type(received.body)].name for received in found])
    return {
        f"consumed.{LENGTH}": counts,
        "consumed.topic": Texts(Ragged(topics, counts), words),
        "consumed.sequence": Ragged(_numbers([received.header.sequence for received in found], np.uint64), counts),
        "consumed.received_ns": Ragged(_numbers([received.received_ns for received in found], np.int64), counts),
        "consumed.epoch": Ragged(_numbers([received.header.epoch for received in found], np.uint64), counts),
        "consumed.term": Ragged(_numbers([received.term for received in found], np.uint64), counts),
    }


def _numbers(values: Sequence[object], dtype: type[np.generic]) -> NDArray[Any]:
    return np.fromiter(values, dtype, len(values))


def _vectors(path: str, rows: Array) -> Columns:
    return {path: _rows_of(rows), f"{path}.{LENGTH}": np.full(len(rows), rows.shape[1])}


def _rows_of(rows: NDArray[Any]) -> Ragged:
    return Ragged(rows.reshape(-1), np.full(len(rows), rows.shape[1], dtype=np.int64))


def _same(text: str, count: int) -> Texts:
    return Texts(np.zeros(count, dtype=np.int32), (text,))


def _texts(found: Sequence[str]) -> Texts:
    return Texts(*_coded(found))


def _coded(found: Sequence[str]) -> tuple[NDArray[np.int32], tuple[str, ...]]:
    """Return the numbers of texts, and the texts that they number."""
    words = tuple(dict.fromkeys(found))
    number_of = {word: number for number, word in enumerate(words)}
    return _numbers([number_of[text] for text in found], np.int32), words
