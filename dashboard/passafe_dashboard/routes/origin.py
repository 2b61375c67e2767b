"""Refuse requests of pages that are not the server's own."""

from urllib.parse import urlsplit

from starlette.requests import HTTPConnection


def is_same_origin(connection: HTTPConnection) -> bool:
    """Return whether a page of this server asks; another site's may not read the robot's state, or change it.

    Programs other than browsers send no ``Origin`` and are let in.
    """
    origin = connection.headers.get("origin")
    return origin is None or urlsplit(origin).netloc == connection.headers.get("host")
