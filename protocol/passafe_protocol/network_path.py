"""Sampler of a network model: which messages are lost, and how long the others take."""

from collections.abc import Callable
from math import exp, sqrt
from statistics import NormalDist
from typing import Final

from passafe_protocol.delay_distribution import histogram
from passafe_protocol.networks import NetworkModel

_NS_PER_S: Final = 1e9
_standard: Final = NormalDist()
_LEAST: Final = 2.0**-53

MOST_STEPS: Final = 10_000
"""Steps that are made one after the other; after a longer pause the state is drawn anew."""


class NetworkPath:
    """One direction of a network in time; time zero is the first message.

    The draws of the state depend on the time that passed alone, those of a message come from a sequence of their own:
    a robot that sends more often meets the same network.

    Args:
        model: The model.
        draw_state: Draws from [0, 1) for delay level and losses.
        draw_reconfiguration: Draws from [0, 1) for reconfigurations.
        draw_message: Draws from [0, 1) for messages, twice for each.
    """

    def __init__(
        self,
        model: NetworkModel,
        draw_state: Callable[[], float],
        draw_reconfiguration: Callable[[], float],
        draw_message: Callable[[], float],
    ) -> None:
        self._model = model
        self._draw_state = draw_state
        self._draw_reconfiguration = draw_reconfiguration
        self._draw_message = draw_message
        self._quantile = histogram(model.quantiles_s)
        self._step_ns = round(model.step_s * _NS_PER_S)
        self._period_ns = round(model.period_s * _NS_PER_S)
        self._a = exp(-model.step_s / model.memory_s) if model.memory_s else 0.0
        self._b = sqrt(1.0 - self._a * self._a)
        self._zero_ns: int | None = None
        self._step = 0
        self._period = 0
        self._gap_ns = 0
        self._offset_s = 0.0
        self._z = 0.0
        self._is_bad = False
        self._level_s = 0.0
        self._phase_ns = int(draw_reconfiguration() * self._period_ns)
        self._draw_anew()

    def passage(self, now_ns: int) -> int | None:
        """Return the delay of a message that is sent now, ns; ``None`` if it is lost."""
        if self._zero_ns is None:
            self._zero_ns = now_ns
        since_ns = now_ns - self._zero_ns
        self._advance(since_ns // self._step_ns)
        is_interrupted = self._period_ns > 0 and self._is_interrupted(since_ns)
        model, chance, jitter = self._model, self._draw_message(), self._draw_message()
        if is_interrupted or chance < (model.loss_bad if self._is_bad else model.loss_good):
            return None
        delay_s = self._level_s + self._offset_s + model.jitter_s * (2.0 * jitter - 1.0)
        return max(0, round(delay_s * _NS_PER_S))

    def _advance(self, step: int) -> None:
        if step - self._step > MOST_STEPS:
            self._draw_anew()
            self._step = step
        while self._step < step:
            self._step += 1
            self._z = self._a * self._z + self._b * self._normal()
            leaves = self._model.burst_leave if self._is_bad else self._model.burst_enter
            if self._draw_state() < leaves:
                self._is_bad = not self._is_bad
        self._level_s = self._quantile(_standard.cdf(self._z))

    def _is_interrupted(self, since_ns: int) -> bool:
        period, into_ns = divmod(since_ns + self._phase_ns, self._period_ns)
        self._period = max(self._period, period - MOST_STEPS)
        while self._period < period:
            self._period += 1
            shortest_s, longest_s = self._model.gap_s
            share, offset = self._draw_reconfiguration(), self._draw_reconfiguration()
            self._gap_ns = round((shortest_s + (longest_s - shortest_s) * share) * _NS_PER_S)
            self._offset_s = self._model.offset_s * (2.0 * offset - 1.0)
        return bool(into_ns < self._gap_ns)

    def _draw_anew(self) -> None:
        """Draw the state from its stationary distribution."""
        self._z = self._normal()
        self._is_bad = self._draw_state() < self._model.bad_share
        self._level_s = self._quantile(_standard.cdf(self._z))

    def _normal(self) -> float:
        return _standard.inv_cdf(min(max(self._draw_state(), _LEAST), 1.0 - _LEAST))
