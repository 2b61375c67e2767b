from passafe_protocol.messages import FilterStatus

from passafe.decision import Status


def test_core_and_wire_number_statuses_alike() -> None:
    assert {status.name: status.value for status in Status} | {"STALE": 6} == {
        status.name: status.value for status in FilterStatus
    }
