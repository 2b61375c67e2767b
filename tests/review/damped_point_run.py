"""A run in closed form for the review's tests: ẋ₁ = x₂, ẋ₂ = −σx₂ + u, V = ‖x‖², h = ‖x₁‖² − 1.

Nothing of the core is used, so that what a review recomputes is compared with formulas written down twice.
"""

import math
import tomllib
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray
from passafe_protocol.codec import encode
from passafe_protocol.messages import (
    Certificate,
    Consumed,
    FilterStatus,
    FilterTick,
    Header,
    Message,
    OperatorCommand,
    PlantInput,
    PlantPhase,
    PlantState,
)
from passafe_protocol.topics import TOPIC_OF_BODY
from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.scenarios.schema import Scenario

SIGMA = 1.0
GAIN = 10.0
PERIOD_NS = 1_000_000
WALL_NS = 1_763_800_000_000_000_000
PAPER = Path(__file__).parents[2] / "services" / "passafe_services" / "scenarios" / "notomista-cai-2020.toml"

CERTIFIED = Certificate("piqp", accepted=True, primal_residual=1e-12, dual_residual=1e-12, gap=1e-12)

Array = NDArray[np.float64]


def scenario(*, mode: str = "both", kind: str = "power", **filter_keys: object) -> Scenario:
    """Return the paper's scenario with another mode, kind of passivity or other keys of its filter."""
    content: dict[str, Any] = tomllib.loads(PAPER.read_text())
    content["filter"] |= {"mode": mode, **filter_keys}
    content["filter"]["passivity"]["kind"] = kind
    return Scenario.model_validate(content)


class DampedPoint:
    """``PlantMathematics`` in closed form."""

    def h(self, x: Array, _t_s: Array) -> Array:
        """‖x₁‖² − 1."""
        return np.sum(x[:2] ** 2, axis=0, keepdims=True) - 1

    def h_error(self, x: Array, _t_s: Array, x_error: Array) -> Array:
        """Four roundings of ‖x₁‖² and 1, and 2‖x₁‖₁ times the error of a coordinate."""
        error: Array = 4e-16 * (np.sum(x[:2] ** 2, axis=0) + 1) + 2 * np.abs(x[:2]).sum(axis=0) * x_error
        return error[None]

    protected = ("ψ0 of disk", "ψ1 of disk")

    def psi(self, x: Array, t_s: Array) -> Array:
        """h, and ḣ + 10 h."""
        h = self.h(x, t_s)
        return np.vstack([h, 2 * np.sum(x[:2] * x[2:], axis=0) + GAIN * h])

    def flow_error(self, x: Array, _u: Array, _duration_s: float) -> Array:
        """Zero: the flow is exact."""
        return np.zeros(x.shape[1])

    def energy_gain(self, x: Array, u: Array, duration_s: float) -> Array:
        """∫x₂ᵀu − ΔV: the way times the input, and ‖x‖² before minus after."""
        after = self.flow(x, u, duration_s)
        gain: Array = np.sum((after[:2] - x[:2]) * u, axis=0) + np.sum(x * x, axis=0) - np.sum(after * after, axis=0)
        return gain

    def output(self, x: Array) -> Array:
        """x₂."""
        return x[2:]

    def stored(self, x: Array) -> Array:
        """‖x‖²."""
        stored: Array = np.sum(x * x, axis=0)
        return stored

    def supplied(self, x: Array, u: Array, duration_s: float) -> Array:
        """∫x₂ᵀu dt: the way times the input."""
        supplied: Array = np.sum((self.flow(x, u, duration_s)[:2] - x[:2]) * u, axis=0)
        return supplied

    def power_margin(self, x: Array, u: Array) -> Array:
        """X₂ᵀu − V̇ with V̇ = 2x₁ᵀx₂ + 2x₂ᵀ(−σx₂ + u)."""
        p, q = x[:2], x[2:]
        margin: Array = np.sum(q * u, axis=0) - np.sum(2 * p * q + 2 * q * (u - SIGMA * q), axis=0)
        return margin

    def flow(self, x: Array, u: Array, duration_s: float) -> Array:
        """x₂ decays towards u/σ, x₁ is its integral."""
        decay = math.exp(-SIGMA * duration_s)
        reach = (1 - decay) / SIGMA
        p = x[:2] + reach * x[2:] + (duration_s - reach) / SIGMA * u
        return np.concatenate([p, decay * x[2:] + reach * u])


def header(source: str, sequence: int, *, epoch: int = 1, step: int | None = None) -> Header:
    """Header of a message made in time by a step; one step a period."""
    at_ns = PERIOD_NS * (sequence if step is None else step)
    return Header(source, epoch, sequence, at_ns, at_ns, at_ns, WALL_NS + at_ns)


def state(step: int, x: Iterable[float], u: Iterable[float], **keys: object) -> PlantState:
    """State at plant time ``step`` periods."""
    x = tuple(map(float, x))
    fields: dict[str, Any] = {
        "plant_ns": step * PERIOD_NS,
        "x": x,
        "y": x[2:],
        "u": tuple(map(float, u)),
        "applied_tick": step + 1,
        "phase": PlantPhase.RUNNING,
        "energy_in_j": 0.0,
        "energy_stored_j": sum(value * value for value in x),
        "input_lead_ns": 0,
        "inputs_late": 0,
        "inputs_refused": 0,
        "integration_error": 0.0,
        "received_tick": step + 1,
    }
    return PlantState(**fields | keys)


def tick(step: int, u: Iterable[float], **keys: object) -> FilterTick:
    """Filter tick ``step + 1``, whose own telemetry reports no problem."""
    u = tuple(map(float, u))
    fields: dict[str, Any] = {
        "tick": step + 1,
        "status": FilterStatus.MODIFIED,
        "mode": "both",
        "law": "sampled",
        "effective_plant_ns": step * PERIOD_NS,
        "x_hat": (9.0, 9.0, 0.0, 0.0),
        "u_h": u,
        "u_h_rate": (0.0, 0.0),
        "u_nominal": u,
        "phi": (0.0, 0.0),
        "v": (0.0, 0.0),
        "u": u,
        "barriers": (),
        "power_margin": 99.0,
        "tank_j": 9.0,
        "slack": 0.0,
        "rows": (),
        "certificate": CERTIFIED,
        "consumed": (Consumed(topic="command", epoch=1, sequence=step, received_ns=step * PERIOD_NS),),
        "state_age_ns": 0,
        "command_age_ns": 0,
    }
    return FilterTick(**fields | keys)


@dataclass
class Run:
    """Messages of a run, to be written as a log.

    Attributes:
        scenario: The scenario.
        driver: live or lockstep.
        planned_s: Plant time that it is to last, s.
        sent: Header and body of each message, in the order in which it was sent.
    """

    scenario: Scenario = field(default_factory=scenario)
    driver: str = "live"
    planned_s: float | None = None
    sent: list[tuple[Header, Message]] = field(default_factory=list)

    def add(self, head: Header, body: Message) -> None:
        """Send one message."""
        self.sent.append((head, body))

    def replace(self, index: int, **keys: object) -> None:
        """Change fields of one body."""
        head, body = self.sent[index]
        self.sent[index] = (head, replace(body, **keys))

    def indices(self, body: type[Message]) -> list[int]:
        """Return the indices of the messages with this body."""
        return [index for index, (_, found) in enumerate(self.sent) if isinstance(found, body)]

    def write(self, path: Path, *, without: Callable[[Header, Message], bool] = lambda _h, _b: False) -> Path:
        """Write the log, leaving out some messages."""
        metadata = run_metadata(
            scenario_json=self.scenario.model_dump_json(),
            versions={"passafe": "0.1.0"},
            driver="live" if self.driver == "live" else "lockstep",
            planned_s=self.planned_s,
        )
        with LogWriter(path, metadata) as log:
            for head, body in self.sent:
                if not without(head, body):
                    key = TOPIC_OF_BODY[type(body)].key(head.source)
                    log.write(key, encode(head, body), sequence=head.sequence, wall_ns=head.wall_ns)
        return path


def rollout(
    run: Run, *, x0: Iterable[float], u: Callable[[int], Iterable[float]], steps: int, period: int = 1
) -> list[Array]:
    """Let the plant run under inputs u(k) and add what operator, filter and plant send at every step.

    Args:
        run: Where the messages go.
        x0: State at plant time 0.
        u: Input in force over period k.
        steps: How many samples.
        period: Length of a period in ticks' periods.

    Returns:
        The states.
    """
    x = np.array(tuple(x0), dtype=np.float64)
    model, states, energy_in_j = DampedPoint(), [], 0.0
    for k in range(steps):
        held = np.array(tuple(u(k)), dtype=np.float64)
        run.add(header("operator", k), OperatorCommand(tuple(held), (), enabled=True, device="lag"))
        run.add(header("filter", k), PlantInput(k + 1, tuple(held), k * period * PERIOD_NS, PERIOD_NS))
        run.add(header("filter", k), tick(k, held, effective_plant_ns=k * period * PERIOD_NS))
        run.add(
            header("plant", k),
            state(k * period, x, held, applied_tick=k + 1, energy_in_j=energy_in_j),
        )
        states.append(x)
        duration_s = period * PERIOD_NS * 1e-9
        after = model.flow(x, held, duration_s)
        # ∫x₂ᵀu dt = (p(t + dt) − p(t))ᵀu while u is held.
        energy_in_j += float((after[:2] - x[:2]) @ held)
        x = after
    return states
