"""Scenario of a system that runs already, for a process that joins it."""

import json
import time
from typing import Final

from passafe_protocol.codec import decode
from passafe_protocol.errors import ProtocolError
from passafe_protocol.messages import ScenarioInfo
from passafe_protocol.topics import SCENARIO

from passafe_services.loop.bus import Bus
from passafe_services.scenarios.load import scenario_from
from passafe_services.scenarios.schema import Scenario

WAIT_S: Final = 2.5
"""Time to wait for the filter's scenario, which it repeats every second, s."""

POLL_S: Final = 0.05


def running_scenario(bus: Bus, wait_s: float = WAIT_S) -> Scenario | None:
    """Return the scenario of the running filter; ``None`` if none says so in time.

    Args:
        bus: An open session.
        wait_s: Longest time to wait, s.

    Raises:
        ScenarioError: The filter's scenario cannot be used by this version.
    """
    reader, until_s = bus.reader(SCENARIO), time.monotonic() + wait_s
    while time.monotonic() < until_s:
        for data in reader.drain():
            try:
                _, info = decode(SCENARIO, data)
            except ProtocolError:
                continue
            if isinstance(info, ScenarioInfo):
                return scenario_from(json.loads(info.scenario_json), "the running filter")
        time.sleep(POLL_S)
    return None
