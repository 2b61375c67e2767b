"""Turns the options of ``passafe feasibility`` into the slice and the box of states that they describe."""

import re
from collections.abc import Sequence
from math import isfinite
from typing import Final

from passafe_services.cli.errors import OptionError
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.feasibility.errors import FeasibilityError
from passafe_services.tools.feasibility.grid import Grid, GridCoordinate

EITHER_SIDE: Final = 3.0
"""The box of a scenario that gives none: ±3 in every coordinate, as for campaigns."""

_COORDINATE: Final = re.compile(r"x(\d{1,3})")


def grid_of(scenario: Scenario, axes: str, fix: Sequence[str], ranges: Sequence[str], cells: int) -> Grid:
    """Return the slice of the state space that the options describe.

    Args:
        scenario: The scenario; its x0 fixes the coordinates that no option names.
        axes: Two coordinates with a comma between them, ``x0,x1``.
        fix: Values of other coordinates, ``NAME=VALUE``.
        ranges: ``LOW,HIGH`` of both axes, or one for each; none: the scenario's box.
        cells: Number of cells along each axis.

    Raises:
        OptionError: A text of another form, or a coordinate that the model does not have.
    """
    n = len(scenario.plant.x0)
    names = axes.split(",")
    if len(names) != len(("across", "up")):
        raise OptionError("--axes", repr(axes), "two coordinates such as x0,x1")
    across, up = (_coordinate("--axes", name, n) for name in names)
    fixed = list(scenario.plant.x0)
    for text in fix:
        name, equals, value = text.partition("=")
        if not equals:
            raise OptionError("--fix", repr(text), "NAME=VALUE such as x2=-0.5")
        index = _coordinate("--fix", name, n)
        if index in {across, up}:
            raise OptionError("--fix", repr(text), f"a coordinate other than those of --axes, {axes}")
        [fixed[index]] = _numbers("--fix", value, (1,))
    both = [_numbers("--range", text, (2,)) for text in ranges]
    if len(both) > len(names):
        raise OptionError("--range", f"{len(both)} of them", "one for both axes, or one for each")
    box = tuple(zip(*box_of(scenario, None, None), strict=True))
    first, second = (both * 2)[:2] if both else (box[across], box[up])
    try:
        return Grid(
            across=GridCoordinate(index=across, low=first[0], high=first[1]),
            up=GridCoordinate(index=up, low=second[0], high=second[1]),
            fixed=tuple(fixed),
            cells=cells,
        )
    except FeasibilityError as error:
        option = "--range" if error.field.startswith("range") else "--axes"
        raise OptionError(option, error.got, error.allowed) from error


def box_of(scenario: Scenario, low: str | None, high: str | None) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return the least and the largest corner of the box of random states.

    Args:
        scenario: The scenario; its box is taken where an option is not given.
        low: One number, or one for each coordinate.
        high: Likewise.

    Raises:
        OptionError: A text of another form, or a least corner above the largest.
    """
    n = len(scenario.plant.x0)
    lowest = scenario.plant.start_low or (-EITHER_SIDE,) * n
    highest = scenario.plant.start_high or (EITHER_SIDE,) * n
    lowest = lowest if low is None else _corner("--low", low, n)
    highest = highest if high is None else _corner("--high", high, n)
    for each, other in zip(lowest, highest, strict=True):
        if not each <= other:
            raise OptionError("--low, --high", f"{each:g} above {other:g}", "a box with room in it")
    return lowest, highest


def _corner(option: str, text: str, n: int) -> tuple[float, ...]:
    numbers = _numbers(option, text, (1, n))
    return numbers * n if len(numbers) == 1 else numbers


def _numbers(option: str, text: str, lengths: Sequence[int]) -> tuple[float, ...]:
    wanted = f"{' or '.join(map(str, lengths))} finite numbers, with commas between them"
    try:
        numbers = tuple(float(part) for part in text.split(","))
    except ValueError as error:
        raise OptionError(option, repr(text), wanted) from error
    if len(numbers) not in lengths or not all(map(isfinite, numbers)):
        raise OptionError(option, repr(text), wanted)
    return numbers


def _coordinate(option: str, name: str, n: int) -> int:
    match = _COORDINATE.fullmatch(name.strip())
    if match is None or int(match[1]) >= n:
        raise OptionError(option, repr(name), f"x0 to x{n - 1}, the states of the model")
    return int(match[1])


def with_gain(scenario: Scenario, gain: float | None) -> Scenario:
    """Return the scenario with one gain for every class-K function of its barriers; unchanged if there is none.

    Raises:
        OptionError: A gain outside its range.
    """
    if gain is None:
        return scenario
    if not 0.0 < gain <= 1e6:  # noqa: PLR2004 - the range of a gain in a scenario file
        raise OptionError("--gain", gain, "above 0, up to 1e6")
    barriers = []
    for barrier in scenario.filter.barriers:
        chain = tuple(each.model_copy(update={"gain": gain}) for each in barrier.class_k)
        barriers.append(barrier.model_copy(update={"class_k": chain}))
    return scenario.model_copy(update={"filter": scenario.filter.model_copy(update={"barriers": tuple(barriers)})})
