"""``passafe run``: one process of the system, for containers, other hosts and a person at a keyboard."""

import sys
import time
from collections.abc import Callable
from contextlib import ExitStack
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from dashboard.process import serve
from services.assembly import filter_node, link_settings, plant_node, versions
from services.cli.options import (
    DEFAULT_ROUTER,
    DEFAULT_SCENARIO,
    RouterOption,
    ScenarioOption,
    parse_endpoint,
)
from services.operator.node import OperatorNode
from services.operator.sources import build_source
from services.operator.terminal import Terminal
from services.recorder.log_writer import run_metadata
from services.recorder.main import run_recorder
from services.router.process import run_router
from services.runtime.endpoint import Endpoint
from services.runtime.live import run_live
from services.runtime.node import Node
from services.scenarios.design import robot_of
from services.scenarios.load import load_scenario
from services.scenarios.schema import KeyboardSource, Scenario


class ProcessName(StrEnum):
    """What ``passafe run`` can run."""

    ROUTER = "router"
    RECORDER = "recorder"
    DASHBOARD = "dashboard"
    OPERATOR = "operator"
    FILTER = "filter"
    PLANT = "plant"


class Device(StrEnum):
    """Who drives."""

    SCRIPT = "script"
    KEYBOARD = "keyboard"


def run(
    process: Annotated[ProcessName, typer.Argument(help="Which process.")],
    scenario: ScenarioOption = DEFAULT_SCENARIO,
    router: RouterOption = DEFAULT_ROUTER,
    device: Annotated[Device, typer.Option(help="operator: the scenario's script, or a keyboard.")] = Device.SCRIPT,
    duration: Annotated[float | None, typer.Option(help="plant: seconds of plant time, then end.")] = None,
    out: Annotated[Path, typer.Option("--out", "-o", help="recorder: MCAP log to write.")] = Path("run.mcap"),
    port: Annotated[int, typer.Option(min=1, max=65535, help="dashboard: port of its page.")] = 8080,
    host: Annotated[str, typer.Option(help="dashboard: address of its page.")] = "127.0.0.1",
    lifeline: Annotated[bool, typer.Option(help="End when standard input does; used by `passafe demo`.")] = False,
) -> None:
    """Run one process until Ctrl-C.

    All processes of a system take the same scenario and find each other through the router.

    Example: `passafe run operator --device keyboard` drives the robot of a running demo.
    """
    endpoint = parse_endpoint(router)
    chosen = load_scenario(scenario)
    if process is ProcessName.ROUTER:
        run_router(endpoint.port, host=endpoint.host, lifeline=lifeline)
    elif process is ProcessName.RECORDER:
        metadata = run_metadata(scenario_json=chosen.model_dump_json(), versions=versions(), driver="live")
        run_recorder(endpoint, out, metadata, lifeline=lifeline)
    elif process is ProcessName.DASHBOARD:
        serve(endpoint, port, host=host, scenario=chosen, lifeline=lifeline)
    elif process is ProcessName.OPERATOR:
        _operator(chosen, endpoint, device, lifeline=lifeline)
    elif process is ProcessName.FILTER:
        _live(filter_node(chosen, "live"), chosen, endpoint, lifeline=lifeline)
    else:
        plant = plant_node(chosen)
        end_ns = None if duration is None else round(duration * 1e9)
        _live(
            plant,
            chosen,
            endpoint,
            lifeline=lifeline,
            finished=lambda: end_ns is not None and plant.plant_ns >= end_ns,
        )


def _operator(scenario: Scenario, endpoint: Endpoint, device: Device, *, lifeline: bool) -> None:
    epoch = time.time_ns()
    m = robot_of(scenario).system.m
    with ExitStack() as stack:
        if device is Device.KEYBOARD:
            terminal = stack.enter_context(Terminal())
            source = build_source(KeyboardSource(kind="keyboard"), m, keys=terminal.poll)
            node = OperatorNode(source, epoch=epoch, show=terminal.show)
        else:
            node = OperatorNode(build_source(scenario.operator.source, m), epoch=epoch)
        _live(node, scenario, endpoint, lifeline=lifeline, epoch=epoch, finished=lambda: node.finished)


def _live(
    node: Node,
    scenario: Scenario,
    endpoint: Endpoint,
    *,
    lifeline: bool,
    epoch: int | None = None,
    finished: Callable[[], bool] | None = None,
) -> None:
    report = run_live(
        node,
        rate_hz=scenario.rate_hz,
        endpoint=endpoint,
        links=link_settings(scenario),
        epoch=epoch,
        lifeline=lifeline,
        finished=finished,
    )
    sys.stderr.write(
        f"{node.name}: {report.steps} steps, {report.ticks_missed} missed, ended by {report.reason.value}\n"
    )
