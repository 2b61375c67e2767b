"""Processes of a session that die, are killed or restarted on request, and who may be."""

import pytest
from passafe_services.loop.process_exit import ExitCause
from passafe_services.loop.process_name import ProcessName
from passafe_services.loop.process_spec import RestartPolicy
from played_sessions import kill_named, pid_of, play, when
from toy_runs import Script, press_ctrl_c, toy, toy_run

pytestmark = pytest.mark.live


@pytest.mark.parametrize("victim", ["plant", "router"])
def test_process_that_dies_ends_all(victim: str) -> None:
    script = Script(toy_run("plant"))
    script.on_ready = lambda _number: kill_named(script, victim)

    end, _ = play(script)

    assert (end.cause, end.culprit) == (ExitCause.DIED, victim)
    assert not (end.clean and script.outcomes[0].clean)


def test_router_that_dies_in_a_change_ends_all() -> None:
    script = Script(toy_run("plant"))
    script.on_ready = lambda _number: script.session.start(toy_run("plant"))
    script.on_ended = lambda number: kill_named(script, "router") if number == 1 else None

    end, _ = play(script)

    assert (end.cause, end.culprit) == (ExitCause.DIED, "router")


def test_router_with_a_policy_is_restarted_in_a_change() -> None:
    script = Script(toy_run("plant"), toy("router", restarts=RestartPolicy()))
    session, killed = script.session, []

    def kill(number: int) -> None:
        if number == 1:
            killed.append(pid_of(script, "router"))
            kill_named(script, "router")

    def is_back() -> bool:
        """Check for another router; on a busy machine the next run may be ready before its end is noticed."""
        running = session.state.processes["router"].state == "running"
        return script.ready_runs == [1, 2] and running and pid_of(script, "router") not in {0, *killed}

    end_when_back = when(is_back, press_ctrl_c)
    script.on_ready = lambda number: session.start(toy_run("plant")) if number == 1 else end_when_back()
    script.on_ended = kill
    session.on_change = end_when_back

    end, lines = play(script)

    assert end.cause is ExitCause.SIGNAL
    assert "router died: killed by SIGKILL; restarted" in lines
    assert script.ready_runs == [1, 2]


def test_killed_process_stays_down_until_its_restart() -> None:
    script = Script(toy_run("filter", "plant"))
    session, name = script.session, ProcessName.FILTER
    seen = []
    script.on_ready = lambda _number: session.kill(name)

    def restart() -> None:
        seen.append((session.permitted(name), session.kill(name)))
        session.restart(name)

    down = when(lambda: session.state.processes["filter"].state == "down", restart)
    back = when(lambda: bool(seen) and session.state.processes["filter"].state == "running", press_ctrl_c)

    def listen() -> None:
        if "filter" in session.state.processes:
            down()
            back()

    session.on_change = listen
    end, lines = play(script)

    assert seen == [(("restart",), False)]
    assert "filter restarted on request" in lines
    [outcome] = script.outcomes
    assert outcome.clean
    assert outcome.killed_on_request == {"filter": 1}
    assert outcome.restarts == {"filter": 1}
    assert end.clean


def test_permission_for_a_process_depends_on_which_it_is() -> None:
    script = Script(toy_run("recorder", "plant"), toy("router"), toy("dashboard"), toy("awake-0"))
    session = script.session
    names = ("router", "dashboard", "recorder", "plant", "awake-0", "filter")
    found = {}

    def look(_number: int) -> None:
        found.update({name: session.permitted(name) for name in names})
        press_ctrl_c()

    script.on_ready = look
    script.on_ended = lambda _number: found.update(stopping=session.permitted("router"))
    play(script)

    both = ("kill", "restart")
    assert found == {
        "router": both,
        "dashboard": (),
        "recorder": ("kill",),
        "plant": both,
        "awake-0": (),
        "filter": (),
        "stopping": (),
    }
