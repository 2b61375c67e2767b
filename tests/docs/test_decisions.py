"""The index of decision records lists every record, by its own title."""

import re
from pathlib import Path

import pytest
from pages import DOCS, text_of

RECORDS = sorted((DOCS / "decisions").glob("0*.md"))


@pytest.mark.parametrize("record", RECORDS, ids=lambda path: path.stem)
def test_record_is_listed_and_has_its_parts(record: Path) -> None:
    text = text_of(record)

    assert f"]({record.name}) |" in text_of(DOCS / "decisions" / "README.md")
    assert re.match(rf"# {record.name[:4]}: .+\n", text)
    for part in ("Context", "Decision", "Would change it"):
        assert f"**{part}.**" in text, part
