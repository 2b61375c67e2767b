"""Arguments of decisions and plants: every kind of vector of numbers counts as one, and nothing else does."""

from array import array
from collections.abc import Sequence
from decimal import Decimal
from fractions import Fraction
from math import inf, isnan, nan

import casadi as ca
import numpy as np
import pytest
from core_designs import jerk_design, paper_design

from passafe.arguments.numbers import numbers, one_number, vectors
from passafe.errors import ShapeError
from passafe.filter import SafetyPassivityFilter
from passafe.models.damped_point import damped_point
from passafe.sampled_plant import SampledPlant

PAPER = SafetyPassivityFilter(paper_design())
JERK = SafetyPassivityFilter(jerk_design())
X, U, U_H, RATE = (1.5, 0.25, -2.0, 0.5), (-3.0, 1.0), (-40.0, 8.0), (0.5, 0.0)


class Stubborn:
    """Claims to convert to an array, and does not."""

    def __array__(self, *_: object, **__: object) -> None:
        raise ValueError("no")


class Guarded:
    """Refuses to become an array as a tensor with a gradient does."""

    def __array__(self, *_: object, **__: object) -> None:
        raise RuntimeError("detach it first")


class Keyed(Sequence[float]):
    """Claim to have four elements, and have none."""

    def __len__(self) -> int:
        return 4

    def __getitem__(self, place: object) -> float:  # type: ignore[override]  # broken, which is the point
        raise KeyError(place)


ENDLESS: list[object] = []
ENDLESS.append(ENDLESS)

FORMS = {
    "list": list,
    "column": lambda v: np.array(v)[:, None],
    "row": lambda v: np.array(v)[None, :],
    "vector": np.array,
    "single precision": lambda v: np.array(v, dtype=np.float32),
    "half precision": lambda v: np.array(v, dtype=np.float16),
    "long double": lambda v: np.array(v, dtype=np.longdouble),
    "strided": lambda v: np.repeat(v, 2)[::2],
    "DM": ca.DM,
    "DM row": lambda v: ca.DM(v).T,
    "array": lambda v: array("d", v),
    "single scalars": lambda v: tuple(map(np.float32, v)),
    "fractions": lambda v: tuple(map(Fraction, v)),
    "decimals": lambda v: [Decimal(each) for each in v],
    "vectors of one": lambda v: [[each] for each in v],
    "arrays of one": lambda v: tuple(np.array([each]) for each in v),
    "DM of one": lambda v: [ca.DM(each) for each in v],
    "a row of a list": lambda v: [list(v)],
    "memory": lambda v: memoryview(array("d", v)),
    "objects": lambda v: np.array(v, dtype=object),
    "without a mask": lambda v: np.ma.array(v, mask=False),
}

NO_NUMBERS = {
    "None": None,
    "a string": "1234",
    "bytes": b"1234",
    "strings": ("1", "2", "3", "4"),
    "a string among numbers": (1.0, "far", 1.0, 1.0),
    "None among numbers": (1.0, None, 1.0, 1.0),
    "complex": np.array([1j, 0, 0, 0]),
    "complex among numbers": (1j, 0.0, 0.0, 0.0),
    "objects": (object(), object(), object(), object()),
    "an object": object(),
    "a mapping": {0: 1.0, 1: 1.0, 2: 1.0, 3: 1.0},
    "a set": {1.0, 2.0, 3.0, 4.0},
    "two axes": np.ones((2, 2)),
    "rows": [[1.0, 2.0], [3.0, 4.0]],
    "ragged": [[1.0], [3.0, 4.0], 1.0, 1.0],
    "SX": ca.SX.sym("x", 4),
    "MX": ca.MX.sym("x", 4),
    "objects of NumPy": np.array([ca.SX.sym("x"), 1.0, 1.0, 1.0], dtype=object),
    "MX in a tuple": (ca.MX.sym("x"), 1.0, 1.0, 1.0),
    "what refuses": Stubborn(),
    "a tensor with a gradient": Guarded(),
    "a sequence without elements": Keyed(),
    "a list in itself": ENDLESS,
    "behind a mask": np.ma.array([1.0, 2.0, 3.0, 4.0], mask=[True, False, False, False]),
    "a function": lambda: 1.0,
    "too large an integer": (10**400, 0, 0, 0),
    "a signalling NaN": (Decimal("sNaN"), 0, 0, 0),
    "dates": np.array(["2026-01-01"] * 4, dtype="datetime64[D]"),
    "a generator": (each for each in X),
}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.filterwarnings("error")
def test_every_kind_of_vector_is_the_same_request(form: str) -> None:
    given = [FORMS[form](each) for each in (X, U, U_H, RATE)]  # type: ignore[operator]  # of many types

    assert PAPER.decide(*given).block.tobytes() == PAPER.decide(X, U, U_H, RATE).block.tobytes()


@pytest.mark.parametrize("name", NO_NUMBERS)
@pytest.mark.parametrize("place", range(4))
def test_anything_else_is_one_typed_error(name: str, place: int) -> None:
    request: list[object] = [X, U, U_H, RATE]
    request[place] = NO_NUMBERS[name]

    with pytest.raises(ShapeError) as refused:
        PAPER.decide(*request)  # type: ignore[arg-type]  # a wrong type is the point

    assert refused.value.field == ("x", "u", "u_h", "u_h_rate")[place]
    assert ": got " in str(refused.value)
    assert refused.value.allowed.startswith("numbers")
    assert len(str(refused.value)) < 300


def test_one_input_may_be_a_number() -> None:
    x = (0.1, 0.2, 0.3)

    as_number = JERK.decide(x, np.float32(0.5), 2, ca.DM(0.25))  # type: ignore[arg-type]  # a number for a vector of one
    assert as_number.block.tobytes() == JERK.decide(x, (0.5,), (2.0,), (0.25,)).block.tobytes()
    with pytest.raises(ShapeError, match="lengths 4, 1, 2, 2, allowed lengths 4, 2, 2, 2"):
        PAPER.decide(X, 1.0, U_H, RATE)  # type: ignore[arg-type]  # wrong on purpose


@pytest.mark.parametrize("tank", [0.5, np.array([0.5]), ca.DM(0.5), np.float32(0.5), [0.5], Fraction(1, 2)])
def test_a_number_may_be_a_vector_of_one(tank: object) -> None:
    given = PAPER.decide(X, U, U_H, RATE, tank, tank)  # type: ignore[arg-type]  # of many types

    assert given.block.tobytes() == PAPER.decide(X, U, U_H, RATE, 0.5, 0.5).block.tobytes()


@pytest.mark.parametrize("field", ["tank_j", "t_s", "start"])
@pytest.mark.parametrize("value", [None, "1", (1.0, 2.0), (), 1j, ca.SX.sym("s")])
def test_what_is_not_one_number_is_refused(field: str, value: object) -> None:
    with pytest.raises(ShapeError, match=f"^{field}: got .*, allowed one number$"):
        PAPER.decide(X, U, U_H, RATE, **{field: value})  # type: ignore[arg-type]  # wrong on purpose


def test_a_refused_request_leaves_no_trace() -> None:
    before = PAPER.decide(X, U, U_H, RATE)
    with pytest.raises(ShapeError):
        PAPER.decide(X, U, ("a", "b"), RATE)  # type: ignore[arg-type]  # wrong on purpose

    assert PAPER.decide(X, U, U_H, RATE).block.tobytes() == before.block.tobytes()


def test_plants_take_the_same_vectors() -> None:
    plant = SampledPlant(damped_point().system, ca.sumsqr(damped_point().system.x) * 0, 1e-3)
    expected = plant.advance(X, U)

    for form in FORMS.values():
        assert plant.advance(form(X), form(U)) == expected  # type: ignore[operator]  # of many types
        assert plant.at(form(X)).x == X  # type: ignore[operator]  # of many types
    for x, u in ((X, ("hard", 0.0)), (None, U), ("1234", U), ((1j,) * 4, U)):
        with pytest.raises(ShapeError, match=r"^(x|u): got "):
            plant.advance(x, u)  # type: ignore[arg-type]  # wrong on purpose
    with pytest.raises(ShapeError, match=r"^x: got "):
        plant.at(None)  # type: ignore[arg-type]  # wrong on purpose


def test_numbers_that_are_not_finite_stay_what_they_are() -> None:
    found = numbers("x", [inf, -inf, nan, np.float16(-inf), True])

    assert found[:2] == (inf, -inf)
    assert isnan(found[2])
    assert found[3:] == (-inf, 1.0)
    assert numbers("x", np.array([np.longdouble("1e4000")])) == (inf,)


def test_the_message_says_what_was_given() -> None:
    messages = []
    for value in (np.ones((2, 3)), ca.DM.ones(2, 2), None, "far"):
        with pytest.raises(ShapeError) as refused:
            vectors({"x": value}, (4,))
        messages.append(str(refused.value.got))

    assert messages[0] == "an array of float64 of shape (2, 3)"
    assert messages[1:] == ["a casadi.DM of shape (2, 2)", "None", "'far' (str)"]
    with pytest.raises(ShapeError, match="bound: got 'x'"):
        one_number("bound", "x")


def test_a_start_may_be_an_array_of_one() -> None:
    given = PAPER.decide(X, U, U_H, RATE, start=np.array([True]))  # type: ignore[arg-type]  # wrong on purpose

    assert given.block.tobytes() == PAPER.decide(X, U, U_H, RATE, start=True).block.tobytes()


def test_the_message_has_one_line() -> None:
    class Lines(list[float]):
        def __repr__(self) -> str:
            return "two\nlines"

    with pytest.raises(ShapeError) as refused:
        numbers("x", Lines([1j]))  # type: ignore[list-item]  # wrong on purpose

    assert "\n" not in str(refused.value)
