"""Reads the driver of a plant as a user types it: ``udp-servo:host=192.0.2.7,port=8400``."""

import tomllib
from typing import Any

from passafe_services.cli.errors import OptionError
from passafe_services.scenarios.driver_schema import AnyDriver
from passafe_services.scenarios.load import scenario_from
from passafe_services.scenarios.schema import Scenario

FORM = "KIND[:KEY=VALUE,…], for example udp-servo:port=8400"


def driver_from(text: str, scenario: Scenario) -> AnyDriver:
    """Return the driver that a text describes.

    Args:
        text: A kind, and its keys as a scenario file has them.
        scenario: The scenario whose driver it replaces.

    Raises:
        OptionError: A text of another form.
        ScenarioError: Keys that hold what they may not.
    """
    kind, _, rest = text.partition(":")
    fields: dict[str, Any] = {"kind": kind}
    for part in filter(None, rest.split(",")):
        key, equals, value = part.partition("=")
        if not equals or not key.isidentifier():
            raise OptionError("--driver", repr(part), FORM)
        fields[key] = _value(value)
    data = scenario.model_dump(mode="json")
    data["plant"]["driver"] = fields
    return scenario_from(data, scenario.name).plant.driver


def _value(text: str) -> object:
    """Return a value of TOML, or the text itself where it is none."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text
