"""Filters that compete in ``filter_step.py``: each turns a request into the input to hold over the next period.

All solve one program, that of the sampled law without margins between samples. With u_ref = clip(u + dt·φ, ±B):
minimise ½‖u⁺ − u_ref‖² + ½ρδ² subject to ψ₂(x, u⁺) ≥ 0, h_u(x, u⁺) + δ ≥ 0 and |u⁺| ≤ B.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Protocol

from passafe_services.scenarios.design import design_of, robot_of
from passafe_services.scenarios.schema import Scenario

from passafe import Decision, SafetyPassivityFilter


class Request(NamedTuple):
    """Arguments of one filter step, as ``SafetyPassivityFilter.decide`` takes them."""

    x: tuple[float, ...]
    u: tuple[float, ...]
    u_h: tuple[float, ...]
    u_h_rate: tuple[float, ...]


class Contender(Protocol):
    """One filter step, set up and ready.

    Attributes:
        name: In the table.
        differs: What it does more, less or otherwise than passafe.
        tolerance: How far its u⁺ may be from that of passafe, relative to 1 + ‖u⁺‖; ``None`` for another program.
    """

    name: str
    differs: str
    tolerance: float | None

    def prepare(self, request: Request) -> tuple[Any, ...]:
        """Return the arguments of ``step`` in the types that this contender reads fastest; not timed."""
        ...

    def step(self, *arguments: Any) -> Any:  # noqa: ANN401 - every library has its own types
        """Return whatever holds the answer, computed to the end; this is what is timed."""
        ...

    def answer(self, result: Any) -> Sequence[float]:  # noqa: ANN401 - what ``step`` returned
        """Return u⁺ from a result, m numbers; not timed."""
        ...


class Passafe:
    """``SafetyPassivityFilter.decide``, with or without margins between samples."""

    def __init__(self, scenario: Scenario, *, margins: bool) -> None:
        """Derive the filter of a scenario."""
        self.name = "passafe with margins" if margins else "passafe"
        self.differs = "certified; returns ψ, h_u, margins, duals, slack and residuals too"
        if margins:
            self.differs = f"another program, h ≥ 0 between samples too; {self.differs}"
        self.tolerance: float | None = None if margins else 0.0
        config = scenario.filter.model_copy(update={"between_samples": margins})
        scenario = scenario.model_copy(update={"filter": config})
        self.step: Callable[..., Decision] = SafetyPassivityFilter(design_of(scenario, robot_of(scenario))).decide

    def prepare(self, request: Request) -> tuple[Any, ...]:
        """Return the request as it is."""
        return tuple(request)

    def answer(self, result: Decision) -> Sequence[float]:
        """Return the decision's u."""
        return result.u
