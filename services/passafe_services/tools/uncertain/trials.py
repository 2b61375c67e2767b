"""The trials of an uncertain campaign: what the plant may do otherwise, how the network delays, and what protects."""

from dataclasses import dataclass
from itertools import product
from typing import Final

from passafe.uncertainty import Uncertainty

SETS: Final = {
    "disturbance": Uncertainty(disturbance=(0.0, 0.0, 0.5, 0.5)),
    "mass": Uncertainty(parameters={"mass": (0.8, 1.2)}),
    "damping": Uncertainty(parameters={"sigma": (0.8, 1.2)}),
    "noise": Uncertainty(state_error=(1e-3, 1e-3, 1e-2, 1e-2)),
    "together": Uncertainty(
        parameters={"mass": (0.95, 1.05), "sigma": (0.8, 1.2)},
        disturbance=(0.0, 0.0, 0.3, 0.3),
        state_error=(1e-3, 1e-3, 1e-2, 1e-2),
    ),
}
"""Sets by name, for a damped point in the plane: x = (position, velocity)."""

SCENARIOS: Final = ("notomista-cai-2020", "walls-and-disks")

PROTECTIONS: Final = ("none", "rows", "guard", "both")
"""The model's rows alone; rows for the sets in the filter; those in a guard at the plant; or in both.

The model's rows alone are those of empty sets: outside of the protected set no courses are compared."""


@dataclass(frozen=True, kw_only=True, slots=True)
class DelayedLink:
    """A network as the loop has it once inputs are played out in time.

    Attributes:
        name: Its name.
        input_delay_s: From a decision to its effect: the largest delay, since inputs are played out then.
        state_low_s: Least delay of a state.
        state_high_s: Largest delay of a state.
        state_loss: Share of the states that are lost; lost inputs are repeated in time.
    """

    name: str
    input_delay_s: float
    state_low_s: float
    state_high_s: float
    state_loss: float


LINKS: Final = {
    link.name: link
    for link in (
        DelayedLink(name="none", input_delay_s=0.0, state_low_s=0.0, state_high_s=0.0, state_loss=0.0),
        DelayedLink(name="100+100", input_delay_s=0.1, state_low_s=0.1, state_high_s=0.1, state_loss=0.0),
        DelayedLink(name="200+200", input_delay_s=0.25, state_low_s=0.15, state_high_s=0.25, state_loss=0.2),
    )
}
"""Links by name: no delay; 100 ms each way; 200 ms ± 50 ms each way with 20 % loss."""


@dataclass(frozen=True, kw_only=True, slots=True)
class UncertainTrial:
    """One combination, of which many rollouts are made.

    Attributes:
        scenario: Name of a shipped scenario of a damped point.
        sets: Name of the sets.
        link: Name of the link.
        protection: Name of what protects.
    """

    scenario: str
    sets: str
    link: str
    protection: str

    @property
    def name(self) -> str:
        """All four names, for files and tables."""
        return f"{self.scenario}.{self.sets}.{self.link}.{self.protection}"

    @property
    def has_robust_filter(self) -> bool:
        """True if the filter's rows hold for the sets."""
        return self.protection in {"rows", "both"}

    @property
    def has_guard(self) -> bool:
        """True if a guard stands at the plant."""
        return self.protection in {"guard", "both"}

    @property
    def is_promised(self) -> bool:
        """True if h ≥ 0 is claimed."""
        return self.protection != "none"


def all_trials() -> list[UncertainTrial]:
    """Return every combination, one scenario after the other."""
    return [
        UncertainTrial(scenario=scenario, sets=sets, link=link, protection=protection)
        for scenario, sets, link, protection in product(SCENARIOS, SETS, LINKS, PROTECTIONS)
    ]
