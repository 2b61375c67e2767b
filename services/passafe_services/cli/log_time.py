"""Log times in words."""

from datetime import UTC, datetime


def log_time(wall_ns: int) -> str:
    """Return the time of day in UTC of a log time, Unix time in ns; the number itself if it is no date."""
    try:
        at = datetime.fromtimestamp(wall_ns // 1_000_000_000, UTC)
    except (ValueError, OverflowError, OSError):
        return f"{wall_ns} ns"
    return f"{at:%H:%M:%S}.{wall_ns % 1_000_000_000 // 1_000_000:03d}"
