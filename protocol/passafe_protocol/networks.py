"""Named models of real networks: values, where they come from, and what was assumed.

Every model runs in time, not per message: a robot at 1 kHz and one at 50 Hz meet the same network. ``docs/networks.md``
has the table, and ``tests/protocol/test_network_statistics.py`` holds each model to its values.
"""

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, kw_only=True, slots=True)
class NetworkModel:
    """One direction of a network, as a chain of short steps of time.

    Delay: a level drawn from quantiles, whose correlation fades with time, plus a uniform jitter of each message. Loss:
    a chain with a good and a bad state that may change once a step. A reconfiguration, if there is one, interrupts the
    link and draws another offset of the delay.

    Attributes:
        name: Its name.
        title: One line.
        source: Where the values come from.
        assumed: What the source does not say and was assumed.
        step_s: Length of a step.
        quantiles_s: Delays at equal steps of probability, linear between them, s.
        memory_s: Time in which the correlation of the level fades to 1/e; 0: every step draws anew.
        jitter_s: Half width of each message's own part, s.
        burst_enter: Probability per step of going from good to bad.
        burst_leave: Probability per step of going from bad to good.
        loss_good: Probability of losing a message in the good state.
        loss_bad: Probability of losing one in the bad state.
        period_s: Time between reconfigurations; 0: none.
        gap_s: Shortest and longest interruption at one, uniform.
        offset_s: Largest change of the delay by one: uniform in ±offset_s.
    """

    name: str
    title: str
    source: str
    assumed: str
    step_s: float
    quantiles_s: tuple[float, ...]
    memory_s: float = 0.0
    jitter_s: float = 0.0
    burst_enter: float = 0.0
    burst_leave: float = 1.0
    loss_good: float = 0.0
    loss_bad: float = 1.0
    period_s: float = 0.0
    gap_s: tuple[float, float] = (0.0, 0.0)
    offset_s: float = 0.0

    @property
    def bad_share(self) -> float:
        """Share of time in the bad state: p/(p + r)."""
        return self.burst_enter / (self.burst_enter + self.burst_leave)

    @property
    def loss_share(self) -> float:
        """Share of messages that are lost, those in interruptions included."""
        bad = self.bad_share
        lost = bad * self.loss_bad + (1.0 - bad) * self.loss_good
        gap = sum(self.gap_s) / 2.0 / self.period_s if self.period_s else 0.0
        return gap + (1.0 - gap) * lost

    @property
    def mean_delay_s(self) -> float:
        """Mean delay: the mean of the linear quantile function."""
        ends = (self.quantiles_s[0] + self.quantiles_s[-1]) / 2.0
        return (ends + sum(self.quantiles_s[1:-1])) / (len(self.quantiles_s) - 1)

    @property
    def longest_delay_s(self) -> float:
        """Longest delay that it can have, s."""
        return self.quantiles_s[-1] + self.jitter_s + self.offset_s


_HALF: Final = "half of a round trip for each direction"
_SATELLITE: Final = (
    "values given as requirements; such terminals were measured by Laniewski et al., Starlink on the Road (2024), and "
    "by Asad Ullah et al., Starlink in Northern Europe (2025), whose tables were not at hand"
)
_RANGE: Final = "values given as requirements; no public measurement with just these was found"

NETWORKS: Final = {
    model.name: model
    for model in (
        NetworkModel(
            name="leo-moving",
            title="Satellite terminal on a moving vehicle, open sky",
            source=f"round trips with a mean of 44 ms; {_SATELLITE}",
            assumed=f"{_HALF}; 2 s of memory; 2 % of the time obstructed, 0.5 s on average, 60 % lost meanwhile",
            step_s=0.02,
            quantiles_s=(0.012, 0.015, 0.016, 0.017, 0.018, 0.019, 0.02, 0.022, 0.023, 0.028, 0.072),
            memory_s=2.0,
            jitter_s=0.001,
            burst_enter=0.04 * 0.02 / 0.98,
            burst_leave=0.04,
            loss_good=0.002,
            loss_bad=0.6,
        ),
        NetworkModel(
            name="leo-moving-obstructed",
            title="Satellite terminal on a moving vehicle, trees and bridges",
            source=f"round trips with a mean of 92 ms, 470 ms at worst, loss up to 60 %; {_SATELLITE}",
            assumed=f"{_HALF}; 1 s of memory; 30 % of the time obstructed, 2 s on average, 60 % lost meanwhile",
            step_s=0.02,
            quantiles_s=(0.014, 0.018, 0.021, 0.025, 0.029, 0.034, 0.04, 0.045, 0.054, 0.07, 0.234),
            memory_s=1.0,
            jitter_s=0.001,
            burst_enter=0.01 * 0.3 / 0.7,
            burst_leave=0.01,
            loss_good=0.01,
            loss_bad=0.6,
        ),
        NetworkModel(
            name="leo-reconfiguring",
            title="Satellite terminal at rest: another satellite every 15 s",
            source="handover every 15 s: Zhao et al., Demystifying Starlink Network Performance under Vehicular "
            "Mobility (2026)",
            assumed=f"{_HALF}; 20 to 120 ms of interruption and ±8 ms of delay at each",
            step_s=0.02,
            quantiles_s=(0.016, 0.018, 0.019, 0.02, 0.021, 0.022, 0.023, 0.025, 0.027, 0.031, 0.045),
            memory_s=0.3,
            jitter_s=0.001,
            burst_enter=0.0005,
            burst_leave=0.5,
            loss_good=0.001,
            period_s=15.0,
            gap_s=(0.02, 0.12),
            offset_s=0.008,
        ),
        NetworkModel(
            name="lte-driving",
            title="LTE while driving",
            source="Neumeier et al., Measuring the Feasibility of Teleoperated Driving in Mobile Networks (2019): "
            "variable delays with rare outliers, worst at handovers",
            assumed=f"{_HALF}, 55 ms on average; 0.5 s of memory; 0.3 s of loss every 60 s on average",
            step_s=0.01,
            quantiles_s=(0.013, 0.017, 0.019, 0.021, 0.022, 0.024, 0.026, 0.029, 0.033, 0.039, 0.077),
            memory_s=0.5,
            jitter_s=0.002,
            burst_enter=0.01 / 60.0,
            burst_leave=0.01 / 0.3,
            loss_good=0.001,
            loss_bad=0.8,
        ),
        NetworkModel(
            name="5g-driving",
            title="5G, non-standalone, while driving",
            source="Testouri et al., 5G-Enabled Teleoperated Driving (2025): round trips of 47 ms, jitter of 0.7 ms, "
            "no losses; Ghoshal et al., Performance of Cellular Networks on the Wheels (2023): poor stretches, too",
            assumed=f"{_HALF}; 0.5 s of memory; 0.2 s of loss every 120 s on average",
            step_s=0.01,
            quantiles_s=(0.018, 0.0205, 0.0213, 0.0219, 0.0223, 0.0227, 0.0231, 0.0237, 0.024, 0.0252, 0.0426),
            memory_s=0.5,
            jitter_s=0.0007,
            burst_enter=0.01 / 120.0,
            burst_leave=0.01 / 0.2,
            loss_good=0.0005,
            loss_bad=0.8,
        ),
        NetworkModel(
            name="aircraft-calm",
            title="Link to a remotely piloted aircraft, good conditions",
            source=f"Gilbert-Elliott with p = 0.01 and r = 0.5, 100 to 400 ms; {_RANGE}",
            assumed="a step of 20 ms, as packets at 50 Hz; delays uniform, 5 s of memory",
            step_s=0.02,
            quantiles_s=(0.1, 0.4),
            memory_s=5.0,
            burst_enter=0.01,
            burst_leave=0.5,
        ),
        NetworkModel(
            name="aircraft-rough",
            title="Link to a remotely piloted aircraft, bad conditions",
            source=f"Gilbert-Elliott with p = 0.08 and r = 0.08, 100 to 400 ms; {_RANGE}",
            assumed="a step of 20 ms, as packets at 50 Hz; delays uniform, 5 s of memory",
            step_s=0.02,
            quantiles_s=(0.1, 0.4),
            memory_s=5.0,
            burst_enter=0.08,
            burst_leave=0.08,
        ),
        *(
            NetworkModel(
                name=f"transcontinental-{delay_ms}ms",
                title=f"Wired long-distance line, {delay_ms} ms",
                source=f"{delay_ms} ms, one of 15, 114, 134 and 160 ms; {_RANGE}",
                assumed="one way; jitter of 1 ms; one message in 10,000 lost",
                step_s=0.02,
                quantiles_s=(delay_ms * 1e-3, delay_ms * 1e-3),
                jitter_s=0.001,
                loss_good=0.0001,
            )
            for delay_ms in (15, 114, 134, 160)
        ),
    )
}
"""Every model by its name."""
