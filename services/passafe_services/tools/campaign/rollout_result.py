"""What one rollout came to."""

from pydantic import BaseModel, ConfigDict


class RolloutResult(BaseModel):
    """What one rollout came to.

    Attributes:
        seed: What it can be run again with.
        adversary: Who asked.
        h_min: Smallest barrier value, at and between samples.
        tank_min_j: Smallest energy in the tank, J.
        overreach: By how much an input was beyond its limits at most, units of u; 0 or less if none was.
        ticks: Decisions taken.
        statuses: How many of each.
        between_samples_unproven: Certified decisions without the margin of their own neighbourhood.
        decided_singly: Decisions that the filter took one by one.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    seed: int
    adversary: str
    h_min: float
    tank_min_j: float
    overreach: float
    ticks: int
    statuses: dict[str, int]
    between_samples_unproven: int
    decided_singly: int
