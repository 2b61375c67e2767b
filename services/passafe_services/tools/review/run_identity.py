"""Identity of the run in a log: scenario, driver and versions."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Literal

from passafe_protocol.messages import ScenarioInfo
from pydantic import BaseModel, ConfigDict, Field, Json, ValidationError

from passafe_services.log.log_writer import DRIVER_RECORD, SCENARIO_RECORD, VERSIONS_RECORD
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.review.errors import ScenarioRecordError

DriverName = Literal["live", "lockstep"]


class RunIdentity(BaseModel):
    """Identity of the run in a log.

    Attributes:
        scenario: Effective scenario.
        driver: Driver of the nodes.
        versions: Versions of passafe and its numerical dependencies, by name.
        steps: Driver of the run whose steps a re-run took again; ``None``: it took its own.
        planned_s: Plant time that the run was to last, s; ``None`` if it was to last until it was stopped.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    scenario: Json[Scenario]
    driver: DriverName
    versions: Json[dict[str, str]]
    steps: DriverName | None = None
    planned_s: Annotated[float | None, Field(allow_inf_nan=False)] = None

    @property
    def timing(self) -> DriverName:
        """Return the driver whose times the steps have."""
        return self.steps or self.driver


def identify(path: Path, metadata: Mapping[str, Mapping[str, str]], info: ScenarioInfo | None) -> RunIdentity:
    """Return the identity of the run in a log: from its metadata, else from the published ScenarioInfo.

    Args:
        path: The log.
        metadata: Its metadata records, by name.
        info: The first ScenarioInfo in it, if there is one.

    Raises:
        ScenarioRecordError: The log has no scenario, or one that this build cannot read.
    """
    if SCENARIO_RECORD in metadata:
        fields = {
            "scenario": metadata[SCENARIO_RECORD].get("json", ""),
            "driver": metadata.get(DRIVER_RECORD, {}).get("kind", ""),
            "versions": json.dumps(dict(metadata.get(VERSIONS_RECORD, {}))),
            "planned_s": metadata.get(DRIVER_RECORD, {}).get("planned_s"),
            "steps": metadata.get(DRIVER_RECORD, {}).get("steps"),
        }
    elif info is not None:
        fields = {"scenario": info.scenario_json, "driver": info.driver, "versions": info.versions_json}
    else:
        raise ScenarioRecordError(path, "does not say which scenario it is of")
    try:
        return RunIdentity.model_validate(fields)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        raise ScenarioRecordError(path, f"its {where} cannot be read: {first['msg']}") from error
