"""Errors of campaigns.

* ``CampaignError``
    * ``CampaignResultsError``: a file of outcomes that cannot be gone on with
    * ``NoSafeStartError``: a box of starts without a safe one
"""

from collections.abc import Sequence
from pathlib import Path


class CampaignError(Exception):
    """Anything that a campaign refuses."""


class CampaignResultsError(CampaignError):
    """A file of outcomes that cannot be gone on with.

    Attributes:
        path: The file.
    """

    def __init__(self, path: Path, got: str) -> None:
        self.path = path
        super().__init__(f"{path}: got {got}, allowed the same campaign's outcomes, or no file there")


class NoSafeStartError(CampaignError):
    """A box of starts without a safe one.

    Attributes:
        scenario: Name.
    """

    def __init__(self, scenario: str, low: Sequence[float], high: Sequence[float], draws: int) -> None:
        self.scenario = scenario
        super().__init__(
            f"plant.start_low, plant.start_high: got {tuple(low)} to {tuple(high)}, where {draws} draws "
            f"found no state that {scenario}'s rows protect; allowed a box with such states"
        )
