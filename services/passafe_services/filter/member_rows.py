"""Rows that are asked for each end of a parameter's interval, as one barrier to whoever reads a tick."""

import re
from dataclasses import dataclass
from typing import Final

from passafe.filter import SafetyPassivityFilter

_MEMBER: Final = re.compile(r"\[[^\[\]]*=[^\[\]]*\]$")


def without_member(row: str) -> str:
    """Return the name of a row without the end of an interval for which it is asked: ``disk`` of ``disk[mass=0.8]``."""
    return _MEMBER.sub("", row)


@dataclass(frozen=True, kw_only=True, slots=True)
class BarrierMembers:
    """Chains of one barrier, one for each end of a parameter's interval that its rows depend on.

    Attributes:
        name: The barrier's.
        chains: Numbers of the chains in the core.
        places: Places of each chain's ψ₀ … ψ_r in the core's ψ.
    """

    name: str
    chains: tuple[int, ...]
    places: tuple[slice, ...]


def barrier_members(core: SafetyPassivityFilter) -> tuple[BarrierMembers, ...]:
    """Return the chains of every barrier of a filter, in its order."""
    found: dict[str, list[tuple[int, slice]]] = {}
    start = 0
    for number, chain in enumerate(core.chains):
        stop = start + len(chain.psi)
        found.setdefault(without_member(chain.barrier.name), []).append((number, slice(start, stop)))
        start = stop
    return tuple(
        BarrierMembers(name=name, chains=tuple(k for k, _ in members), places=tuple(place for _, place in members))
        for name, members in found.items()
    )
