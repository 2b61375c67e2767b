"""Standing of a process with a router that was restarted."""

from types import SimpleNamespace
from typing import Any

import pytest
import zenoh
from passafe_protocol.identity import Identity
from passafe_services.loop import admission
from passafe_services.loop.admission import ANSWER_S, Admission

NO_MORE = zenoh.ZError("no more replies")
ADMITTED = SimpleNamespace(ok=SimpleNamespace())


class Router:
    """A router whose answers to the queries that follow are given; without any it goes on as with the last one."""

    def __init__(self, *answers: object) -> None:
        self.answers = [*answers]
        self.now_s = 0.0

    def monotonic(self) -> float:
        return self.now_s

    def get(self, *_: object, **__: object) -> "Router":
        return self

    def try_recv(self) -> Any:  # noqa: ANN401 - a reply, as far as it is read
        answer = self.answers.pop(0) if len(self.answers) > 1 else self.answers[0]
        if isinstance(answer, Exception):
            raise answer
        return answer


def refusals(router: Router, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return what is said of the router once a second for five seconds."""
    monkeypatch.setattr(admission, "time", router)
    session: Any = router
    standing = Admission(session, Identity(role="plant", robot="left"), "tls/127.0.0.1:7447")
    found = []
    for router.now_s in range(5):
        found.append(standing.refusal("of the second router"))
    return found


def test_a_router_that_does_not_answer_yet_is_not_accused(monkeypatch: pytest.MonkeyPatch) -> None:
    assert refusals(Router(NO_MORE, NO_MORE, ADMITTED), monkeypatch) == [""] * 5


@pytest.mark.parametrize("answer", [NO_MORE, None], ids=["no-replies", "none-yet"])
def test_a_router_that_never_answers_is_reported(answer: object, monkeypatch: pytest.MonkeyPatch) -> None:
    *_, before, after = refusals(Router(answer), monkeypatch)[: int(ANSWER_S) + 2]

    assert before == ""
    assert (
        after
        == "the router does not admit 'plant.left': its admitted.txt does not list it, or it was not restarted since"
    )
