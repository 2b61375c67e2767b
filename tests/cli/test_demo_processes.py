"""The child processes of a demo: their order, and how one of them is recognised."""

from itertools import pairwise
from pathlib import Path

import pytest
from passafe_services.cli.demo_processes import RESTARTED, demo_processes, is_demo_process
from passafe_services.loop.process_name import ProcessName
from passafe_services.loop.process_spec import ProcessSpec
from passafe_services.loop.router_endpoint import RouterEndpoint

HERE = RouterEndpoint(port=7447)
OF_A_DEMO = [name for name in ProcessName if name != "bridge"]


def processes(page_port: int | None = None, *, restart: bool = False) -> list[ProcessSpec]:
    files = Path("a.json"), Path("a.mcap")
    return demo_processes(
        files[0], HERE, files[1], robot="left-arm", keys=None, page_port=page_port, duration_s=None, restart=restart
    )


def test_plant_starts_last_and_a_headless_demo_has_no_dashboard() -> None:
    assert [one.name for one in processes(8080)] == OF_A_DEMO
    assert [one.name for one in processes()] == [name for name in OF_A_DEMO if name != "dashboard"]


def test_restart_leaves_recorder_and_plant_out() -> None:
    assert {one.name for one in processes(8080, restart=True) if one.restarts} == {*RESTARTED}
    assert not any(one.restarts for one in processes(8080))


@pytest.mark.parametrize("name", OF_A_DEMO)
def test_process_is_recognised_by_name_and_router(name: ProcessName) -> None:
    [argv] = (list(one.argv) for one in processes(8080) if is_demo_process(one.argv, name, HERE))

    assert argv[4] == name
    assert ("--robot", "left-arm") in pairwise(argv)
    assert not is_demo_process(argv, name, RouterEndpoint(port=7448))
    assert not is_demo_process(["tail", "-f", *argv], name, HERE)
    assert not is_demo_process([], name, HERE)
