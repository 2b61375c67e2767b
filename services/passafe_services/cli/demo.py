"""``passafe demo``: the whole system as processes on this machine."""

from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Final

import typer
from passafe_dashboard.address import require_free_page_port
from rich.console import Console

from passafe_services.cli.demo_processes import demo_processes
from passafe_services.cli.options import (
    DEFAULT_SCENARIO,
    DurationOption,
    LawOption,
    LinkOption,
    ModeOption,
    RateOption,
    ScenarioOption,
    scenario_from_options,
    writable_folder,
)
from passafe_services.cli.verdict import exit_code, print_verdict
from passafe_services.loop.keep_awake import awake_specs
from passafe_services.loop.process_exit import ExitCause, Restarts, RunOutcome
from passafe_services.loop.realtime import processors
from passafe_services.loop.router_endpoint import DEFAULT_PORT, LOOPBACK, RouterEndpoint
from passafe_services.loop.supervisor import supervise
from passafe_services.router.port import require_free_router_port
from passafe_services.scenarios.design import design_of, robot_of
from passafe_services.scenarios.errors import ScenarioError
from passafe_services.scenarios.load import scenario_from
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.recover import recover
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict

DIED: Final = 3
"""Exit code when a process died for good, could not be started or did not come to its end."""

PATIENCE_S: Final = 60.0
"""How much longer than ``--duration`` a run may take by the clock: plant time begins with the filter's first input."""

PAGE_RATE_HZ: Final = 500.0
FEW_PROCESSORS: Final = 2
"""With a page on so few processors there are at most so many ticks a second, unless a rate is asked for: six processes
at 1 kHz leave a browser there nothing to draw with (``docs/decisions/0014-slower-beside-a-page.md``)."""


def demo(
    scenario: ScenarioOption = DEFAULT_SCENARIO,
    mode: ModeOption = None,
    law: LawOption = None,
    duration: DurationOption = None,
    rate: RateOption = None,
    headless: Annotated[bool, typer.Option("--headless", help="Without the dashboard.")] = False,
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the log.")] = Path("runs"),
    port: Annotated[int, typer.Option(min=1, max=65535, help="Port of the dashboard's page.")] = 8080,
    router_port: Annotated[int, typer.Option(min=1, max=65535, help="Port of the router.")] = DEFAULT_PORT,
    link: LinkOption = None,
    restart: Annotated[
        bool,
        typer.Option(
            "--restart",
            help="Start router, operator, filter and dashboard again when they die, at most "
            f"{Restarts().most} times a minute each: kill one and see the robot go on. A recorder or plant that dies "
            "still ends the run.",
        ),
    ] = False,
    keep_awake: Annotated[
        bool,
        typer.Option(
            "--keep-awake",
            help="Keep the processors from halting at the lowest priority: punctual loops on an idle virtual machine.",
        ),
    ] = False,
) -> None:
    """Run router, recorder, dashboard, operator, filter and plant as processes of their own.

    Open the address that is printed, drive with `passafe run operator --device keyboard` in another terminal, and
    end with Ctrl-C. Then the log is judged as by `passafe review`. Exits with 0 only if every required property
    holds and every process ended well.

    With a page on two processors there are at most 500 ticks a second, so that a browser has room; `--rate` insists.

    With `--restart`, `passafe kill filter` in another terminal shows what a dead process does to the robot: its own
    fail-safe stops it, and the next filter takes over from there.

    Example: `passafe demo --mode off --duration 10`
    """
    console = Console(highlight=False, soft_wrap=True)
    chosen = scenario_from_options(scenario, mode=mode, law=law, duration_s=duration, rate_hz=rate, links=link or ())
    if rate is None and not headless:
        chosen = with_room_for_a_page(chosen, processors(), console.print)
    design_of(chosen, robot_of(chosen))  # what cannot be built is said before anything starts
    folder = writable_folder(out)
    endpoint = RouterEndpoint(host=LOOPBACK, port=router_port)
    require_free_router_port(endpoint)
    if not headless:
        require_free_page_port(LOOPBACK, port)
    stamp = datetime.now(UTC).strftime("%Y%m%d-%H%M%S")
    base = folder / f"{chosen.name}-{chosen.filter.mode}-{stamp}"
    effective = base.with_suffix(".scenario.json")
    effective.write_text(chosen.model_dump_json(indent=2), encoding="utf-8")
    log = base.with_suffix(".mcap")
    specs = [
        *(awake_specs() if keep_awake else ()),
        *demo_processes(
            effective,
            endpoint,
            log,
            page_port=None if headless else port,
            duration_s=duration,
            restart=restart,
        ),
    ]

    def say_ready() -> None:
        if not headless:
            console.print(f"dashboard http://{LOOPBACK}:{port}/")
        console.print("running; end with Ctrl-C" if duration is None else f"running for {duration:g} s")

    most_s = None if duration is None else duration + PATIENCE_S
    outcome = supervise(specs, duration_s=most_s, on_ready=say_ready, emit=console.out)
    raise typer.Exit(_conclude(outcome, log, chosen, console))


def with_room_for_a_page(scenario: Scenario, count: int, say: Callable[[str], object]) -> Scenario:
    """Return a scenario with no more ticks a second than leave a browser room on so many processors.

    Args:
        scenario: As the options have it.
        count: How many processors there are.
        say: Takes the words for what is changed.
    """
    if count > FEW_PROCESSORS or scenario.rate_hz <= PAGE_RATE_HZ:
        return scenario
    try:
        slower = scenario_from(scenario.model_dump(mode="json"), scenario.name, {"rate_hz": PAGE_RATE_HZ})
    except ScenarioError:  # it stands only its own rate
        return scenario
    say(
        f"{PAGE_RATE_HZ:g} ticks a second, not the scenario's {scenario.rate_hz:g}: a browser has to draw the page "
        f"on the same {count} processors; --rate {scenario.rate_hz:g} insists, --headless does without a page"
    )
    return slower


def _conclude(outcome: RunOutcome, log: Path, scenario: Scenario, console: Console) -> int:
    """Print how the run ended, the verdict and the log's path; return the exit code."""
    too_long = outcome.cause is ExitCause.DURATION  # the plant ends a run that goes as it should
    if not outcome.clean or too_long:
        console.print(f"[bold red]{outcome.detail}{', and the plant has not come to its end' if too_long else ''}[/]")
    if outcome.restarts:
        counts = ", ".join(f"{name} {count}" for name, count in outcome.restarts.items())
        console.print(f"restarts  {counts}", highlight=False)
    if not log.exists():
        return DIED
    read = RunLog.read(log)
    if not read.finished:
        torn = log.with_suffix(".torn.mcap")
        log.rename(torn)
        kept = recover(torn, log)
        console.print(f"the recorder did not finish its log; {kept.messages} messages were recovered from {torn}")
    verdict = Verdict.of(read, CoreEvaluator(scenario))
    print_verdict(verdict, log)
    return exit_code(verdict) if outcome.clean and not too_long else DIED
