"""Ask for the page's token: a browser shows it once, in the address that it opens; a program in a header.

A browser keeps it as a cookie that scripts cannot read and other sites' pages cannot send.
"""

from http.cookies import CookieError, SimpleCookie
from secrets import compare_digest
from typing import Final
from urllib.parse import parse_qsl, urlencode

from starlette.datastructures import Headers
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Receive, Scope, Send

UNAUTHORIZED: Final = 401
SEE_OTHER: Final = 303
COOKIE: Final = "passafe_token"
PARAMETER: Final = "token"


class TokenOnly:
    """ASGI application that passes on what knows the token.

    It answers before anything of a body is read.

    Args:
        app: The application.
        token: The token.
        is_encrypted: Whether the page speaks TLS: a browser then sends the cookie nowhere else.
    """

    def __init__(self, app: ASGIApp, *, token: str, is_encrypted: bool) -> None:
        self._app = app
        self._token = token
        self._is_encrypted = is_encrypted

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request or WebSocket."""
        answer = self._answer(scope) if scope["type"] in ("http", "websocket") else None
        await (answer or self._app)(scope, receive, send)

    def _answer(self, scope: Scope) -> Response | None:
        headers = Headers(scope=scope)
        if self._knows(headers.get("authorization", "").removeprefix("Bearer ")) or self._knows(_cookie(headers)):
            return None
        query = parse_qsl(scope["query_string"].decode("latin-1"))
        shown = [value for name, value in query if name == PARAMETER]
        if scope["type"] == "http" and scope["method"] == "GET" and len(shown) == 1 and self._knows(shown[0]):
            rest = urlencode([(name, value) for name, value in query if name != PARAMETER])
            answer = RedirectResponse(f"{scope['path']}?{rest}" if rest else scope["path"], SEE_OTHER)
            answer.set_cookie(COOKIE, self._token, httponly=True, samesite="strict", secure=self._is_encrypted)
            return answer
        text = "token: got none or another one, allowed the one in the address that the dashboard printed at its start"
        return PlainTextResponse(text, UNAUTHORIZED, {"WWW-Authenticate": "Bearer"})

    def _knows(self, got: str) -> bool:
        return compare_digest(got.encode(), self._token.encode())


def _cookie(headers: Headers) -> str:
    try:
        found = SimpleCookie(headers.get("cookie", "")).get(COOKIE)
    except CookieError:
        return ""
    return "" if found is None else found.value
