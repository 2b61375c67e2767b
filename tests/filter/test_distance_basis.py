import pytest
from passafe_services.filter.distance_basis import PERIOD_NS, DistanceBasis
from passafe_services.scenarios.design import design_of, robot_of
from passafe_services.scenarios.load import load_scenario

from passafe.decision import Decision
from passafe.filter import SafetyPassivityFilter

SCENARIO = load_scenario("notomista-cai-2020")
CORE = SafetyPassivityFilter(design_of(SCENARIO, robot_of(SCENARIO)))


def decision(x: tuple[float, ...] = (2.0, 2.0, 0.0, 0.0)) -> Decision:
    return CORE.decide(x, (0.0, 0.0), (1.0, 0.0), (0.0, 0.0), 1.0)


def fallback() -> Decision:
    found = decision((float("nan"), 0.0, 0.0, 0.0))
    assert found.status.is_fallback
    return found


def test_a_decision_serves_the_ticks_of_twenty_milliseconds() -> None:
    basis, first, later, next_one = DistanceBasis(), decision(), decision(), decision()

    assert basis.of(first, 7) is first
    assert basis.of(later, 7 + PERIOD_NS - 1) is first
    assert basis.of(next_one, 7 + PERIOD_NS) is next_one
    assert basis.of(later, 8 + PERIOD_NS) is next_one


@pytest.mark.parametrize("period_ns", [PERIOD_NS, 100_000_000])
def test_each_decision_of_a_slow_filter_is_its_own(period_ns: int) -> None:
    basis = DistanceBasis()

    for tick in range(3):
        own = decision()
        assert basis.of(own, tick * period_ns) is own


def test_fallbacks_and_the_decision_after_are_their_own() -> None:
    basis, before, lost, still_lost, after = DistanceBasis(), decision(), fallback(), fallback(), decision()
    found = [basis.of(each, tick) for tick, each in enumerate((before, lost, still_lost, after, decision()))]

    assert all(one is other for one, other in zip(found, (before, lost, still_lost, after, after), strict=True))


def test_time_that_goes_back_takes_the_newest_decision() -> None:
    basis, old, new = DistanceBasis(), decision(), decision()

    assert basis.of(old, 1_000) is old
    assert basis.of(new, 999) is new
