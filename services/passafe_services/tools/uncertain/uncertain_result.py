"""The result of one rollout of an uncertain campaign."""

from passafe_services.tools.runs.record import SweepRecord


class UncertainResult(SweepRecord):
    """The result of one rollout.

    Attributes:
        seed: Seed that repeats it.
        operator: Kind of the adversary operator.
        disturbance: Kind of the adversary disturbance.
        h_min: Smallest barrier value, at and between samples.
        gap_m: Distance to the nearest boundary at the end, m.
        guarded_share: Share of ticks in which the guard changed the filter's input; 0 without one.
        fallback_share: Share of ticks in which the last one to decide, filter or guard, had a fallback.
        x_error_max: Largest error of each state that the filter reckoned with.
    """

    seed: int
    operator: str
    disturbance: str
    h_min: float
    gap_m: float
    guarded_share: float
    fallback_share: float
    x_error_max: tuple[float, ...]
