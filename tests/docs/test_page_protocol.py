"""The page's protocol is described as it is: its routes, and its messages as the server reads and writes them."""

import json
import re
from pathlib import Path

import pytest
from pages import DOCS, text_of
from passafe_dashboard.routes.drive_messages import PageMessage, PageSteer, Release, Script, Take, parsed, refusal

PAGE = text_of(DOCS / "page-protocol.md")
MESSAGES = [json.loads(found) for found in re.findall(r"^\| `(\{.+?\})` \|", PAGE, flags=re.MULTILINE)]
ROUTES = Path(__file__).parents[2] / "dashboard" / "passafe_dashboard" / "routes"


@pytest.mark.parametrize("kind", [Take, PageSteer, Release, Script], ids=lambda kind: kind.__name__)
def test_each_message_of_a_page_is_shown_as_it_is_read(kind: type[PageMessage]) -> None:
    [shown] = [message for message in MESSAGES if isinstance(parsed(json.dumps(message)), kind)]
    assert set(shown) == set(kind.model_fields)


def test_each_message_of_the_server_is_shown() -> None:
    shown = {message["type"]: set(message) for message in MESSAGES}
    assert shown["refused"] == set(refusal("what", "got", "allowed"))
    assert shown["clock"] == {"type", "server_ms"}
    assert shown["driver"] == {"type", "page", "you", "driver", "reason"}


def test_every_route_for_programs_is_listed() -> None:
    source = "".join(path.read_text(encoding="utf-8") for path in ROUTES.glob("*.py"))
    found = re.findall(r'@router\.(get|put|post|delete)\(\s*"(/api/[^"]+|/healthz)"', source)
    assert len(found) > 10
    for method, path in found:
        assert f"`{method.upper()} {path.replace(':path', '')}`" in PAGE
