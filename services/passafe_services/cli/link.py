"""``passafe link``: show and change the links of a running system."""

from pathlib import Path
from typing import Annotated

import typer
from msgspec import json as msgspec_json
from passafe_protocol.keys import DEFAULT_ROBOT, require_robot_name
from passafe_protocol.link_wire import settings_of
from passafe_protocol.messages import LinkState
from passafe_protocol.shapes import as_dict
from passafe_protocol.topics import LINKS

from passafe_services.cli.access_options import InsecureOption, KeysOption, secured_endpoint
from passafe_services.cli.bus_options import DEFAULT_ROUTER, RobotOption, RouterOption
from passafe_services.cli.errors import OptionError
from passafe_services.cli.link_text import LINK_KEYS, changed_parameters, link_fields, require_ranges, settings_text
from passafe_services.cli.output_files import require_separate
from passafe_services.loop.errors import LinkSilentError
from passafe_services.loop.inlet import require_links
from passafe_services.loop.link_console import ANSWER_S, SOURCE, open_link_console
from passafe_services.tools.link_import.irtt_json import Clocks, Direction
from passafe_services.tools.link_import.trace_file import read_measurement, write_trace

app = typer.Typer(help="Show and change the links of a running system; import measured networks.", no_args_is_help=True)

NAMES = ", ".join(LINKS)
WaitOption = Annotated[
    float, typer.Option("--wait", metavar="SECONDS", min=0.1, max=60.0, help="Time to wait for an answer.")
]


@app.command("show")
def show(
    name: Annotated[str | None, typer.Argument(metavar="NAME", help=f"Link: {NAMES}; all if not given.")] = None,
    router: RouterOption = DEFAULT_ROUTER,
    robot: RobotOption = DEFAULT_ROBOT,
    keys: KeysOption = None,
    insecure: InsecureOption = False,
    wait: WaitOption = ANSWER_S,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object with an entry for each link.")] = False,
) -> None:
    """Show the settings in force and the message counts of links.

    Examples, while `passafe demo` runs in another terminal:

    - `passafe link show`
    - `passafe link show plant-to-filter --json`
    """
    require_links([] if name is None else [name])
    endpoint = secured_endpoint(router, SOURCE, require_robot_name(robot), keys=keys, insecure=insecure)
    with open_link_console(endpoint, robot=robot, answer_s=wait) as console:
        states = console.states() if name is None else {name: console.state(name)}
    if not states:
        raise LinkSilentError("of any name", "any process", wait)
    typer.echo(_json(states) if json else "\n".join(map(_lines, states.values())))


@app.command("set")
def set_link(
    name: Annotated[str, typer.Argument(metavar="NAME", help=f"Link: {NAMES}.")],
    settings: Annotated[list[str], typer.Argument(metavar="KEY=VALUE", help=f"Keys: {', '.join(LINK_KEYS)}.")],
    router: RouterOption = DEFAULT_ROUTER,
    robot: RobotOption = DEFAULT_ROBOT,
    keys: KeysOption = None,
    insecure: InsecureOption = False,
    wait: WaitOption = ANSWER_S,
    json: Annotated[bool, typer.Option("--json", help="Print the state of the link as JSON.")] = False,
) -> None:
    """Change settings of a link; settings that are not named stay.

    Returns when the process that reads the link has acknowledged them. Times are in seconds, probabilities from 0 to
    1; several outages are joined by + (outage=2:2.5+5:6), quantiles too. A trace can only be given when a system
    starts.

    Examples:
    - `passafe link set plant-to-filter delay=0.2 jitter=0.02 loss=0.1`
    - `passafe link set plant-to-filter delay=0 jitter=0 loss=0`
    - `passafe link set plant-to-filter network=lte-driving`
    """
    require_links([name])
    fields = link_fields(settings, "KEY=VALUE")
    if "trace" in fields:
        raise OptionError("trace", repr(fields["trace"]), "only when a system starts: by --link or in the scenario")
    require_ranges(fields, f"link {name}")  # refused before any process is asked
    endpoint = secured_endpoint(router, SOURCE, require_robot_name(robot), keys=keys, insecure=insecure)
    with open_link_console(endpoint, robot=robot, answer_s=wait) as console:
        before = console.state(name)
        wanted = changed_parameters(settings_of(before.parameters), fields, f"link {name}")
        state = console.configure(name, wanted)
    if json:
        typer.echo(_json({name: state}))
    else:
        typer.echo(f"{name}: {settings_text(state)}")


@app.command("import")
def import_measurement(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="JSON of `irtt client -o`, or what `ping` printed.")],
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FILE", help="Trace to write, a CSV file.")],
    direction: Annotated[
        Direction, typer.Option(help="Of irtt: from client to server (send), or back (receive).")
    ] = Direction.SEND,
    clocks: Annotated[
        Clocks, typer.Option(help="Of irtt: whether the clocks of client and server are synchronized.")
    ] = Clocks.UNKNOWN,
    interval: Annotated[
        float | None,
        typer.Option(metavar="SECONDS", min=1e-3, max=3600, help="Of ping without -D: time between probes."),
    ] = None,
) -> None:
    """Turn a measurement of a network into a trace of delays and losses for a link.

    Prints what was measured, and what had to be assumed: ping knows round trips alone, and two clocks are never the
    same.

    Examples:
    - `passafe link import measured.json --direction receive --out back.csv`
    - `passafe link import ping.txt --out there.csv`, then `passafe simulate --link plant-to-filter:trace=there.csv`
    """
    require_separate({"--out": out}, [file])
    measured = read_measurement(file, direction=direction, clocks=clocks, interval_s=interval)
    write_trace(out, measured)
    typer.echo("\n".join(measured.summary()))
    typer.echo(f"trace {out}")


def _json(states: dict[str, LinkState]) -> str:
    return msgspec_json.encode({name: as_dict(state) for name, state in states.items()}).decode()


def _lines(state: LinkState) -> str:
    counts = {
        "entered": state.entered,
        "delivered": state.delivered,
        "lost": state.dropped_loss,
        "queue full": state.dropped_queue,
        "outage": state.dropped_outage,
        "copies": state.duplicated,
        "corrupted": state.corrupted,
        "in flight": state.in_flight,
    }
    text = ", ".join(f"{name} {count}" for name, count in counts.items())
    return f"{state.link}: {settings_text(state)}\n    {text}"
