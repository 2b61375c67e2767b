"""Options by which a command gets its keys, and the endpoint that they lead to."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Final

import typer

from passafe_services.cli.bus_options import parse_endpoint
from passafe_services.cli.errors import OptionError
from passafe_services.keys.credentials import EXPIRES_SOON_DAYS, load_credentials
from passafe_services.keys.throw_away import throw_away_folder
from passafe_services.loop.router_endpoint import LOOPBACK, RouterEndpoint

KeysOption = Annotated[
    Path | None,
    typer.Option(
        "--keys",
        metavar="FOLDER",
        envvar="PASSAFE_KEYS",
        help="Keys of this process or its deployment (`passafe keys make`); those of a demo on this host are found.",
    ),
]
InsecureOption = Annotated[
    bool,
    typer.Option(
        "--insecure", envvar="PASSAFE_INSECURE", help="No keys: no encryption, and everybody may do everything."
    ),
]
_LOCAL: Final = (LOOPBACK, "localhost", "::1")


def secured_endpoint(  # the options of a command, in its order
    router: str, role: str, robot: str, *, keys: Path | None, insecure: bool, quiet: bool = False
) -> RouterEndpoint:
    """Return the router's endpoint with the keys of a process.

    Args:
        router: ``HOST:PORT``.
        role: Role of the process.
        robot: Its robot.
        keys: Folder of keys; ``None``: those that a demo of this user on this host has made.
        insecure: Whether to do without keys, which is said on standard error.
        quiet: Whether to say neither this nor that a certificate expires soon: the demo has, or makes others.

    Raises:
        OptionError: There are no keys, or keys as well as ``insecure``.
        KeysError: The keys cannot be used.
        KeysMismatchError: The keys are those of another role or robot.
    """
    endpoint = parse_endpoint(router)
    if insecure:
        if keys is not None:
            raise OptionError("--insecure", f"--keys {keys} too", "one of them")
        if not quiet:
            warn_of_insecurity(endpoint)
        return endpoint
    credentials = load_credentials(keys or _keys_of_demo(endpoint), role, robot)
    days = credentials.days_left()
    if days < EXPIRES_SOON_DAYS and keys is not None and not quiet:  # those of a demo are thrown away with it
        _say(f"the certificate of {credentials.identity.common_name} expires in {days:.1f} days: passafe keys renew")
    return replace(endpoint, credentials=credentials)


def warn_of_insecurity(endpoint: RouterEndpoint) -> None:
    """Print on standard error what ``--insecure`` gives up."""
    _say(
        f"insecure: whoever reaches {endpoint.host}:{endpoint.port} can read everything, drive the robot past the "
        "filter and stop it; nothing is encrypted and nobody is asked who they are"
    )


def _keys_of_demo(endpoint: RouterEndpoint) -> Path:
    folder = throw_away_folder(endpoint.port)
    if endpoint.host not in _LOCAL or not folder.is_dir():
        where = f"{endpoint.host}:{endpoint.port}"
        raise OptionError(
            "--keys", f"none, and no demo of yours at {where}", "a folder of `passafe keys make`, or --insecure"
        )
    return folder


def _say(text: str) -> None:
    sys.stderr.write(f"passafe: {text}\n")
