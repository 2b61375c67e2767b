"""Link settings of a scenario."""

from pathlib import Path

from passafe_protocol.errors import LinkSettingsError
from passafe_protocol.link_change import LinkChange
from passafe_protocol.link_settings import LinkSettings

from passafe_services.scenarios.errors import LinkTraceError
from passafe_services.scenarios.link_schema import ScenarioLink, changed_links
from passafe_services.scenarios.link_trace import read_trace
from passafe_services.scenarios.schema import Scenario


def link_settings(scenario: Scenario) -> dict[str, LinkSettings]:
    """Return the settings of the links that the scenario injects, by name.

    Raises:
        LinkTraceError: A trace that cannot be used.
    """
    return {name: _settings(config) for name, config in scenario.links.items()}


def link_changes(scenario: Scenario) -> tuple[LinkChange, ...]:
    """Return the changes of these settings that the scenario schedules, in order of time.

    Raises:
        LinkTraceError: A trace that cannot be used.
    """
    return tuple(
        LinkChange(at_s=change.at_s, link=change.link, settings=_settings(config))
        for change, config in changed_links(scenario.links, scenario.link_changes)
    )


def _settings(config: ScenarioLink) -> LinkSettings:
    if config.trace is None:
        return config.settings()
    path = Path(config.trace)
    try:
        return config.settings(read_trace(path))
    except LinkSettingsError as error:
        raise LinkTraceError(path, f"{error.field} {error.got}", error.allowed) from error
