"""Options of commands that reach a running system: its router and its robot. They load fast, for `passafe stop`."""

from typing import Annotated, Final

import typer

from passafe_services.cli.errors import OptionError
from passafe_services.loop.router_endpoint import DEFAULT_PORT, LOOPBACK, RouterEndpoint

RouterOption = Annotated[
    str,
    typer.Option(
        "--router",
        metavar="HOST:PORT",
        envvar="PASSAFE_ROUTER",
        help="Where the router of the running system listens.",
    ),
]
RobotOption = Annotated[
    str,
    typer.Option(
        "--robot",
        metavar="NAME",
        envvar="PASSAFE_ROBOT",
        help="Robot, whose name is part of every key on the bus.",
    ),
]
DEFAULT_ROUTER: Final = f"{LOOPBACK}:{DEFAULT_PORT}"


def parse_endpoint(text: str) -> RouterEndpoint:
    """Return the endpoint that ``HOST:PORT`` names.

    Raises:
        OptionError: The text has another form.
    """
    host, separator, port = text.rpartition(":")
    if not separator or not port.isdigit():
        raise OptionError("--router", repr(text), f"HOST:PORT such as {DEFAULT_ROUTER}")
    return RouterEndpoint(host=host, port=int(port))
