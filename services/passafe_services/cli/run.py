"""``passafe run``: run one process of the system, for containers, other hosts and a person at a keyboard."""

import time
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Annotated, Final

import typer

from passafe_services.cli.access_options import InsecureOption, KeysOption, secured_endpoint
from passafe_services.cli.bus_options import DEFAULT_ROUTER, RouterOption, parse_endpoint
from passafe_services.cli.driver_text import driver_from
from passafe_services.cli.failure import run_reporting_errors
from passafe_services.cli.log_name import log_path
from passafe_services.cli.options import (
    DEFAULT_ROTATE_S,
    DEFAULT_SCENARIO,
    RotateMbOption,
    RotateSOption,
    RunScenarioOption,
)
from passafe_services.cli.page_options import OpenPageOption, PageCertificateOption, PageKeyOption, PageTokenOption
from passafe_services.cli.robot_option import LiveRobotOption, name_and_file
from passafe_services.loop.health_report import HealthReporter
from passafe_services.loop.process_name import ProcessName
from passafe_services.loop.process_options import Device, ProcessOptions
from passafe_services.scenarios.load import load_scenario

PAGE_PORT: Final = 8080
PORTS: Final = {ProcessName.BRIDGE: 8765}
"""Port of a process if none is given, where it is not that of the page; 8765 is the one that viewers propose."""

LinkedRouterOption = Annotated[
    list[str] | None,
    typer.Option(
        "--linked-router",
        metavar="HOST:PORT",
        envvar="PASSAFE_LINKED_ROUTER",
        help="Router: router of another site to connect to; repeat for others. Only one of two links to the other.",
    ),
]


def run(
    context: typer.Context,
    process: Annotated[ProcessName, typer.Argument(metavar="PROCESS", help="Process to run.")],
    scenario: RunScenarioOption = DEFAULT_SCENARIO,
    router: RouterOption = DEFAULT_ROUTER,
    robot: LiveRobotOption = None,
    keys: KeysOption = None,
    insecure: InsecureOption = False,
    linked_router: LinkedRouterOption = None,
    device: Annotated[Device, typer.Option(help="Operator: the scenario's script, or a keyboard.")] = Device.SCRIPT,
    duration: Annotated[
        float | None,
        typer.Option(metavar="SECONDS", min=0.0, help="Plant and recorder: plant time after which the plant ends."),
    ] = None,
    out: Annotated[
        Path,
        typer.Option(
            "--out",
            "-o",
            metavar="FILE|FOLDER",
            envvar="PASSAFE_OUT",
            help="Recorder: MCAP log to write; in an existing folder a new one, named after scenario, mode and time.",
        ),
    ] = Path("run.mcap"),
    rotate_mb: RotateMbOption = None,
    rotate_s: RotateSOption = DEFAULT_ROTATE_S,
    port: Annotated[
        int | None,
        typer.Option(
            metavar="PORT",
            min=1,
            max=65535,
            envvar="PASSAFE_PORT",
            help="Dashboard, bridge: port of page or viewers; 8080 and 8765 if not given.",
        ),
    ] = None,
    host: Annotated[
        str, typer.Option(metavar="ADDRESS", envvar="PASSAFE_HOST", help="Dashboard, bridge: address of the same.")
    ] = "127.0.0.1",
    page_name: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            envvar="PASSAFE_PAGE_NAME",
            help="Dashboard: further host name by which its page is opened; repeat for others.",
        ),
    ] = None,
    runs: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER",
            envvar="PASSAFE_RUNS",
            help="Dashboard: folder of the logs and experiments that its page shows.",
        ),
    ] = None,
    page_token: PageTokenOption = "",
    page_certificate: PageCertificateOption = None,
    page_key: PageKeyOption = None,
    open_page: OpenPageOption = False,
    epoch: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            min=1,
            max=2**63 - 1,
            help="Epoch of its session, larger than that of every earlier one; the wall clock in ns if not given.",
        ),
    ] = None,
    health_folder: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER",
            envvar="PASSAFE_HEALTH",
            help="Folder, on a file system in memory, in which its loop reports for `passafe health`.",
        ),
    ] = None,
    take_over: Annotated[
        bool,
        typer.Option("--take-over", help="Operator: take over from the operator that drives; otherwise wait for it."),
    ] = False,
    start_stopped: Annotated[
        bool,
        typer.Option(
            "--start-stopped",
            envvar="PASSAFE_START_STOPPED",
            help="Plant: start with the emergency stop latched, so that a start moves nothing before `passafe clear`.",
        ),
    ] = False,
    driver: Annotated[
        str | None,
        typer.Option(
            "--driver",
            metavar="KIND[:KEY=VALUE,…]",
            envvar="PASSAFE_DRIVER",
            help="Plant: what reads and moves the robot, in the place of the scenario's: model, mujoco, udp-servo.",
        ),
    ] = None,
    lifeline: Annotated[
        bool, typer.Option("--lifeline", help="End when standard input is closed; `passafe demo` uses this.")
    ] = False,
    control_channel: Annotated[int | None, typer.Option("--control-channel", min=3, hidden=True)] = None,
) -> None:
    """Run one process of a system until Ctrl-C.

    All processes of a system take the same scenario and find each other through the router. An option that begins
    with the name of a process concerns that process alone.

    Examples:
    - `passafe run operator --device keyboard --take-over` drives the robot of a running demo
    - `passafe run bridge` lets Foxglove or Lichtblick watch a running demo (`passafe[foxglove]`)
    - `passafe run plant --driver udp-servo:host=192.0.2.9,port=8400` moves a servo instead of the model
    - `passafe run recorder --router 192.0.2.7:7447 --keys keys/recorder.robot --out runs/remote.mcap`
    """
    named, robot_file = name_and_file(robot)
    effective = load_scenario(scenario, robot=robot_file)
    endpoint = secured_endpoint(router, process, named, keys=keys, insecure=insecure, quiet=lifeline)
    linked = [replace(parse_endpoint(text), credentials=endpoint.credentials) for text in linked_router or ()]
    if process is ProcessName.OPERATOR and not lifeline:  # one of `passafe demo` starts before its filter
        from passafe_services.cli.joined_scenario import joined_scenario  # noqa: PLC0415 - the others stay small

        source = context.get_parameter_source("scenario")
        is_given = source is not None and source.name != "DEFAULT"
        effective = joined_scenario(effective, endpoint, named, is_given=is_given)
    options = ProcessOptions(
        scenario=effective,
        endpoint=endpoint,
        robot=named,
        device=device,
        duration_s=duration,
        out=log_path(out, effective),
        rotate_mb=rotate_mb,
        rotate_s=rotate_s,
        port=port or PORTS.get(process, PAGE_PORT),
        host=host,
        epoch=time.time_ns() if epoch is None else epoch,
        take_over=take_over,
        start_stopped=start_stopped,
        lifeline=lifeline,
        health=HealthReporter(process, health_folder),
        page_names=tuple(page_name or ()),
        runs=runs,
        page_token=page_token,
        page_certificate=page_certificate,
        page_key=page_key,
        open_page=open_page,
        driver=None if driver is None else driver_from(driver, effective),
        linked_routers=tuple(linked),
        control_channel=control_channel,
    )
    if process is ProcessName.FILTER and not lifeline:  # `passafe demo` has done so
        from passafe_services.cli.check import warn_at_load  # noqa: PLC0415 - the other processes stay small

        warn_at_load(options.scenario)
    package = "passafe_dashboard" if process is ProcessName.DASHBOARD else f"passafe_services.{process}"
    import_module(f"{package}.process").start(options)


if __name__ == "__main__":  # `passafe demo` starts this, without the imports of the other commands
    app = typer.Typer(pretty_exceptions_enable=False)
    app.command()(run)
    run_reporting_errors(app)
