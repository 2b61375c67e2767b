"""Cells of an experiment, and the single runs that they are made of."""

from collections.abc import Mapping
from itertools import product
from typing import NamedTuple

from pydantic import JsonValue

from passafe_services.tools.experiment.schema import Experiment
from passafe_services.tools.runs.record import SweepRecord


class RunKey(NamedTuple):
    """The key of a run among those of its experiment.

    Attributes:
        cell: Number of the cell.
        probe: Value of the axis that is bisected, if one is.
        seed: Seed.
    """

    cell: int
    probe: float | None
    seed: int


class Cell(SweepRecord):
    """A variant with one value of every listed axis.

    Attributes:
        number: From 0, in the order of ``cells_of``.
        variant: Name.
        values: Value of each axis with listed values, by the axis' name.
    """

    number: int
    variant: str
    values: dict[str, JsonValue]

    def describe(self) -> str:
        """Return a short text for people."""
        return ", ".join((self.variant, *(f"{name} = {displayed(value)}" for name, value in self.values.items())))


class Run(SweepRecord):
    """One run of an experiment.

    Attributes:
        cell: Number of its cell.
        variant: Name.
        values: Value of every axis, by name.
        probe: Value of the axis that is bisected, if one is.
        seed: Decides random axes, links, start and operator.
    """

    cell: int
    variant: str
    values: dict[str, JsonValue]
    probe: float | None
    seed: int

    @property
    def key(self) -> RunKey:
        """Its key."""
        return RunKey(self.cell, self.probe, self.seed)


def cells_of(experiment: Experiment) -> list[Cell]:
    """Return every combination of variant and listed values, the last axis varying fastest."""
    names = [axis.name for axis in experiment.grid]
    combinations = product(experiment.variants, *(axis.values for axis in experiment.grid))
    return [
        Cell(number=number, variant=str(variant), values=dict(zip(names, values, strict=True)))
        for number, (variant, *values) in enumerate(combinations)
    ]


def run_of(experiment: Experiment, cell: Cell, seed: int, probe: float | None = None) -> Run:
    """Return one run of a cell.

    Args:
        experiment: The experiment.
        cell: One of its cells.
        seed: Which of the cell's runs.
        probe: Value of the axis that is bisected, if one is.
    """
    values: dict[str, JsonValue] = dict(cell.values)
    for axis in experiment.random:
        values[axis.name] = axis.draw(seed)
    if experiment.bisected is not None:
        values[experiment.bisected.name] = probe
    return Run(cell=cell.number, variant=cell.variant, values=values, probe=probe, seed=seed)


def displayed(value: JsonValue) -> str:
    """Return a value of an axis as text."""
    if isinstance(value, float):
        return f"{value:g}"
    return ", ".join(map(str, value.values())) if isinstance(value, Mapping) else str(value)
