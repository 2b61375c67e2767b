"""A demo whose page changes the run: what stays, what each log holds, what decides the exit code."""

import signal
from pathlib import Path
from typing import Any

import httpx
import pytest
from passafe_services.tools.review.run_log import RunLog
from running_demo import all_gone, running_demo

pytestmark = pytest.mark.live


class Page:
    """The page's server, as a program asks it."""

    def __init__(self, address: str) -> None:
        self._address = address

    def ask(self, method: str, path: str, body: dict[str, Any] | None = None, *, origin: str = "") -> httpx.Response:
        """Return the answer to a request."""
        headers = {"origin": origin} if origin else {}
        return httpx.request(method, f"{self._address}{path}", json=body, headers=headers, timeout=60.0)


def test_page_changes_the_run_while_router_and_page_stay(tmp_path: Path) -> None:
    with running_demo(tmp_path, "--rate", "200", "--scenario", "moving-disk") as demo:
        page = Page(demo.wait_for("dashboard http").split()[-1].rstrip("/"))
        first = demo.children()
        start = {"scenario": "walls-and-disks", "mode": "safe", "prediction": False}

        assert page.ask("POST", "/api/run", start, origin="http://evil.example").status_code == 403
        assert page.ask("POST", "/api/run", {"scenario": "../../etc/passwd"}).status_code == 422
        refused = page.ask("POST", "/api/run", start | {"rate_hz": 20.0})
        assert refused.status_code == 422
        assert "allowed" in refused.text
        assert page.ask("POST", "/api/run", start).status_code == 202
        demo.wait_for("run 2: walls-and-disks, mode safe, without prediction, 200 Hz")
        demo.wait_for("verdict ")  # on the first run, beside the second
        second = demo.children()
        assert page.ask("POST", "/api/processes/recorder/kill").status_code == 202
        assert page.ask("DELETE", "/api/run").status_code == 202
        demo.wait_for(r"run 2, .*: ended on request")
        assert page.ask("DELETE", "/api/run").status_code == 409
        assert page.ask("GET", "/api/run").json()["state"] == "stopped"
        demo.process.send_signal(signal.SIGINT)
        code = demo.end()

    lines = "".join(demo.lines)
    assert code in {0, 1}, lines  # by the verdicts: nothing died that was not to
    assert {name for name in first if second[name] == first[name]} == {"router", "dashboard"}
    assert all_gone([*first.values(), *second.values()], 5.0)
    assert "killed on request  recorder 1" in lines
    assert lines.count("verdict   ") == 2
    assert "Traceback" not in lines
    one, other = sorted(path for path in tmp_path.glob("*.mcap") if not path.name.endswith(".torn.mcap"))
    assert RunLog.read(one).identity.scenario.name == "moving-disk"
    law = RunLog.read(other).identity.scenario.filter
    assert (law.mode, law.prediction) == ("safe", False)
