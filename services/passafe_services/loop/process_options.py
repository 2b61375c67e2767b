"""What a process is started with."""

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from passafe_services.loop.router_endpoint import RouterEndpoint
from passafe_services.scenarios.schema import Scenario


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


@dataclass(frozen=True, kw_only=True, slots=True)
class ProcessOptions:
    """What ``passafe run`` was given; each process takes from it what concerns it.

    Attributes:
        scenario: Effective scenario, the same for all processes of a system.
        endpoint: Where the router listens.
        device: Operator: who drives.
        duration_s: Plant: seconds of plant time after which it ends; ``None``: never.
        out: Recorder: log to write.
        port: Dashboard: port of its page.
        host: Dashboard: address of its page.
        lifeline: Whether to end when standard input does.
    """

    scenario: Scenario
    endpoint: RouterEndpoint
    device: Device
    duration_s: float | None
    out: Path
    port: int
    host: str
    lifeline: bool
