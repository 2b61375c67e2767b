"""Names of the processes."""

from enum import StrEnum


class ProcessName(StrEnum):
    """Processes of ``passafe run``."""

    ROUTER = "router"
    RECORDER = "recorder"
    DASHBOARD = "dashboard"
    OPERATOR = "operator"
    FILTER = "filter"
    PLANT = "plant"
    BRIDGE = "bridge"
