"""Links of a whole running system, changed by a user and by a page while it runs."""

import json
import signal
import subprocess
import sys
from typing import NamedTuple

import httpx
import pytest
from passafe_protocol.messages import FilterTick, LinkConfig, LinkState, PlantState
from passafe_protocol.topics import LINKS
from passafe_services.tools.review.link_accounts import link_accounts
from passafe_services.tools.review.run_log import RunLog
from running_demo import RunningDemo, running_demo

pytestmark = pytest.mark.live

DELAY_S = 0.15


class Changed(NamedTuple):
    """A run whose links were changed: its log, and what each command and the page output."""

    log: RunLog
    show: subprocess.CompletedProcess[str]
    set: subprocess.CompletedProcess[str]
    put: httpx.Response


def link(demo: RunningDemo, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [
            sys.executable,
            "-P",
            "-m",
            "passafe_services.cli",
            "link",
            *arguments,
            "--router",
            demo.router,
            "--wait",
            "20",
        ],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


@pytest.fixture(scope="module")
def changed(tmp_path_factory: pytest.TempPathFactory) -> Changed:
    folder = tmp_path_factory.mktemp("links")
    with running_demo(folder, "--rate", "250", "--link", "operator-to-filter:loss=0.2") as demo:
        page = demo.wait_for(r"dashboard http://127\.0\.0\.1:\d+/").split()[1]
        show = link(demo, "show", "--json")
        set_ = link(demo, "set", "plant-to-filter", f"delay={DELAY_S}", "jitter=0.01")
        with httpx.Client(timeout=60, verify=False) as client:  # noqa: S501 - no TLS here
            put = client.put(f"{page}api/links/plant-to-operator", json={"delay_s": 0.25})
        demo.process.send_signal(signal.SIGINT)
        demo.end(timeout_s=300.0)
    (log,) = folder.glob("*.mcap")
    return Changed(RunLog.read(log), show, set_, put)


def test_show_tells_settings_and_counts_of_every_link(changed: Changed) -> None:
    states = json.loads(changed.show.stdout)

    assert list(states) == list(LINKS)
    assert states["operator-to-filter"]["parameters"]["loss"] == 0.2
    assert states["operator-to-filter"]["dropped_loss"] > 0
    assert states["plant-to-operator"]["entered"] == states["plant-to-operator"]["delivered"] > 0


def test_set_returns_the_value_in_force_and_delays_the_states(changed: Changed) -> None:
    log = changed.log
    assert changed.set.returncode == 0, changed.set.stderr
    assert changed.set.stdout == f"plant-to-filter: delay={DELAY_S} jitter=0.01\n"

    sent = {(s.header.epoch, s.header.sequence): s.header for s in log.of(PlantState)}
    asked = next(config for config in log.of(LinkConfig) if config.header.source == "console")
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
    assert min(after) >= DELAY_S - 0.01  # less the jitter


def test_the_log_ends_with_the_state_of_every_link(changed: Changed) -> None:
    last = {state.body.link: state.body for state in changed.log.of(LinkState)}

    assert {name: state.trigger for name, state in last.items()} == dict.fromkeys(LINKS, "end")


def test_dashboard_changes_a_link_and_returns_its_settings(changed: Changed) -> None:
    assert changed.put.status_code == 200, changed.put.text
    assert changed.put.json()["settings"]["delay_s"] == 0.25
    answered = next(s for s in changed.log.of(LinkState) if s.body.config_source == "dashboard")
    assert (answered.header.source, answered.body.parameters.delay_s) == ("operator", 0.25)


def test_every_message_of_every_link_is_accounted_for(changed: Changed) -> None:
    accounts = link_accounts(changed.log)

    assert [account.link for account in accounts] == list(LINKS)
    assert all(account.final for account in accounts)
    assert accounts[0].dropped["loss"] > 0
    gaps = changed.log.counts["link_event"].gaps  # on a machine with much else to do the log may lack some
    reported = [account.differences.get("events missing in the log", 0) for account in accounts]
    assert max(reported) == gaps
    assert [account.text for account in accounts if account.differences and not gaps] == []
    assert [account.text for account in accounts if {"balance", "put and sent"} & set(account.differences)] == []
