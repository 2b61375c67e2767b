"""Number of random requests of a test: a slice in CI, all of them by ``make core-campaign``."""

import pytest


def requests_of(whole: int, some: int) -> pytest.MarkDecorator:
    """Return the parameter ``count`` of a test.

    Args:
        whole: Requests of the campaign.
        some: Requests in CI, the first ones.
    """
    return pytest.mark.parametrize("count", [pytest.param(whole, marks=pytest.mark.campaign, id="all"), some])
