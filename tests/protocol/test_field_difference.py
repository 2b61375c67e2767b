"""The first field in which two records differ."""

import pytest
from msgspec.structs import replace
from passafe_protocol.field_difference import are_identical, field_differences
from passafe_protocol.messages import BarrierReport, Certificate, Consumed, FilterStatus, FilterTick

TICK = FilterTick(
    tick=1203,
    status=FilterStatus.PASSED,
    mode="both",
    law="sampled",
    effective_plant_ns=0,
    x_hat=(1.0, 2.0),
    u_h=(0.0,),
    u_h_rate=(0.0,),
    u_nominal=(0.0,),
    phi=(0.0,),
    v=(0.0,),
    u=(0.0,),
    barriers=(BarrierReport("floor", (1.0,)), BarrierReport("wall", (0.01, 3.0))),
    power_margin=0.0,
    tank_j=1.0,
    slack=0.0,
    rows=(),
    certificate=Certificate("closed form", True, 0.0, 0.0, 0.0),
    consumed=(),
    state_age_ns=0,
    command_age_ns=0,
)


def differences(**fields: object) -> list[str]:
    return [str(each) for each in field_differences(TICK, replace(TICK, **fields))]


def test_nested_field_is_named_with_both_values() -> None:
    barriers = (TICK.barriers[0], BarrierReport("wall", (0.02, 3.0)))
    assert differences(barriers=barriers) == ["barriers[1].psi[0] 0.01 -> 0.02"]


def test_record_within_a_record_is_compared_by_field() -> None:
    assert differences(certificate=replace(TICK.certificate, gap=1.0)) == ["certificate.gap 0.0 -> 1.0"]


def test_sign_of_zero_is_a_difference() -> None:
    assert not are_identical(TICK, replace(TICK, slack=-0.0))
    assert differences(slack=-0.0) == ["slack 0.0 -> -0.0"]


def test_not_a_number_is_itself() -> None:
    lost = replace(TICK, slack=float("nan"))
    assert are_identical(lost, replace(lost))
    assert field_differences(lost, lost) == []


def test_missing_elements_are_nothing() -> None:
    assert differences(x_hat=(1.0,)) == ["x_hat[1] 2.0 -> nothing"]
    [text] = differences(consumed=(Consumed("state", 7, 1, 2),))
    assert text.startswith("consumed[0] nothing -> Consumed(topic='state', sequence=7")


def test_member_of_an_enumeration_is_named() -> None:
    assert differences(status=FilterStatus.STALE) == ["status PASSED -> STALE"]


def test_records_of_two_types_are_refused() -> None:
    assert not are_identical(TICK, TICK.certificate)
    with pytest.raises(TypeError, match="got FilterTick and Certificate, allowed one type"):
        field_differences(TICK, TICK.certificate)
