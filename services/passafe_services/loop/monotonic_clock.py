"""Identity of the monotonic clock that this process reads."""

from functools import cache
from hashlib import blake2b
from pathlib import Path
from typing import Final

from passafe_protocol.messages import UNKNOWN_CLOCK

BOOT: Final = Path("/proc/sys/kernel/random/boot_id")
"""Identity of the running kernel: its monotonic clock counts from its boot."""

TIME_NAMESPACE: Final = Path("/proc/self/ns/time")
"""Linux time namespace of the process, which may shift the clock in a container."""


def clock_id_of(boot: Path, time_namespace: Path) -> int:
    """Return a number that processes have in common if, and only if, they read the same monotonic clock.

    Args:
        boot: File with the identity of the running kernel.
        time_namespace: Symbolic link to the process' time namespace.

    Returns:
        64 bits of a hash of both, not 0; 0 where the system does not tell: then nothing is assumed of the clock.
    """
    try:
        text = f"{boot.read_text()} {time_namespace.readlink()}"
    except OSError:
        return UNKNOWN_CLOCK
    return int.from_bytes(blake2b(text.encode(), digest_size=8).digest(), "big") or 1


@cache
def monotonic_clock_id() -> int:
    """Return ``clock_id_of`` this process: processes of one host share it, containers included."""
    return clock_id_of(BOOT, TIME_NAMESPACE)
