"""Barrier chains for all members of a family of plants: one for each end at which a row has to be kept."""

from collections.abc import Iterator

from passafe.barrier_chain import Barrier, BarrierChain, derive_chains
from passafe.design import FilterDesign
from passafe.margins.plant_family import PlantFamily


def design_chains(design: FilterDesign, family: PlantFamily | None) -> Iterator[BarrierChain]:
    """Yield the chains of a design, in the order of its barriers.

    Args:
        design: The design.
        family: The plants for which rows are to hold; ``None`` for the model alone.
    """
    for barrier in design.barriers:
        yield from derive_chains(design.system, barrier) if family is None else _member_chains(family, barrier)


def _member_chains(family: PlantFamily, barrier: Barrier) -> Iterator[BarrierChain]:
    """Yield the chains of a barrier, each once for every combination of ends, which its name then states."""
    for chain in derive_chains(family.system, barrier, family.reserve):
        rates = (family.system.general_rate(branch.psi[-2]) for branch in chain.branches)
        ends = {each.name: each for rate in rates for each in family.ends(rate)}
        for text, system in family.members(tuple(ends.values())).items():
            name = f"{chain.barrier.name}[{text}]" if text else chain.barrier.name
            yield chain.on_member(system, name)
