"""Links of a whole running system, changed by a user while it runs."""

import json
import signal
import subprocess
import sys

import pytest
from running_demo import RunningDemo, running_demo

from protocol.messages import FilterTick, LinkConfig, LinkState, PlantState
from protocol.topics import LINKS
from services.review.log import RunLog

pytestmark = pytest.mark.live

DELAY_S = 0.15


def link(demo: RunningDemo, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "services.cli", "link", *arguments, "--router", demo.router, "--wait", "10"],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


@pytest.fixture(scope="module")
def changed(tmp_path_factory: pytest.TempPathFactory) -> tuple[RunLog, dict[str, subprocess.CompletedProcess[str]]]:
    folder = tmp_path_factory.mktemp("links")
    with running_demo(folder, "--headless", "--rate", "250", "--link", "operator-to-filter:loss=0.2") as demo:
        demo.wait_for("running; end with Ctrl-C")
        said = {
            "show": link(demo, "show", "--json"),
            "set": link(demo, "set", "plant-to-filter", f"delay={DELAY_S}", "jitter=0.01"),
            "after": link(demo, "show", "plant-to-filter"),
            "range": link(demo, "set", "plant-to-filter", "loss=2"),
            "name": link(demo, "set", "plant-to-moon", "loss=0.5"),
        }
        demo.process.send_signal(signal.SIGINT)
        demo.end()
    (log,) = folder.glob("*.mcap")
    return RunLog.read(log), said


def test_show_tells_settings_and_counts_of_every_link(
    changed: tuple[RunLog, dict[str, subprocess.CompletedProcess[str]]],
) -> None:
    states = json.loads(changed[1]["show"].stdout)

    assert list(states) == list(LINKS)
    assert states["operator-to-filter"]["parameters"]["loss"] == 0.2
    assert states["operator-to-filter"]["dropped_loss"] > 0
    assert states["plant-to-operator"]["put"] == states["plant-to-operator"]["delivered"] > 0


def test_set_returns_with_the_value_in_force_and_the_states_are_late_from_then_on(
    changed: tuple[RunLog, dict[str, subprocess.CompletedProcess[str]]],
) -> None:
    log, said = changed
    assert said["set"].returncode == 0, said["set"].stderr
    assert said["set"].stdout == f"plant-to-filter: delay={DELAY_S} jitter=0.01\n"
    assert said["after"].stdout.startswith(f"plant-to-filter: delay={DELAY_S} jitter=0.01\n    put ")

    sent = {(s.header.epoch, s.header.sequence): s.header for s in log.of(PlantState)}
    (asked,) = log.of(LinkConfig)
    answered = next(s for s in log.of(LinkState) if s.body.config_source == "console")
    assert (answered.body.config_epoch, answered.body.config_sequence) == (asked.header.epoch, asked.header.sequence)
    assert answered.body.parameters.delay_s == DELAY_S
    lags_s = [
        (tick.header.sent_ns, (consumed.received_ns - sent[consumed.epoch, consumed.sequence].sent_ns) * 1e-9)
        for tick in log.of(FilterTick)
        for consumed in tick.body.consumed
        if consumed.topic == "state" and (consumed.epoch, consumed.sequence) in sent
    ]
    before = [lag for at_ns, lag in lags_s if at_ns < answered.header.sent_ns]
    after = [lag for at_ns, lag in lags_s if at_ns > answered.header.sent_ns + 100_000_000]
    assert min(before) < 0.05
    assert min(after) >= DELAY_S - 0.01 - 1e-6


@pytest.mark.parametrize(("which", "named"), [("range", "loss '2'"), ("name", "plant-to-moon")])
def test_what_cannot_be_is_refused_in_one_line(
    changed: tuple[RunLog, dict[str, subprocess.CompletedProcess[str]]], which: str, named: str
) -> None:
    refused = changed[1][which]

    assert refused.returncode != 0
    assert named in refused.stderr
    assert refused.stderr.count("\n") == 1


def test_the_log_ends_with_the_state_of_every_link(
    changed: tuple[RunLog, dict[str, subprocess.CompletedProcess[str]]],
) -> None:
    last = {state.body.link: state.body for state in changed[0].of(LinkState)}

    assert {name: state.occasion for name, state in last.items()} == dict.fromkeys(LINKS, "end")
