"""Parts of a design in every form in which people write them, and the typed errors for all others."""

from collections.abc import Callable, Sequence
from decimal import Decimal
from typing import Never

import casadi as ca
import numpy as np
import pytest
from cart_designs import CART, U, X, cart, decided
from core_designs import gains

from passafe.admissible_shapes import NormBound
from passafe.barrier_chain import Barrier
from passafe.barriers import box, disk_keep_out, separation, speed_limit
from passafe.checks.design_check import check_design
from passafe.checks.row_share import StateBox
from passafe.class_k import Cubic, Linear
from passafe.design import Law, Mode
from passafe.errors import DesignError, ShapeError
from passafe.filter import SafetyPassivityFilter
from passafe.models.damped_point import damped_point
from passafe.parameter import Parameter
from passafe.passivity import Passivity
from passafe.sampled_plant import SampledPlant
from passafe.system import System
from passafe.tank import Tank
from passafe.uncertainty import Uncertainty


def test_matrix_expressions_are_named_as_such() -> None:
    p, q = ca.MX.sym("p", 2), ca.MX.sym("q")
    makers = {
        "system x": lambda: System(x=p, u=U, f=X, y=X[1]),
        "system u": lambda: System(x=X, u=q, f=X, y=X[1]),
        "system f": lambda: System(x=X, u=U, f=ca.vertcat(p[1], q), y=X[1]),
        "system y": lambda: System(x=X, u=U, f=X, y=[q]),
        "barrier 'wall' h": lambda: Barrier(name="wall", h=q, class_k=gains(1.0)),
        "storage V": lambda: Passivity(V=q),
        "u_fb": lambda: cart(u_fb=q),
        "fail_safe": lambda: cart(fail_safe=[q]),
        "coordinates of disk centre": lambda: disk_keep_out(p, centre=(0.0, 0.0), radius=1.0),
        "speed limit velocity": lambda: speed_limit(p, limit=1.0),
    }
    for part, make in makers.items():
        with pytest.raises(DesignError) as refused:
            make()
        assert refused.value.field == part
        assert "build it from casadi.SX.sym" in refused.value.allowed


def test_dynamics_may_be_sequences() -> None:
    listed = System(x=[*ca.vertsplit(X)], u=[U], f=[X[1], U], y=(X[1],))  # type: ignore[arg-type]  # sequences

    assert (str(listed.f), listed.n, listed.m) == (str(CART.f), 2, 1)
    for part in ("x", "u", "f", "y"):
        with pytest.raises(DesignError, match=f"^system {part}: got 'fast'"):
            System(**({"x": X, "u": U, "f": X, "y": X[1]} | {part: "fast"}))
    with pytest.raises(ShapeError, match=r"system f: got shape \(1, 1\)"):
        System(x=X, u=U, f=[X[1]], y=X[1])  # type: ignore[arg-type]  # a sequence


def test_gains_stand_for_linear_functions() -> None:
    mixed = Barrier(name="wall", h=1 - X[0], class_k=[2, np.float32(3.0), Cubic(gain=1.0)])  # type: ignore[arg-type]  # a list

    assert mixed.class_k == (Linear(gain=2.0), Linear(gain=3.0), Cubic(gain=1.0))
    assert Passivity(V=X[0] ** 2, class_k=7).class_k == Linear(gain=7.0)  # type: ignore[arg-type]  # a number


@pytest.mark.parametrize("class_k", [2.0, "222", None, (2.0, None), ("2", "2"), [lambda s: s], (2.0, -1.0), (0.0,)])
def test_other_class_k_functions_are_refused(class_k: object) -> None:
    with pytest.raises(DesignError, match="class"):
        Barrier(name="wall", h=1 - X[0], class_k=class_k)  # type: ignore[arg-type]  # wrong on purpose


def test_a_constant_barrier_has_no_relative_degree() -> None:
    with pytest.raises(DesignError, match="do not contain the input"):
        SafetyPassivityFilter(cart(barriers=[Barrier(name="one", h=1.0, class_k=(1.0, 1.0, 1.0))]))  # type: ignore[arg-type]  # numbers


def test_a_constant_storage_is_a_number() -> None:
    made = SafetyPassivityFilter(cart(passivity=Passivity(V=0.0)))  # type: ignore[arg-type]  # a number

    assert made.decide((0.0, 0.5), (2.0,), (0.0,), (0.0,)).power_margin != 0.0
    assert SampledPlant(CART, 3, 1e-3).at((0.0, 0.0)).stored_j == 3.0  # type: ignore[arg-type]  # a number


@pytest.mark.parametrize("bound", [np.float32(20), np.array(20.0), np.int64(20), 20, [20.0], ca.DM([20.0])])
def test_bounds_may_be_numbers_of_any_kind(bound: object) -> None:
    assert decided(cart(input_bound=bound)) == decided(cart())


def test_gains_and_periods_may_be_numbers_of_any_kind() -> None:
    assert decided(cart(k_i=np.float32(50), dt_s=np.array(1e-3))) == decided(cart())
    assert isinstance(cart(k_i=50).k_i, float)


@pytest.mark.parametrize("name", ["k_i", "dt_s", "hold_s", "input_bound", "input_norm_bound", "input_rate_bound_per_s"])
@pytest.mark.parametrize("value", ["20", b"20", 1j, (None,), {1: 2}, object()])
def test_bounds_that_are_no_numbers_are_refused(name: str, value: object) -> None:
    with pytest.raises(DesignError, match=f"^{name}: got .*, allowed "):
        cart(**{name: value})


@pytest.mark.parametrize("name", ["k_i", "dt_s", "input_bound"])
def test_nothing_is_no_number(name: str) -> None:
    with pytest.raises(DesignError, match=f"^{name}: got None, allowed "):
        cart(**{name: None})


def test_modes_and_laws_may_be_their_values() -> None:
    design = cart(mode="safe", law="sampled")

    assert (design.mode, design.law) == (Mode.SAFE, Law.SAMPLED)
    with pytest.raises(DesignError, match=r"mode: got 'sure' \(str\), allowed Mode or one of \['off', 'safe'"):
        cart(mode="sure")
    with pytest.raises(DesignError, match="law: got None"):
        cart(law=None)


@pytest.mark.parametrize(
    ("part", "value", "allowed"),
    [
        ("system", damped_point(), "a System"),
        ("passivity", X[1] ** 2, "a Passivity"),
        ("tolerance", 1e-6, "a Tolerance"),
        ("barriers", "wall", "a sequence of Barrier"),
        ("barriers", None, "a sequence of Barrier"),
        ("barriers", [1 - X[0]], "a sequence of Barrier"),
    ],
)
def test_parts_of_another_kind_are_refused(part: str, value: object, allowed: str) -> None:
    with pytest.raises(DesignError) as refused:
        cart(**{part: value})

    assert (refused.value.field, refused.value.allowed) == (part, allowed)


def test_tanks_are_tanks_with_numbers() -> None:
    with pytest.raises(DesignError, match=r"passivity tank: got 1\.0"):
        Passivity(V=X[0] ** 2, tank=1.0)  # type: ignore[arg-type]  # wrong on purpose
    with pytest.raises(DesignError, match="tank initial_j: got 'full'"):
        Tank(initial_j="full")  # type: ignore[arg-type]  # wrong on purpose


def test_shapes_take_any_vector() -> None:
    position = damped_point().position
    for centre in ([0.0, 1.0], np.array([0.0, 1.0]), np.array([[0.0], [1.0]], dtype=np.float32), ca.DM([0.0, 1.0])):
        assert str(disk_keep_out(position, centre=centre, radius=1)) == str(  # type: ignore[arg-type]  # of many types
            disk_keep_out(position, centre=(0.0, 1.0), radius=1.0)
        )
    with pytest.raises(ShapeError, match="disk centre: got '01'"):
        disk_keep_out(position, centre="01", radius=1.0)  # type: ignore[arg-type]  # wrong on purpose
    with pytest.raises(DesignError, match="disk radius: got 'wide'"):
        disk_keep_out(position, centre=(0.0, 0.0), radius="wide")  # type: ignore[arg-type]  # wrong on purpose
    with pytest.raises(DesignError, match="coordinates of box low: got None"):
        box(None, low=(0.0,), high=(1.0,))  # type: ignore[arg-type]  # wrong on purpose
    with pytest.raises(ShapeError, match="separation positions"):
        separation(position, position[0], distance=1.0)


@pytest.mark.parametrize("value", ["no", 1, None, np.array([True, False]), ca.SX.sym("s"), [True]])
@pytest.mark.parametrize("name", ["gatekeeper", "between_samples"])
def test_a_flag_is_yes_or_no(name: str, value: object) -> None:
    with pytest.raises(DesignError, match=rf"^{name}: got .*, allowed True or False$"):
        cart(**{name: value})


class BrokenSequence(Sequence[float]):
    """Sequence of somebody else's whose elements cannot be read."""

    def __len__(self) -> int:
        """Return the number of elements."""
        return 2

    def __getitem__(self, index: object) -> Never:
        """Raise an error."""
        raise RuntimeError(f"element {index} is on another device")


def test_an_expression_is_no_list_in_itself() -> None:
    endless: list[object] = []
    endless.append(endless)

    with pytest.raises(DesignError, match=r"^u_fb: got sequences within sequences without end, allowed a casadi\.SX"):
        cart(u_fb=endless)


def test_an_expression_of_unreadable_parts_is_refused() -> None:
    with pytest.raises(DesignError, match=r"^u_fb: got .*BrokenSequence.*, allowed a casadi\.SX"):
        cart(u_fb=BrokenSequence())


def test_a_flag_may_be_that_of_an_array() -> None:
    assert cart(gatekeeper=np.True_).gatekeeper is True


@pytest.mark.parametrize("value", [-1.0, 2.1, 1e300, np.inf, np.nan])
def test_a_hold_is_a_number_of_periods(value: float) -> None:
    with pytest.raises(DesignError, match=r"^hold_s: got .*, allowed a number from zero to 2048 periods, 2\.048 s$"):
        cart(hold_s=value)
    assert cart(hold_s=[0.02]).hold_s == 0.02


@pytest.mark.parametrize("given", [np.array(1.0), ca.DM([1, 2]), ca.SX.sym("h", 2), "wall", 1.0, [1.0]])
def test_barriers_are_a_sequence_of_barriers(given: object) -> None:
    with pytest.raises(DesignError, match=r"^barriers: got .*, allowed a sequence of Barrier$"):
        cart(barriers=given)


@pytest.mark.parametrize("name", [["wall"], None, ca.SX.sym("wall"), 1])
def test_a_barrier_has_a_name(name: object) -> None:
    with pytest.raises(DesignError, match=r"^barrier name: got .*, allowed a name$"):
        Barrier(name=name, h=1 - X[0], class_k=(Linear(gain=2.0),) * 3)  # type: ignore[arg-type]  # wrong on purpose


@pytest.mark.parametrize("bounds", [1.0, [1.0], "close"])
def test_derivative_bounds_are_of_their_kind(bounds: object) -> None:
    with pytest.raises(DesignError, match=r"derivative_bounds: got .*, allowed DerivativeBounds, or None"):
        Barrier(name="wall", h=1 - X[0], class_k=(Linear(gain=2.0),) * 3, derivative_bounds=bounds)  # type: ignore[arg-type]  # wrong on purpose


@pytest.mark.parametrize("bound", [1e101, 1e300])
def test_limits_have_squares(bound: float) -> None:
    with pytest.raises(DesignError, match=r"allowed within ±1e\+100, every high above its low"):
        cart(input_bound=bound)


@pytest.mark.parametrize("value", [ca.DM([2, 2, 2]), np.array(2.0), "222"])
def test_class_k_functions_are_a_sequence(value: object) -> None:
    with pytest.raises(DesignError, match=r"^barrier 'wall' class_k: got .*, allowed "):
        Barrier(name="wall", h=1 - X[0], class_k=value)  # type: ignore[arg-type]  # wrong on purpose


@pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf])
def test_an_expression_has_finite_numbers(number: float) -> None:
    with pytest.raises(DesignError, match=r"^barrier 'wall' h: got the number -?(nan|inf), allowed finite numbers$"):
        cart(barriers=[Barrier(name="wall", h=X[0] + number, class_k=(Linear(gain=2.0),) * 3)])


def test_energies_and_gains_are_kept_as_numbers() -> None:
    tank = Tank(initial_j=[1], reserve_j=np.array([0.5]))  # type: ignore[arg-type]  # wrong on purpose

    assert (tank.initial_j, tank.reserve_j) == (1.0, 0.5)
    assert type(Linear(gain=np.array(2.0)).gain) is float  # type: ignore[arg-type]  # wrong on purpose


@pytest.mark.parametrize("low", [(2.0, 0.0), (np.nan, 0.0), (0.0,), "ab"])
def test_a_box_has_a_corner_below_another(low: object) -> None:
    with pytest.raises((DesignError, ShapeError), match=r"^state box"):
        StateBox(x0=(0.0, 0.0), low=low, high=(1.0, 1.0))  # type: ignore[arg-type]  # wrong on purpose


def test_a_box_is_that_of_the_plant() -> None:
    box = StateBox(x0=(0.0,), low=(0.0,), high=(1.0,))

    with pytest.raises(ShapeError, match="state box: got 1 numbers, allowed 2"):
        check_design(SafetyPassivityFilter(cart()), box)


@pytest.mark.parametrize("axis", [np.nan, np.inf, -np.inf, 0.5, -1])
def test_an_axis_of_a_norm_is_a_whole_number(axis: float) -> None:
    with pytest.raises(DesignError, match=r"^input norm axes: got .*, allowed numbers of axes from 0, each once$"):
        NormBound(axes=(0, axis), bound=1.0)  # type: ignore[arg-type]  # wrong on purpose


@pytest.mark.parametrize("number", [10**400, Decimal("NaN"), Decimal("sNaN")], ids=["large", "quiet", "signalling"])
def test_a_number_beyond_the_doubles_is_refused(number: object) -> None:
    makers: list[Callable[[], object]] = [
        lambda: cart(k_i=number),
        lambda: cart(uncertainty=Uncertainty(actuator_lag_s=number)),  # type: ignore[arg-type]  # wrong on purpose
        lambda: Parameter.of("mass", number),  # type: ignore[arg-type]  # wrong on purpose
        lambda: damped_point(mass=number),  # type: ignore[arg-type]  # wrong on purpose
    ]
    for make in makers:
        with pytest.raises(DesignError, match="finite number"):
            make()


@pytest.mark.parametrize(
    ("words", "make"),
    [
        ("parameter name: got 1.0", lambda: Parameter.of(1.0, 1.0)),  # type: ignore[arg-type]  # wrong on purpose
        ("a FilterDesign", lambda: SafetyPassivityFilter(CART)),  # type: ignore[arg-type]  # wrong on purpose
        ("a System", lambda: SampledPlant(cart(), X[1] ** 2, 0.01)),  # type: ignore[arg-type]  # wrong on purpose
        ("dt_s: got -1", lambda: SampledPlant(CART, X[1] ** 2, -1.0)),
        ("dt_s: got nan", lambda: SampledPlant(CART, X[1] ** 2, float("nan"))),
    ],
)
def test_what_is_something_else_is_named(words: str, make: Callable[[], object]) -> None:
    with pytest.raises(DesignError, match=words):
        make()


def test_a_shape_takes_a_decimal_number() -> None:
    exact = Decimal("0.5")

    for make in (
        lambda size: speed_limit(X, limit=size),
        lambda size: separation(X, X[::-1], distance=size),
        lambda size: disk_keep_out(X, centre=(0.0, 0.0), radius=size),
    ):
        assert str(make(exact)) == str(make(0.5))
