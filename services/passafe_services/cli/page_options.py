"""Options of access to the page, for the commands that serve it to others than this host."""

from pathlib import Path
from typing import Annotated

import typer

PageTokenOption = Annotated[
    str,
    typer.Option(
        metavar="TOKEN",
        envvar="PASSAFE_PAGE_TOKEN",
        help="Dashboard: token that the page asks for, or `new`: one is made and shown. Without it the page asks for "
        "none on loopback, and for a new one elsewhere.",
    ),
]
PageCertificateOption = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        envvar="PASSAFE_PAGE_CERTIFICATE",
        help="Dashboard: certificate of the page, PEM. On another address than loopback one is made if none is given.",
    ),
]
PageKeyOption = Annotated[
    Path | None,
    typer.Option(metavar="FILE", envvar="PASSAFE_PAGE_KEY", help="Dashboard: its private key, PEM."),
]
OpenPageOption = Annotated[
    bool,
    typer.Option(
        "--open-page",
        envvar="PASSAFE_OPEN_PAGE",
        help="Dashboard: neither token nor TLS; only where something before the page sees to both.",
    ),
]
