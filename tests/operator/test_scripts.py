"""Scripted sources: closed forms, and every rate against a finite difference of the command."""

from math import cos, exp, pi, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st
from passafe_services.operator.sources.command import Command
from passafe_services.operator.sources.constant import Constant
from passafe_services.operator.sources.lag import Lag
from passafe_services.operator.sources.piecewise import PiecewiseLinear
from passafe_services.operator.sources.sine import Sine
from passafe_services.operator.sources.source import CommandSource, SourceClock

LEVELS = st.floats(-50, 50)
PAIRS = st.tuples(LEVELS, LEVELS)
STEP_S = 1e-5


def central_difference(source: CommandSource, t_s: float) -> list[float]:
    before, after = source.command(t_s - STEP_S).u_h, source.command(t_s + STEP_S).u_h
    return [(b - a) / (2 * STEP_S) for a, b in zip(before, after, strict=True)]


def test_the_lag_of_the_paper_after_one_time_constant() -> None:
    command = Lag(target=(-3.0, 0.0), time_constant_s=0.2).command(0.2)
    assert command.u_h == pytest.approx((-3.0 * (1.0 - exp(-1.0)), 0.0), rel=1e-15)
    assert command.u_h_rate == pytest.approx((-3.0 * exp(-1.0) / 0.2, 0.0), rel=1e-15)
    assert command.enabled


def test_lag_starts_at_zero_and_ends_at_its_target() -> None:
    lag = Lag(target=(4.0, -2.0), time_constant_s=0.5)
    assert lag.command(0.0) == Command((0.0, 0.0), (8.0, -4.0), True)
    assert lag.command(1e6) == Command((4.0, -2.0), (0.0, 0.0), True)


def test_a_lag_keeps_its_digits_in_the_first_nanosecond() -> None:
    # 1 − e^{−x} = x − x²/2 + …; computed as a difference it would be off by 1e-8 here.
    assert Lag(target=(1.0,), time_constant_s=1.0).command(1e-9).u_h[0] == pytest.approx(1e-9 - 5e-19, rel=1e-15)


@given(target=PAIRS, time_constant_s=st.floats(0.05, 5), t_s=st.floats(0.01, 20))
def test_the_rate_of_a_lag_is_its_derivative(target: tuple[float, float], time_constant_s: float, t_s: float) -> None:
    lag = Lag(target=target, time_constant_s=time_constant_s)
    assert lag.command(t_s).u_h_rate == pytest.approx(central_difference(lag, t_s), rel=1e-6, abs=1e-5)


@given(target=PAIRS, time_constant_s=st.floats(1e-6, 5), t_s=st.floats(0, 20))
def test_a_lag_obeys_its_differential_equation(target: tuple[float, float], time_constant_s: float, t_s: float) -> None:
    command = Lag(target=target, time_constant_s=time_constant_s).command(t_s)
    for u_h, rate, goal in zip(command.u_h, command.u_h_rate, target, strict=True):
        assert u_h + time_constant_s * rate == pytest.approx(goal, rel=1e-12, abs=1e-12)


def test_a_constant_is_the_same_throughout() -> None:
    source = Constant(value=(1.0, -2.0))
    assert source.command(0.0) == source.command(1e3) == Command((1.0, -2.0), (0.0, 0.0), True)


def test_a_sine_at_a_quarter_of_its_period() -> None:
    source = Sine(amplitude=(2.0, 3.0), offset=(1.0, 0.0), phase_rad=(0.0, pi / 2), frequency_hz=0.5)
    command = source.command(0.5)
    assert command.u_h == pytest.approx((3.0, 0.0), abs=1e-15)
    assert command.u_h_rate == pytest.approx((0.0, -3.0 * pi), abs=1e-14)


@given(
    amplitude=PAIRS,
    offset=PAIRS,
    phase_rad=st.tuples(st.floats(-7, 7), st.floats(-7, 7)),
    frequency_hz=st.floats(0.01, 5),
    t_s=st.floats(0.01, 20),
)
def test_sine_follows_its_formula_with_the_exact_rate(
    amplitude: tuple[float, float],
    offset: tuple[float, float],
    phase_rad: tuple[float, float],
    frequency_hz: float,
    t_s: float,
) -> None:
    source = Sine(amplitude=amplitude, offset=offset, phase_rad=phase_rad, frequency_hz=frequency_hz)
    command = source.command(t_s)
    for axis in range(2):
        angle = 2 * pi * frequency_hz * t_s + phase_rad[axis]
        assert command.u_h[axis] == pytest.approx(offset[axis] + amplitude[axis] * sin(angle), abs=1e-10)
        rate = amplitude[axis] * 2 * pi * frequency_hz * cos(angle)
        assert command.u_h_rate[axis] == pytest.approx(rate, rel=1e-9, abs=1e-9)
    assert command.u_h_rate == pytest.approx(central_difference(source, t_s), rel=1e-5, abs=1e-3)


def test_waypoints_are_held_outside_and_joined_by_lines_inside() -> None:
    source = PiecewiseLinear.through(
        device="waypoints", times_s=(1.0, 2.0, 4.0), values=((0.0, 1.0), (2.0, 1.0), (-2.0, 3.0))
    )
    assert source.command(0.0) == Command((0.0, 1.0), (0.0, 0.0), True)
    assert source.command(1.0) == Command((0.0, 1.0), (2.0, 0.0), True)
    assert source.command(1.5) == Command((1.0, 1.0), (2.0, 0.0), True)
    assert source.command(2.0) == Command((2.0, 1.0), (-2.0, 1.0), True)
    assert source.command(3.0) == Command((0.0, 2.0), (-2.0, 1.0), True)
    assert source.command(4.0) == Command((-2.0, 3.0), (0.0, 0.0), True)
    assert source.command(1e6) == Command((-2.0, 3.0), (0.0, 0.0), True)


def test_a_single_point_is_a_constant() -> None:
    source = PiecewiseLinear.through(device="recorded", times_s=(3.0,), values=((7.0,),))
    assert source.command(0.0) == source.command(3.0) == source.command(9.0) == Command((7.0,), (0.0,), True)


@given(data=st.data())
def test_waypoints_are_interpolated_linearly_with_the_slope(data: st.DataObject) -> None:
    gaps = data.draw(st.lists(st.floats(0.01, 3), min_size=2, max_size=6))
    times_s = [sum(gaps[: index + 1]) for index in range(len(gaps))]
    values = data.draw(st.lists(PAIRS, min_size=len(gaps), max_size=len(gaps)))
    source = PiecewiseLinear.through(device="waypoints", times_s=times_s, values=values)
    index = data.draw(st.integers(0, len(gaps) - 2))
    share = data.draw(st.floats(0.01, 0.99))
    t_s = times_s[index] + share * (times_s[index + 1] - times_s[index])
    command = source.command(t_s)
    for axis in range(2):
        expected = (1 - share) * values[index][axis] + share * values[index + 1][axis]
        assert command.u_h[axis] == pytest.approx(expected, abs=1e-9)
    assert command.u_h_rate == pytest.approx(central_difference(source, t_s), abs=1e-4)


@pytest.mark.parametrize(
    "source",
    [
        Lag(target=(1.0,), time_constant_s=1.0),
        Constant(value=(1.0,)),
        Sine(amplitude=(1.0,), offset=(0.0,), phase_rad=(0.0,), frequency_hz=1.0),
        PiecewiseLinear.through(device="waypoints", times_s=(0.0,), values=((1.0,),)),
    ],
    ids=lambda source: source.device,
)
def test_a_script_runs_on_plant_time_and_never_ends_the_session(source: CommandSource) -> None:
    assert source.clock is SourceClock.PLANT
    assert not source.finished
