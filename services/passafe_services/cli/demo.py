"""``passafe demo``: run the whole system as processes on this machine."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer
from passafe_dashboard.address import require_free_page_port
from passafe_protocol.identity import ROUTER
from rich.console import Console

from passafe_services.cli.access_options import InsecureOption, KeysOption, secured_endpoint
from passafe_services.cli.demo_outcome import DIED
from passafe_services.cli.demo_processes import DemoProcesses, rotation_options
from passafe_services.cli.demo_reports import DemoReports
from passafe_services.cli.demo_runs import DemoOptions, planned_run
from passafe_services.cli.options import (
    DEFAULT_ROTATE_S,
    DEFAULT_SCENARIO,
    DurationOption,
    LawOption,
    LinkOption,
    ModeOption,
    RateOption,
    RotateMbOption,
    RotateSOption,
    ScenarioOption,
    writable_folder,
)
from passafe_services.cli.robot_option import LiveRobotOption, name_and_file
from passafe_services.keys.throw_away import discard_throw_away_keys, throw_away_keys
from passafe_services.loop.keep_awake import awake_specs
from passafe_services.loop.process_spec import RestartPolicy
from passafe_services.loop.router_endpoint import DEFAULT_PORT, LOOPBACK, RouterEndpoint
from passafe_services.router.port import require_free_router_port
from passafe_services.session.control_messages import RunChoices, StartRun
from passafe_services.session.planned_run import PlannedRun
from passafe_services.session.run_session import RunSession
from passafe_services.session.supervised_session import run_session

PortOption = Annotated[
    int, typer.Option("--port", metavar="PORT", min=1, max=65535, help="Port of the dashboard's page.")
]
RouterPortOption = Annotated[
    int, typer.Option("--router-port", metavar="PORT", min=1, max=65535, help="Port of the router.")
]
RestartOption = Annotated[
    bool,
    typer.Option(
        "--restart",
        help="Restart router, operator, filter and dashboard when they die, each at most "
        f"{RestartPolicy().most} times a minute. A recorder or plant that dies still ends the run.",
    ),
]
KeepAwakeOption = Annotated[
    bool,
    typer.Option(
        "--keep-awake",
        help="Keep the processors from halting, at the lowest priority: for punctual loops on an idle virtual machine.",
    ),
]


def demo(
    scenario: ScenarioOption = DEFAULT_SCENARIO,
    mode: ModeOption = None,
    law: LawOption = None,
    duration: DurationOption = None,
    rate: RateOption = None,
    headless: Annotated[bool, typer.Option("--headless", help="Run without the dashboard.")] = False,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FOLDER", help="Folder for the log.")] = Path("runs"),
    rotate_mb: RotateMbOption = None,
    rotate_s: RotateSOption = DEFAULT_ROTATE_S,
    port: PortOption = 8080,
    router_port: RouterPortOption = DEFAULT_PORT,
    robot: LiveRobotOption = None,
    keys: KeysOption = None,
    insecure: InsecureOption = False,
    link: LinkOption = None,
    restart: RestartOption = False,
    keep_awake: KeepAwakeOption = False,
) -> None:
    """Run router, recorder, dashboard, operator, filter and plant, each as a process.

    Open the address that is printed and drive there, or with `passafe run operator --device keyboard --take-over` in
    another terminal, and end with Ctrl-C. The log is then judged as by `passafe review`. Exits with 0 only if every
    required property holds and every process ended in order, with 3 if a process died.

    Its messages are encrypted, and the router lets each process do what its role permits, by keys that are made for
    this run and that `passafe run` and `passafe link` find on this host; `--keys` takes those of a deployment.

    The page starts, ends and changes runs: scenario, mode, prediction, rate, recording. Router and page stay; every run
    has a log of its own, and the worst verdict decides the exit code. With `--duration` the first run that lasts so
    long ends the demo.

    With a page on two processors there are at most 500 ticks a second, so that a browser has time to draw; `--rate`
    overrides this.

    Examples:
    - `passafe demo --mode off --duration 10` shows what happens without the filter
    - `passafe demo --link plant-to-filter:delay=0.2,jitter=0.02,loss=0.1` drives over a bad network
    - `passafe demo --restart`, then `passafe kill filter` in another terminal: the robot's own fail-safe stops it,
      and the next filter takes over
    """
    console = Console(highlight=False, soft_wrap=True)
    named, robot_file = name_and_file(robot)
    options = DemoOptions(
        scenario=scenario,
        mode=mode,
        law=law,
        duration_s=duration,
        rate_hz=rate,
        links=tuple(link or ()),
        has_page=not headless,
        folder=out,
        robot=robot_file,
    )
    request = StartRun(choices=RunChoices(scenario=scenario))
    chosen = options.checked_scenario(request.choices, console.print)  # refused before any process starts
    writable_folder(out)
    endpoint = RouterEndpoint(host=LOOPBACK, port=router_port)
    require_free_router_port(endpoint)
    if not headless:
        require_free_page_port(LOOPBACK, port)
    with _keys(named, endpoint, keys, insecure=insecure) as folder_of_keys:
        processes = DemoProcesses(
            endpoint,
            robot=named,
            keys=folder_of_keys,
            page_port=None if headless else port,
            runs=out,
            duration_s=duration,
            restart=restart,
            rotation=rotation_options(rotate_mb, rotate_s),
        )

        def prepare(request: StartRun) -> PlannedRun:
            scenario = options.checked_scenario(request.choices)
            return planned_run(request, scenario, options, processes)

        first = planned_run(request, chosen, options, processes)
        reports = DemoReports(console, "" if headless else f"http://{LOOPBACK}:{port}/")
        base = (*(awake_specs() if keep_awake else ()), *processes.of_session(first.scenario_file))
        session = RunSession(base, first, reports=reports, scenarios=options.scenarios)
        end = run_session(session, prepare, emit=console.out)
    code = reports.finish()
    raise typer.Exit(code if end.clean else DIED)


@contextmanager
def _keys(robot: str, endpoint: RouterEndpoint, keys: Path | None, *, insecure: bool) -> Iterator[Path | None]:
    """Yield the folder of the deployment's keys: the one that is given, or throw-away ones; none if insecure."""
    if insecure or keys is not None:
        discard_throw_away_keys(endpoint.port)
        secured_endpoint(f"{endpoint.host}:{endpoint.port}", ROUTER, robot, keys=keys, insecure=insecure)
        yield keys
    else:
        with throw_away_keys(robot, endpoint.port) as folder:
            yield folder
