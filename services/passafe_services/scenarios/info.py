"""Identity of a run for its log: effective scenario and versions of passafe and its dependencies."""

import json
import platform
from functools import cache
from importlib.metadata import version
from typing import Final

from passafe_protocol.messages import ScenarioInfo

from passafe_services.scenarios.schema import Scenario

COMPUTES_WITH: Final = ("passafe", "casadi", "piqp", "numpy", "scipy", "eclipse-zenoh", "mcap", "protobuf")


def versions() -> dict[str, str]:
    """Return the versions of passafe, its numerical dependencies and the interpreter."""
    return dict(_versions())


@cache  # reading the metadata takes longer than building a loop
def _versions() -> dict[str, str]:
    return {name: version(name) for name in COMPUTES_WITH} | {"python": platform.python_version()}


def scenario_info(scenario: Scenario, driver: str) -> ScenarioInfo:
    """Return the effective scenario as a message.

    Args:
        scenario: The effective scenario.
        driver: ``live`` or ``lockstep``.
    """
    return ScenarioInfo(scenario.model_dump_json(), driver, json.dumps(versions(), sort_keys=True))
