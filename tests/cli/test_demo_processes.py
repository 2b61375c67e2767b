"""The child processes of a demo: their order, and how one of them is recognised."""

from itertools import pairwise
from pathlib import Path

import pytest
from passafe_services.cli.demo_processes import RESTARTED, DemoProcesses, is_demo_process
from passafe_services.loop.process_name import ProcessName
from passafe_services.loop.process_spec import ProcessSpec
from passafe_services.loop.router_endpoint import RouterEndpoint

HERE = RouterEndpoint(port=7447)
OF_A_DEMO = [name for name in ProcessName if name != "bridge"]


FILE, LOG = Path("a.json"), Path("a.mcap")


def demo(page_port: int | None = None, *, restart: bool = False) -> DemoProcesses:
    return DemoProcesses(HERE, robot="left-arm", keys=None, page_port=page_port, duration_s=2.0, restart=restart)


def processes(page_port: int | None = None, *, restart: bool = False) -> list[ProcessSpec]:
    made = demo(page_port, restart=restart)
    return [*made.of_session(FILE), *made.of_run(FILE, LOG)]


def test_router_and_page_stay_and_the_plant_of_a_run_starts_last() -> None:
    assert [one.name for one in demo(8080).of_session(FILE)] == ["router", "dashboard"]
    assert [one.name for one in demo().of_session(FILE)] == ["router"]
    assert [one.name for one in demo().of_run(FILE, LOG)] == ["recorder", "operator", "filter", "plant"]
    assert [one.name for one in demo().of_run(FILE, None)] == ["operator", "filter", "plant"]


def test_page_alone_has_a_control_channel() -> None:
    assert {one.name for one in processes(8080) if one.control_option} == {"dashboard"}
    assert not any(one.control_option for one in processes())


def test_emergency_stop_is_carried_into_the_next_plant() -> None:
    *others, plant = demo().of_run(FILE, LOG, start_stopped=True)

    assert plant.argv[-1] == "--start-stopped"
    assert not any("--start-stopped" in one.argv for one in [*others, *demo().of_run(FILE, LOG)])


def test_plant_and_recorder_know_the_duration() -> None:
    informed = {one.name for one in processes() if ("--duration", "2.0") in pairwise(one.argv)}
    assert informed == {"plant", "recorder"}


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
