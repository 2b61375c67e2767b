"""Outcomes on disk, a line each: an interrupted campaign goes on where it was."""

from collections.abc import Iterator
from pathlib import Path

from pydantic import BaseModel, ConfigDict, ValidationError

from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.campaign.errors import CampaignResultsError
from passafe_services.tools.campaign.rollout_result import RolloutResult


class CampaignHeading(BaseModel):
    """First line of a file: what the outcomes in it are of."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    scenario: Scenario
    duration_s: float


class CampaignResultsFile:
    """The outcomes of one campaign in a file.

    Attributes:
        path: The file.
        outcomes: By seed.
    """

    def __init__(self, path: Path, heading: CampaignHeading) -> None:
        """Open a file, or begin it.

        Raises:
            CampaignResultsError: It holds another campaign's outcomes, or no outcomes.
        """
        self.path = path
        self.outcomes: dict[int, RolloutResult] = {}
        if path.exists():
            self._read(heading)
        else:
            path.write_text(heading.model_dump_json() + "\n", encoding="utf-8")

    def add(self, batches: Iterator[list[RolloutResult]]) -> Iterator[list[RolloutResult]]:
        """Write outcomes down as they come, and pass them on."""
        with self.path.open("a", encoding="utf-8") as file:
            for batch in batches:
                file.writelines(outcome.model_dump_json() + "\n" for outcome in batch)
                file.flush()
                self.outcomes |= {outcome.seed: outcome for outcome in batch}
                yield batch

    def _read(self, heading: CampaignHeading) -> None:
        text = self.path.read_text(encoding="utf-8")
        whole = text[: text.rfind("\n") + 1]
        try:
            first, *lines = whole.splitlines()
            known = CampaignHeading.model_validate_json(first)
            read = [RolloutResult.model_validate_json(line) for line in lines]
        except (ValueError, ValidationError) as error:
            raise CampaignResultsError(self.path, "a file that holds no campaign") from error
        if known != heading:
            raise CampaignResultsError(self.path, "the outcomes of another scenario, duration or version")
        if whole != text:  # the last line was cut off
            self.path.write_text(whole, encoding="utf-8")
        self.outcomes = {outcome.seed: outcome for outcome in read}
