"""Options with which a process is started."""

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from passafe_services.loop.health_report import HealthReporter
from passafe_services.loop.router_endpoint import RouterEndpoint
from passafe_services.scenarios.driver_schema import AnyDriver
from passafe_services.scenarios.schema import Scenario


class Device(StrEnum):
    """Input device of the operator."""

    SCRIPT = "script"
    KEYBOARD = "keyboard"


@dataclass(frozen=True, kw_only=True, slots=True)
class ProcessOptions:
    """Options of ``passafe run``; each process uses those that concern it.

    Attributes:
        scenario: Effective scenario, the same for all processes of a system.
        endpoint: Address of the router, with the keys of the process.
        robot: Robot whose process it is.
        device: Operator: input device.
        duration_s: Plant and recorder: plant time after which the plant ends, s; ``None``: never.
        out: Recorder: log to write.
        rotate_mb: Recorder: size at which a file of the log ends and the next begins, MB; ``None``: at no size.
        rotate_s: Recorder: time after which a file ends, s; ``None``: never.
        port: Dashboard, bridge: port of its page, or of its WebSocket.
        host: Dashboard, bridge: address of the same.
        page_names: Dashboard: further names by which its page is reached.
        runs: Dashboard: folder of the logs and experiments that its page shows; ``None``: none.
        page_token: Dashboard: token that the page asks for; empty: one is made where one is needed.
        page_certificate: Dashboard: certificate of the page, PEM; ``None``: one is made where one is needed.
        page_key: Dashboard: its private key.
        open_page: Dashboard: whether the page does without both wherever it listens.
        epoch: Epoch of its session, another than those of all earlier ones of this process.
        take_over: Operator: whether to take the lease over from the operator that holds it.
        start_stopped: Plant: whether its emergency stop is latched from the start.
        lifeline: Whether to end when standard input closes.
        linked_routers: Router: routers of other sites that it connects to.
        health: Reporter of the health of its loop.
        driver: Plant: driver in the place of the scenario's; ``None``: that one.
        control_channel: Dashboard: file descriptor of its channel to the supervisor of a demo; ``None``: no demo.
    """

    scenario: Scenario
    endpoint: RouterEndpoint
    robot: str
    device: Device
    duration_s: float | None
    out: Path
    port: int
    host: str
    epoch: int
    take_over: bool
    start_stopped: bool
    lifeline: bool
    health: HealthReporter
    rotate_mb: float | None = None
    rotate_s: float | None = None
    page_names: tuple[str, ...] = ()
    runs: Path | None = None
    page_token: str = ""
    page_certificate: Path | None = None
    page_key: Path | None = None
    open_page: bool = False
    linked_routers: tuple[RouterEndpoint, ...] = ()
    driver: AnyDriver | None = None
    control_channel: int | None = None
