"""Refuse requests that name another host than this server, or come from a page of another site.

A browser sends the name that a page was opened with as ``Host``. A site whose name is made to resolve to this machine
(DNS rebinding) has the origin of its own page there, so that origin and host agree: only the name itself tells.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Self

from starlette.datastructures import Headers
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Receive, Scope, Send

from passafe_dashboard.address import is_address, is_loopback

MISDIRECTED: Final = 421
FORBIDDEN: Final = 403
LONGEST_SHOWN: Final = 80
"""Characters of a refused host that the answer repeats."""

_HOST: Final = re.compile(r"(?:\[(?P<v6>[0-9A-Fa-f:.]+)\]|(?P<name>[^\s:/@\[\]?#]+))(?::\d{1,5})?")


@dataclass(frozen=True, kw_only=True, slots=True)
class OwnHosts:
    """Hosts by which the page may be asked for.

    Attributes:
        names: Names, in lower case.
        any_address: Whether any numeric address is allowed: no site of a name can be rebound to one.
    """

    names: frozenset[str] = frozenset({"localhost"})
    any_address: bool = False

    @classmethod
    def of(cls, listening: str, names: Sequence[str] = ()) -> Self:
        """Return the hosts of a page that listens at an address.

        Args:
            listening: Host name or address that it listens on.
            names: Further names by which it is reached.
        """
        return cls(
            names=frozenset({"localhost", listening.lower(), *(name.lower() for name in names)}),
            any_address=listening.lower() != "localhost" and not is_loopback(listening),
        )

    def allow(self, header: str) -> bool:
        """Return whether a ``Host`` header, with or without a port, names this server."""
        match = _HOST.fullmatch(header)
        if match is None:
            return False
        host = match["v6"] or match["name"].lower()
        return host in self.names or is_loopback(host) or (self.any_address and is_address(host))


class OwnHostsOnly:
    """ASGI application that passes on what is asked of this server, by a program or by one of its own pages.

    It answers before anything of a body is read.

    Args:
        app: The application.
        hosts: Hosts by which it may be asked.
    """

    def __init__(self, app: ASGIApp, *, hosts: OwnHosts) -> None:
        self._app = app
        self._hosts = hosts

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request or WebSocket."""
        refusal = self._refusal(Headers(scope=scope)) if scope["type"] in ("http", "websocket") else None
        await (refusal or self._app)(scope, receive, send)

    def _refusal(self, headers: Headers) -> PlainTextResponse | None:
        hosts, origins = headers.getlist("host"), headers.getlist("origin")
        if len(hosts) != 1 or not self._hosts.allow(hosts[0]):
            got = ", ".join(hosts)[:LONGEST_SHOWN]
            text = f"host: got {got!a}, allowed {', '.join(sorted(self._hosts.names))}, or one named with --page-name"
            return PlainTextResponse(text, MISDIRECTED)
        if any(origin not in (f"http://{hosts[0]}", f"https://{hosts[0]}") for origin in origins):
            return PlainTextResponse(
                "a page of another site may neither read the robot's state nor change a link", FORBIDDEN
            )
        return None
