"""The page of the networks has every model with its values."""

import re

from pages import DOCS, text_of
from passafe_protocol.networks import NETWORKS

ROW = re.compile(r"^\| `([^`]+)` \| (\S+), (\S+) \| (\S+) %", re.MULTILINE)


def test_page_has_the_values_of_every_model() -> None:
    rows = {name: values for name, *values in ROW.findall(text_of(DOCS / "networks.md"))}

    assert list(rows) == list(NETWORKS)
    for name, model in NETWORKS.items():
        mean, extent, loss = rows[name]
        assert mean == f"{1e3 * model.mean_delay_s:.1f}"
        assert extent.endswith(f"–{1e3 * model.longest_delay_s:.4g}")
        assert loss == f"{100 * model.loss_share:.2g}"


def test_page_has_sources_and_assumptions() -> None:
    page = text_of(DOCS / "networks.md")
    for model in NETWORKS.values():
        assert f"| {model.source} | {model.assumed} |" in page
