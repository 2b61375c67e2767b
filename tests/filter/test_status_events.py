import pytest
from passafe_protocol.messages import FilterStatus
from passafe_services.filter.event_emitter import EVENT_PERIOD_NS, StatusEventEmitter

NOTABLE = [status for status in FilterStatus if status.is_fallback or status is FilterStatus.BACKUP]


@pytest.mark.parametrize("status", NOTABLE)
def test_fallbacks_and_the_backup_law_are_reported_and_their_end(status: FilterStatus) -> None:
    emitter = StatusEventEmitter()

    begun, same, ended = (
        emitter.event(k * EVENT_PERIOD_NS, s) for k, s in enumerate((status, status, FilterStatus.PASSED))
    )

    assert begun is not None
    assert begun.severity == ("warning" if status in {FilterStatus.STALE, FilterStatus.BACKUP} else "error")
    assert same is None
    assert ended is not None
    assert ended.severity == "info"


def test_every_notable_status_has_words_of_its_own() -> None:
    events = [StatusEventEmitter().event(0, status) for status in NOTABLE]

    assert len({event.text for event in events if event is not None}) == len(NOTABLE)
