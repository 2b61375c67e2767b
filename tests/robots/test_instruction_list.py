"""Expressions as instruction lists: the same bits on return, and nothing but formulas in."""

import json
import random
from math import inf, nan
from typing import Any

import casadi as ca
import numpy as np
import pytest
from passafe_services.scenarios.robots.instruction_list import MOST_DEPTH, expressions_of, listed
from passafe_services.scenarios.robots.operations import ARITY, applied

from passafe.errors import DesignError

X = ca.SX.sym("x", 3)
EVERY = ca.vertcat(*(applied(name, [X[0], X[1]][:arity]) for name, arity in ARITY.items()))


def bits(expression: ca.SX, symbols: ca.SX, at: np.ndarray[Any, Any]) -> bytes:
    return bytes(np.ascontiguousarray(ca.Function("value", [symbols], [expression])(at).full()).tobytes())


def test_every_operation_returns_with_the_same_bits() -> None:
    y = ca.SX.sym("y", 3)
    other = expressions_of(listed({"x": X}, {"all": EVERY}), {"x": y})["all"]

    for at in np.random.default_rng(1).uniform(0.05, 0.95, size=(100, 3)):
        assert bits(other, y, at) == bits(EVERY, X, at)


def test_shared_parts_are_listed_once() -> None:
    chain = X[0]
    for _ in range(40):
        chain = chain * chain + X[1]  # 2⁴⁰ terms if written out

    assert len(json.loads(listed({"x": X}, {"h": chain}))["instructions"]) < 100


def test_empty_columns_return_empty() -> None:
    text = listed({"x": X, "theta": ca.SX(0, 1)}, {"none": ca.SX(0, 1), "h": X[2]})

    assert expressions_of(text, {"x": X})["none"].shape == (0, 1)


def test_list_of_a_list_is_the_list() -> None:
    text = listed({"x": X}, {"all": EVERY})

    assert listed({"x": X}, expressions_of(text, {"x": X})) == text


@pytest.mark.parametrize("number", [nan, inf, -inf])
def test_number_that_is_not_finite_is_named_with_its_part(number: float) -> None:
    with pytest.raises(DesignError, match=rf"^robot storage: got {number} in its formula, allowed finite numbers$"):
        listed({"x": X}, {"f": X[0] * 2.0, "storage": ca.vertcat(X[0], X[1] + number)})


def test_function_that_is_called_is_refused() -> None:
    called = ca.Function("table", [X], [ca.sin(X)], {"never_inline": True}).call([X], False, True)[0]
    with pytest.raises(DesignError, match="called, not written out"):
        listed({"x": X}, {"h": called})


def with_instruction(*instructions: object, outputs: object = None) -> str:
    return json.dumps({"instructions": instructions, "outputs": {"h": [0]} if outputs is None else outputs})


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "{" * 100_000,
        with_instruction(outputs=[]),
        with_instruction(["x", 3]),
        with_instruction(["x", -1]),
        with_instruction(["x", True]),
        with_instruction(["x", 0.0]),
        with_instruction(["y", 0]),
        with_instruction(["number", "nan"]),
        with_instruction(["number", "inf"]),
        with_instruction(["number", 1]),
        with_instruction(["number", "0x1p+99999"]),
        with_instruction(["external", 0]),
        with_instruction(["call", 0]),
        with_instruction(["sin", 0]),
        with_instruction(["x", 0], ["sin", 1]),
        with_instruction(["x", 0], ["add", 0]),
        with_instruction("sin"),
        with_instruction(None),
        with_instruction(["x", 0], outputs={"h": [1]}),
        with_instruction(["x", 0], outputs={"h": 0}),
        with_instruction(["x", 0], outputs={"h": [0] * 5000}),
        with_instruction(*[["x", 0]] * 65_537),
        with_instruction(["x", 0], *(["sin", k] for k in range(MOST_DEPTH + 1))),
    ],
)
def test_what_is_no_list_of_formulas_is_refused(text: str) -> None:
    with pytest.raises(DesignError, match="robot: got"):
        expressions_of(text, {"x": X})


def test_mutated_lists_are_formulas_or_refused() -> None:
    """CasADi's own format ends the process in 4 of 60 of such cases."""
    text, rng = listed({"x": X}, {"all": EVERY}), random.Random(1)
    for _ in range(500):
        at = rng.randrange(len(text))
        mutated = text[:at] + rng.choice('0123456789,"[]ex-+') + text[at + 1 :]
        try:
            made = expressions_of(mutated, {"x": X})
        except DesignError:
            continue
        for expression in made.values():
            ca.Function("value", [X], [expression])([0.1, 0.2, 0.3])


def test_deepest_list_can_be_printed() -> None:
    deepest = with_instruction(["x", 0], *(["sin", k] for k in range(MOST_DEPTH)), outputs={"h": [MOST_DEPTH]})

    assert str(expressions_of(deepest, {"x": X})["h"]).count("sin") == MOST_DEPTH
