"""Admission: whether the router lets a process publish, asked of the router since Zenoh drops without a word."""

import time
from typing import Final

import zenoh
from passafe_protocol.identity import Identity
from zenoh import handlers

from passafe_services.keys.errors import NotAdmittedError
from passafe_services.loop.access import OPEN_KEY, admission_key, published_topics
from passafe_services.loop.errors import OpenRouterError

ANSWER_S: Final = 2.0
"""How long to ask a router, which may just have started."""

SEPARATOR: Final = " "
"""Between the topics of an answer."""

_RETRY_S: Final = 0.05

NOT_LISTED: Final = "its admitted.txt does not list it, or it was not restarted since"


class Admission:
    """Standing of one process with its router.

    Args:
        session: Its session.
        identity: Who it is.
        locator: Where the router listens.
    """

    def __init__(self, session: zenoh.Session, identity: Identity, locator: str) -> None:
        self._session = session
        self._identity = identity
        self._locator = locator
        self._router = ""
        self._met_s = 0.0
        self._is_admitted = False
        self._asked_s = 0.0
        self._answer: handlers.Handler[zenoh.Reply] | None = None
        self._refusal = ""

    def require(self, router: str, timeout_s: float) -> None:
        """Check at the start that the router admits this process, and that it refuses what it must refuse.

        Args:
            router: Identity of the connected router.
            timeout_s: How long to ask.

        Raises:
            NotAdmittedError: It does not admit this process, or not for all that its role publishes.
            OpenRouterError: Access control is not in force.
        """
        end_s = time.monotonic() + min(timeout_s, ANSWER_S)
        while (topics := self._ask(admission_key(self._identity))) is None:
            if time.monotonic() > end_s:
                raise NotAdmittedError(self._identity.common_name, self._locator, NOT_LISTED)
            time.sleep(_RETRY_S)
        missing = [topic.name for topic in published_topics(self._identity.role) if topic.name not in topics]
        if missing:
            text = f"it would drop {', '.join(missing)}: is it of another version of passafe?"
            raise NotAdmittedError(self._identity.common_name, self._locator, text)
        if self._ask(OPEN_KEY) is not None:
            raise OpenRouterError(self._locator)
        self._router, self._is_admitted = router, True

    def refusal(self, router: str) -> str:
        """Return why the connected router drops what this process publishes; empty if it does not, as far as is known.

        It asks again whenever the router is another one: a router that was restarted may admit others. It never waits.
        A router that has just started does not answer yet, and is not accused of that.
        """
        if not router:
            return ""
        now_s = time.monotonic()
        if router != self._router:
            self._router, self._met_s, self._is_admitted, self._answer = router, now_s, False, None
        if not self._is_admitted and self._is_unanswered(now_s) and now_s - self._met_s > ANSWER_S:
            self._refusal = f"the router does not admit {self._identity.common_name!r}: {NOT_LISTED}"
        return self._refusal

    def _is_unanswered(self, now_s: float) -> bool:
        """Ask, or look for the answer; return whether there was none."""
        if self._answer is None:
            self._asked_s = now_s
            self._answer = self._session.get(admission_key(self._identity), handlers.FifoChannel(1), timeout=ANSWER_S)
        try:
            reply = self._answer.try_recv()
        except zenoh.ZError:
            reply, is_over = None, True  # no more replies
        else:
            is_over = now_s - self._asked_s > ANSWER_S
        if reply is not None and reply.ok is not None:
            self._is_admitted, self._answer, self._refusal = True, None, ""
            return False
        if is_over:
            self._answer = None
        return is_over

    def _ask(self, key: str) -> tuple[str, ...] | None:
        for reply in self._session.get(key, timeout=ANSWER_S):
            if reply.ok is not None:
                return tuple(reply.ok.payload.to_string().split(SEPARATOR))
        return None
