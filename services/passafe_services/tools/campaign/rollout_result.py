"""The result of one rollout."""

from passafe_services.tools.runs.record import SweepRecord


class RolloutResult(SweepRecord):
    """The result of one rollout.

    Attributes:
        seed: Seed that repeats it.
        adversary: Name of the adversary operator.
        h_min: Smallest barrier value, at and between samples.
        tank_min_j: Smallest energy in the tank, J.
        overreach: By how much an input was beyond its limits at most, units of u; 0 or less if none was.
        ticks: Decisions taken.
        statuses: How many of each.
        between_samples_unproven: Certified decisions without the margin of their own neighbourhood.
        decided_scalar: Decisions that the filter took by itself, not in a batch.
    """

    seed: int
    adversary: str
    h_min: float
    tank_min_j: float
    overreach: float
    ticks: int
    statuses: dict[str, int]
    between_samples_unproven: int
    decided_scalar: int
