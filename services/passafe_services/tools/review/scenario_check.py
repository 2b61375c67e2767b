"""Check that a log has one configuration: its metadata, every ScenarioInfo in it, and the ticks say the same."""

import json
from collections.abc import Mapping
from typing import ClassVar

from passafe_protocol.messages import ScenarioInfo
from passafe_protocol.topics import SCENARIO
from pydantic import ValidationError

from passafe_services.log.chunk_decoding import Wants
from passafe_services.log.log_pass import LogSlice
from passafe_services.log.message_columns import RECORD
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.review.agreement import LogAgreement
from passafe_services.tools.review.property import Property
from passafe_services.tools.review.run_identity import RunIdentity


class ScenarioCheck:
    """Check of the configurations of a log.

    Args:
        identity: Identity of the run that the log states.

    Attributes:
        agreement: Differences.
    """

    wants: ClassVar[Wants] = {SCENARIO.name: (RECORD,)}

    def __init__(self, identity: RunIdentity) -> None:
        self.agreement = LogAgreement("published configurations that differ from the log's = 0")
        self._identity = identity

    def take(self, part: LogSlice) -> None:
        """Take the next messages."""
        for block in part.blocks(SCENARIO.name):
            for header, info in block.objects(RECORD):
                self.compare(f"scenario {header.sequence} of {header.source}", info)

    def property(self, *, is_published: bool) -> Property:
        """Return the property that all configurations are one.

        Args:
            is_published: Whether the log has ticks of a filter, which publishes its configuration before its first.
        """
        found = self.agreement.property()
        if self.agreement.compared or not is_published:
            return found
        return found.model_copy(update={"required": True, "note": "no configuration of the filter is in the log"})

    def compare(self, name: str, info: ScenarioInfo) -> None:
        """Compare a published configuration with the log's."""
        self.agreement.compared += 1
        if info.driver != self._identity.driver:
            text = f"{name}: driver: the log has {self._identity.driver}, the filter published {info.driver}"
            self.agreement.note("driver", text)
        self._compare_versions(name, info)
        try:
            published = Scenario.model_validate(json.loads(info.scenario_json)).model_dump(mode="json")
        except (ValidationError, ValueError) as error:
            self.agreement.note("scenario", f"{name}: cannot be read: {str(error).splitlines()[0]}")
            return
        for path, ours, theirs in _differences(self._identity.scenario.model_dump(mode="json"), published):
            self.agreement.note(path, f"{name}: {path}: the log has {ours}, the filter published {theirs}")

    def _compare_versions(self, name: str, info: ScenarioInfo) -> None:
        """Compare the versions of packages that both the log and the filter name."""
        published, logged = _versions(info.versions_json), self._identity.versions
        if logged and not published:
            self.agreement.note("versions", f"{name}: versions: cannot be read")
        for package in sorted(published.keys() & logged.keys()):
            if published[package] != logged[package]:
                said = f"the log has {logged[package]}, the filter published {published[package]}"
                self.agreement.note("versions", f"{name}: version of {package}: {said}")


def _versions(text: str) -> Mapping[str, object]:
    """Return published versions; nothing of a text that holds none."""
    try:
        found = json.loads(text)
    except ValueError:
        return {}
    return found if isinstance(found, Mapping) else {}


def _differences(ours: object, theirs: object, path: str = "") -> list[tuple[str, object, object]]:
    """Return the keys whose values differ, with both values, the deepest keys only."""
    if isinstance(ours, Mapping) and isinstance(theirs, Mapping):
        found = []
        for key in dict.fromkeys([*ours, *theirs]):
            inner = f"{path}.{key}" if path else str(key)
            found += _differences(ours.get(key), theirs.get(key), inner)
        return found
    return [] if ours == theirs else [(path, ours, theirs)]
