"""A session with a page: what the page asks over its channel happens, and the page sees it."""

import sys
from dataclasses import replace

import pytest
from passafe_services.loop.process_exit import ExitCause
from passafe_services.loop.process_spec import ProcessSpec
from passafe_services.session.control_messages import StartRun
from passafe_services.session.planned_run import PlannedRun
from passafe_services.session.supervised_session import run_session
from toy_runs import Script, press_ctrl_c, toy, toy_run

pytestmark = pytest.mark.live

PAGE = """
import json, signal, socket, sys
signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
with socket.socket(fileno=int(sys.argv[sys.argv.index("--channel") + 1])) as end, end.makefile("rw") as channel:
    def ask(number, **request):
        channel.write(json.dumps({"number": number, "request": request}) + "\\n")
        channel.flush()
    print("passafe-ready dashboard", flush=True)
    asked = set()
    for line in channel:
        message = json.loads(line)
        if message["type"] == "answer":
            print("answer", message["number"], message["refusal"], flush=True)
        elif (message["state"], message["run"]) not in asked:
            asked.add((message["state"], message["run"]))
            if message["state"] == "running" and message["run"] == 1:
                ask(1, type="kill", process="dashboard")
                ask(2, type="start", choices={"scenario": "next"})
            elif message["state"] == "running":
                ask(3, type="end")
            elif message["state"] == "stopped":
                ask(4, type="nonsense")
    print("closed", flush=True)
    signal.pause()
"""


def test_page_asks_over_its_channel_and_sees_what_becomes_of_it() -> None:
    page = ProcessSpec(name="dashboard", argv=(sys.executable, "-S", "-c", PAGE), control_option="--channel")
    script = Script(toy_run("plant"), toy("router"), page)
    asked: list[StartRun] = []
    lines: list[str] = []

    def prepare(request: StartRun) -> PlannedRun:
        asked.append(request)
        return replace(toy_run("plant"), choices=request.choices)

    def emit(line: str) -> None:
        lines.append(line)
        if line.endswith("| closed"):  # what is no request closed the channel
            press_ctrl_c()

    end = run_session(script.session, prepare, emit=emit)

    assert (end.cause, end.clean) == (ExitCause.SIGNAL, True)
    assert script.ready_runs == [1, 2]
    assert [request.choices.scenario for request in asked] == ["next"]
    assert [line.partition("answer ")[2] for line in lines if "answer" in line] == [
        "1 {'field': '', 'reason': 'the page cannot ask for its own end'}",
        "2 None",
        "3 None",
    ]
