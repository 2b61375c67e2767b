from passafe_protocol.messages import BY_SEVERITY, FilterStatus
from passafe_services.filter.telemetry import STATUS

from passafe.decision import Status


def test_core_and_wire_number_statuses_alike() -> None:
    assert {status.name: status.value for status in Status} | {"STALE": 6, "STOPPED": 9} == {
        status.name: status.value for status in FilterStatus
    }


def test_telemetry_names_statuses_as_the_core_does() -> None:
    assert [STATUS[status].name for status in Status] == [status.name for status in Status]


def test_fallbacks_on_the_wire_are_those_of_the_core_and_stale() -> None:
    in_core = {status.name for status in Status if status.is_fallback}
    assert {status.name for status in FilterStatus if status.is_fallback} == in_core | {"STALE"}


def test_severity_ranks_every_status_and_fallbacks_last() -> None:
    assert sorted(status.severity for status in FilterStatus) == [*range(1, len(FilterStatus) + 1)]
    assert min(BY_SEVERITY, key=lambda status: status.severity) is FilterStatus.PASSED
    assert [status.is_fallback for status in BY_SEVERITY] == [False] * 5 + [True] * 4
