"""The lease of the operator: granted, renewed, lost by silence, taken over on request, reported."""

from passafe_protocol.messages import Event, Header, OperatorCommand, OperatorLease, Received
from passafe_services.filter.operator_lease import LEASE_NS, REPORT_PERIOD_NS, LeaseAnswer, OperatorLeases

MS = 1_000_000
LEASE_MS = LEASE_NS // MS
HOLDS, GRANTED, REFUSED = LeaseAnswer.HOLDS, LeaseAnswer.GRANTED, LeaseAnswer.REFUSED


def admit(leases: OperatorLeases, epoch: int, at_ms: int, *, take_over: int = 0) -> LeaseAnswer:
    body = OperatorCommand((0.0,), (), enabled=True, device=f"device {epoch}", take_over=take_over)
    return leases.admit(Received(Header("operator", epoch, 0, 0, 0, 0, 0), body, at_ms * MS), body)


def reported(leases: OperatorLeases, at_ms: int) -> OperatorLease:
    report = leases.report(at_ms * MS)
    assert report is not None
    return report


def test_nobody_holds_it_before_the_first_command() -> None:
    assert OperatorLeases().report(0) == OperatorLease(0, 0, "", -1)


def test_the_first_session_holds_it_while_its_commands_come() -> None:
    leases = OperatorLeases()
    admissions = [admit(leases, 5, at_ms) for at_ms in (0, 1, 900, 1_900, 2_899)]

    assert admissions == [GRANTED, HOLDS, HOLDS, HOLDS, HOLDS]
    assert reported(leases, 2_900) == OperatorLease(1, 5, "device 5", MS)
    assert leases.pop_events() == []


def test_a_second_session_changes_nothing_and_is_reported_once() -> None:
    leases = OperatorLeases()
    admit(leases, 5, 0)
    for epoch in (2, 9):  # older or newer
        for at_ms in range(1, 900):
            assert admit(leases, epoch, at_ms) is REFUSED
            assert admit(leases, 5, at_ms) is HOLDS

    [event] = leases.pop_events()

    assert event == Event(
        "warning", "commands of operator session 2 (device 2) do not count: session 5 (device 5) holds the lease"
    )
    assert reported(leases, 900) == OperatorLease(1, 5, "device 5", MS, refused=2)


def test_the_lease_is_lost_by_silence_alone() -> None:
    leases = OperatorLeases()
    admit(leases, 5, 0)

    assert admit(leases, 2, LEASE_MS) is REFUSED
    assert admit(leases, 2, LEASE_MS + 1) is GRANTED
    assert admit(leases, 5, LEASE_MS + 2) is REFUSED
    assert leases.pop_events()[1] == Event(
        "warning", "operator session 2 (device 2) follows session 5 (device 5), which is silent"
    )


def test_a_lost_lease_is_reported_as_free_and_comes_back() -> None:
    leases = OperatorLeases()
    admit(leases, 5, 0)

    assert reported(leases, LEASE_MS + 1) == OperatorLease(1, 0, "", -1)
    assert admit(leases, 5, LEASE_MS + 2) is HOLDS
    assert reported(leases, LEASE_MS + 1 + REPORT_PERIOD_NS // MS).holder == 5


def test_a_take_over_is_explicit_and_logged() -> None:
    leases = OperatorLeases()
    admit(leases, 5, 0)

    assert admit(leases, 2, 1, take_over=1) is GRANTED
    assert admit(leases, 5, 2) is REFUSED
    text = "operator session 2 (device 2) took over from session 5 (device 5)"
    assert leases.pop_events()[0] == Event("warning", text)
    assert reported(leases, 2) == OperatorLease(2, 2, "device 2", MS, refused=5)


def test_a_late_take_over_does_not_take_the_next_lease() -> None:
    leases = OperatorLeases()
    admit(leases, 5, 0)
    admit(leases, 2, 1, take_over=1)
    admit(leases, 9, 2, take_over=2)

    assert admit(leases, 2, 3, take_over=1) is REFUSED
    assert admit(leases, 2, 4, take_over=4) is REFUSED
    assert admit(leases, 9, 5, take_over=3) is HOLDS


def test_reports_come_at_changes_and_periodically() -> None:
    leases = OperatorLeases()
    due = [at_ms for at_ms in range(1_000) if (at_ms == 350 and admit(leases, 3, 350)) or leases.report(at_ms * MS)]

    assert due == [0, 200, 350, 351, 551, 751, 951]


def test_alternating_strangers_are_reported_once_a_second() -> None:
    leases = OperatorLeases()
    events = []
    for at_ms in range(3_000):
        admit(leases, 1, at_ms)
        admit(leases, 2 + at_ms % 2, at_ms)
        events += leases.pop_events()

    assert len(events) == 3


def test_restart_frees_it() -> None:
    leases = OperatorLeases()
    admit(leases, 5, 0)
    admit(leases, 6, 0)
    leases.restart()

    assert leases.pop_events() == []
    assert admit(leases, 2, 1) is GRANTED
    assert reported(leases, 1).number == 1


def test_another_device_of_the_holder_is_reported_at_once() -> None:
    leases = OperatorLeases()
    admit(leases, 5, 0)
    assert reported(leases, 1).device == "device 5"
    body = OperatorCommand((0.0,), (), enabled=True, device="page")
    leases.admit(Received(Header("operator", 5, 1, 0, 0, 0, 0), body, 2 * MS), body)

    assert reported(leases, 3) == OperatorLease(1, 5, "page", MS)
    assert leases.pop_events() == []
