"""Where an obstacle that moves is at a plant time, in plain numbers."""

from math import cos, pi, sin

from passafe_services.scenarios.barrier_schema import Motion, Swing, Travel


def displacement(motion: Motion | None, t_s: float) -> tuple[float, float]:
    """How far an obstacle is from where the scenario has it, m; nothing for one that stands still.

    Args:
        motion: How it moves.
        t_s: Plant time, s.
    """
    if motion is None:
        return 0.0, 0.0
    if isinstance(motion, Travel):
        v1, v2 = motion.velocity_m_per_s
        return v1 * t_s, v2 * t_s
    angle = 2 * pi * motion.frequency_hz * t_s + motion.phase_rad
    if isinstance(motion, Swing):
        a1, a2 = motion.amplitude_m
        return a1 * sin(angle), a2 * sin(angle)
    return motion.radius_m * cos(angle), motion.radius_m * sin(angle)
