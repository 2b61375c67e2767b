"""Titles of the metrics that a comparison sets side by side, in the order in which they are read."""

from typing import Final

METRIC_TITLES: Final = {
    "duration_s": "duration, s",
    "ticks": "ticks",
    "h_min": "smallest h",
    "power_margin_min": "smallest power margin, W",
    "tank_min_j": "smallest tank energy, J",
    "u_norm_max": "largest ‖u‖",
    "state_age_ms_p50": "age of state p50, ms",
    "state_age_ms_p99": "age of state p99, ms",
    "command_age_ms_p50": "age of command p50, ms",
    "command_age_ms_p99": "age of command p99, ms",
    "overridden_share": "ticks overridden",
    "held_back_share": "held back of u_h",
    "time_to_target_s": "time to target, s",
    "steering_rms_error": "rms error to targets",
}
"""Titles by the name of the metric."""
