"""Expressions as a list of elementary instructions: data that any program can read and check before it is used.

CasADi's own ``Function.deserialize`` is not used on data from outside: a blob may name a shared library to load or a
source to compile, and one wrong digit can end the process (``docs/decisions/0035-robot-in-the-log.md``).
"""

import json
from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Any, Final

import casadi as ca

from passafe.errors import DesignError
from passafe_services.scenarios.robots.operations import ARITY, NAMES, applied

MOST_INSTRUCTIONS: Final = 65_536
MOST_DEPTH: Final = 1_000
"""Longest chain of instructions of which each needs the one before: CasADi prints expressions by recursion."""

MOST_OUTPUTS: Final = 4_096
CONSTANT: Final = "number"

Expressions = Mapping[str, ca.SX]
"""Columns of scalars by name."""


def listed(symbols: Expressions, expressions: Expressions) -> str:
    """Return expressions as the JSON text of an instruction list.

    Args:
        symbols: Columns of symbols by name.
        expressions: Columns of expressions of these symbols alone, by name.

    Raises:
        DesignError: An operation or a number that no list may hold, or a list that is too long or too deep.
    """
    column = ca.densify(ca.vertcat(ca.SX(0, 1), *expressions.values()))
    function = ca.Function("listed", [ca.vertcat(ca.SX(0, 1), *symbols.values())], [column], {"cse": True})
    names = [(name, k) for name, symbol in symbols.items() for k in range(symbol.numel())]
    instructions: list[list[Any]] = []
    made_by: dict[int, int] = {}
    flat = [-1] * column.numel()
    for k in range(function.n_instructions()):
        number, reads = function.instruction_id(k), function.instruction_input(k)
        if number == ca.OP_OUTPUT:
            flat[function.instruction_output(k)[1]] = made_by[reads[0]]
            continue
        if number == ca.OP_INPUT:
            instructions.append([*names[reads[1]]])
        elif number == ca.OP_CONST:
            value = float(function.instruction_constant(k))
            if not isfinite(value):
                raise DesignError(f"robot {_holder(expressions)}", f"{value} in its formula", "finite numbers")
            instructions.append([CONSTANT, value.hex()])
        elif number in NAMES:
            instructions.append([NAMES[number], *(made_by[place] for place in reads)])
        else:
            raise DesignError("robot", "a function that is called, not written out", "formulas in casadi.SX")
        made_by[function.instruction_output(k)[0]] = len(instructions) - 1
    outputs: dict[str, list[int]] = {}
    for name, expression in expressions.items():
        outputs[name], flat = flat[: expression.numel()], flat[expression.numel() :]
    text = json.dumps({"instructions": instructions, "outputs": outputs}, separators=(",", ":"))
    expressions_of(text, symbols)
    return text


def _holder(expressions: Expressions) -> str:
    """Return the name of the first expression that contains a number that is not finite."""
    for name, expression in expressions.items():
        function = ca.Function("part", ca.symvar(expression), [ca.densify(expression)])
        constants = (k for k in range(function.n_instructions()) if function.instruction_id(k) == ca.OP_CONST)
        if not all(isfinite(function.instruction_constant(k)) for k in constants):
            return name
    return "function"


def expressions_of(text: str, symbols: Expressions) -> dict[str, ca.SX]:
    """Return the columns of expressions that an instruction list holds, by name.

    Every instruction is checked before the first one is applied, so that no list, whoever wrote it, does more than
    compute formulas.

    Args:
        text: The list, as ``listed`` returns it.
        symbols: Columns of symbols by name, as they were given to it.

    Raises:
        DesignError: The text is no instruction list, or one that is too long or too deep.
    """
    instructions, outputs = _parsed(text)
    _check_size(instructions, outputs)
    depths: list[int] = []
    for place, instruction in enumerate(instructions):
        depths.append(_checked(instruction, place, symbols, depths))
    if max(depths, default=0) > MOST_DEPTH:
        raise DesignError("robot", f"{max(depths)} operations in a row", f"at most {MOST_DEPTH}")
    made: list[ca.SX] = []
    for head, *rest in instructions:
        if head in symbols:
            made.append(symbols[head][rest[0]])
        elif head == CONSTANT:
            made.append(ca.SX(float.fromhex(rest[0])))
        else:
            made.append(applied(head, [made[place] for place in rest]))
    return {name: ca.vertcat(ca.SX(0, 1), *(made[place] for place in places)) for name, places in outputs.items()}


def _parsed(text: str) -> tuple[list[list[Any]], dict[str, list[int]]]:
    try:
        data = json.loads(text)
    except (ValueError, RecursionError):
        data = None
    if isinstance(data, dict) and data.keys() == {"instructions", "outputs"}:
        instructions, outputs = data["instructions"], data["outputs"]
        if isinstance(instructions, list) and isinstance(outputs, dict):
            return instructions, outputs
    raise DesignError("robot", "a text of another form", "an instruction list")


def _check_size(instructions: Sequence[object], outputs: Mapping[str, object]) -> None:
    if len(instructions) > MOST_INSTRUCTIONS:
        raise DesignError("robot", f"{len(instructions)} operations", f"at most {MOST_INSTRUCTIONS}")
    total = 0
    for name, places in outputs.items():
        if not isinstance(places, list) or not all(_is_index(place, len(instructions)) for place in places):
            raise DesignError("robot", f"output {name!r} of another form", "places of instructions")
        total += len(places)
    if total > MOST_OUTPUTS:
        raise DesignError("robot", f"{total} outputs", f"at most {MOST_OUTPUTS}")


def _checked(instruction: Any, place: int, symbols: Expressions, depths: Sequence[int]) -> int:  # noqa: ANN401 - a stranger may have written it
    """Return the depth of an instruction; refuse any but a symbol, a finite number, or an operation of earlier ones."""
    match instruction:
        case [str(head), index] if head in symbols and _is_index(index, symbols[head].numel()):
            return 0
        case ["number", str(text)] if _is_finite(text):
            return 0
        case [str(head), *arguments] if ARITY.get(head) == len(arguments):
            if all(_is_index(argument, place) for argument in arguments):
                deepest: int = max(depths[argument] for argument in arguments)
                return 1 + deepest
    raise DesignError("robot", f"instruction {place} of another form", "an elementary operation of earlier ones")


def _is_index(value: object, end: int) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < end


def _is_finite(text: str) -> bool:
    try:
        return isfinite(float.fromhex(text))
    except (ValueError, OverflowError):
        return False
