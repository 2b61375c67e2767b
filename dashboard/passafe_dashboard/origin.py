"""Which pages may talk to the server: its own."""

from urllib.parse import urlsplit

from starlette.requests import HTTPConnection


def same_origin(connection: HTTPConnection) -> bool:
    """Tell whether a page of this server asks: a page of another site may not read the robot's state, or change it.

    Programs that are no browser send no ``Origin`` and are let in.
    """
    origin = connection.headers.get("origin")
    return origin is None or urlsplit(origin).netloc == connection.headers.get("host")
