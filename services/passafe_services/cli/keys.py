"""``passafe keys``: make, show, extend, renew and withdraw the certificates of a deployment."""

from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

import typer
from passafe_protocol.identity import Identity
from passafe_protocol.keys import DEFAULT_ROBOT

from passafe_services.cli.errors import OptionError
from passafe_services.cli.options import writable_folder
from passafe_services.keys.authority import CERTIFICATE_DAYS
from passafe_services.keys.credentials import EXPIRES_SOON_DAYS
from passafe_services.keys.deployment import AUTHORITY_FOLDER, Deployment, identities_of

app = typer.Typer(help="Make and renew the certificates of a deployment.", no_args_is_help=True)

FolderArgument = Annotated[Path, typer.Argument(metavar="FOLDER", help="Folder of the deployment's keys.")]
RobotsOption = Annotated[
    list[str] | None,
    typer.Option("--robot", metavar="NAME", help="Robot; repeat for others. `robot` if none is given."),
]
OperatorsOption = Annotated[
    list[str] | None,
    typer.Option("--operator", metavar="NAME", help="Person with keys of their own to drive each robot; repeat."),
]
HostsOption = Annotated[
    list[str] | None,
    typer.Option("--host", metavar="HOST", help="Name or address at which the router is reached; repeat for others."),
]
RoutersOption = Annotated[
    list[str] | None,
    typer.Option("--router", metavar="NAME", help="Name of a router where there are several, as for sites; repeat."),
]
DaysOption = Annotated[
    float, typer.Option("--days", metavar="N", min=0.001, max=3650, help="How long the certificates are valid.")
]


@app.command("make")
def make(
    folder: FolderArgument,
    robot: RobotsOption = None,
    operator: OperatorsOption = None,
    host: HostsOption = None,
    router: RoutersOption = None,
    days: DaysOption = CERTIFICATE_DAYS,
    if_missing: Annotated[
        bool, typer.Option("--if-missing", help="Leave a deployment that there is as it is.")
    ] = False,
) -> None:
    """Make the keys of a new deployment: an authority, a router, and every process of each robot.

    Copy to each host the one folder of the process that runs there, and keep `authority` on a host that runs none.

    Examples:
    - `passafe keys make keys --host router.example.org`
    - `passafe keys make keys --robot left-arm --robot right-arm --operator alice --operator bob --host 192.0.2.7`
    """
    if if_missing and (folder / AUTHORITY_FOLDER).exists():
        typer.echo(f"{folder} has keys")
        return
    wanted = identities_of(robot or [DEFAULT_ROBOT], operator or [], router or [""])
    issued = Deployment.create(writable_folder(folder, "FOLDER")).issue(wanted, hosts=host or [], days=days)
    typer.echo(
        f"{len(issued)} certificates in {folder}, valid for {days:g} days; keep {folder / 'authority'} to yourself"
    )


@app.command("add")
def add(
    folder: FolderArgument,
    robot: RobotsOption = None,
    operator: OperatorsOption = None,
    days: DaysOption = CERTIFICATE_DAYS,
) -> None:
    """Add a robot with all its processes, or with `--operator` a person who may drive a robot that there is.

    The router admits them when it has its new `admitted.txt` and was restarted; the processes reconnect by themselves.

    Example: `passafe keys add keys --robot left-arm --operator carol`
    """
    deployment = Deployment.open(folder)
    there = {holder.identity for holder in deployment.holders()}
    robots = robot or sorted({identity.robot for identity in there if identity.robot})
    wanted = [one for one in identities_of(robots, operator or [], []) if one not in there]
    if not wanted:
        raise OptionError("--robot, --operator", "only those that there are", "a new robot or a new person")
    for identity in deployment.issue(wanted, days=days):
        typer.echo(f"added {identity.common_name}")


@app.command("renew")
def renew(folder: FolderArgument, host: HostsOption = None, days: DaysOption = CERTIFICATE_DAYS) -> None:
    """Issue every certificate anew, with new keys, from the same authority: old ones stay valid until they expire.

    The router's names are those of `--host`, as for `passafe keys make`.
    """
    deployment = Deployment.open(folder)
    issued = deployment.issue([holder.identity for holder in deployment.holders()], hosts=host or [], days=days)
    typer.echo(f"{len(issued)} certificates renewed for {days:g} days; copy the folders and restart the processes")


@app.command("remove")
def remove(
    folder: FolderArgument,
    holder: Annotated[str, typer.Argument(metavar="HOLDER", help="Name as `passafe keys show` prints it.")],
) -> None:
    """Withdraw a certificate: the router refuses it from its next restart on, with its new `admitted.txt`.

    Example: `passafe keys remove keys operator.left-arm.carol`
    """
    Deployment.open(folder).remove(Identity.of(holder))
    typer.echo(f"removed {holder}; copy the router's folder and restart the router")


@app.command("show")
def show(folder: FolderArgument) -> None:
    """Print who has a certificate and when it expires; exit with 1 if one expires within 30 days."""
    now, soon = datetime.now(UTC), False
    for holder in Deployment.open(folder).holders():
        days = (holder.ends - now).total_seconds() / 86_400
        soon = soon or days < EXPIRES_SOON_DAYS
        note = "expired" if days < 0 else f"{days:.1f} days" if days < EXPIRES_SOON_DAYS else f"{days:.0f} days"
        typer.echo(f"{holder.identity.common_name:<40} until {holder.ends:%Y-%m-%d %H:%M} UTC, {note}")
    raise typer.Exit(int(soon))
