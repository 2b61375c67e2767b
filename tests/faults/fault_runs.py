"""Runs into which faults are injected, and what is judged of them."""

import os
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from random import Random
from time import sleep
from typing import Final

from fault_rows import Fault, ending, from_strangers, survived
from fault_system import FaultSystem, fault_system, now_ns
from passafe_protocol.messages import PlantState
from passafe_protocol.topics import STATE
from passafe_services.log.errors import LogFileError
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict
from running_demo import all_gone
from timeline import Effect, Timeline

ASKED: Final = ("safe", "energy", "bounded", "certified", "consistent")
"""Properties that have to hold in every run, whatever happens."""

ORPHANS_S: Final = 15.0
PLANNED_S: Final = "60"
SHORT_S: Final = "6"
GOES_ON: Final = ("full disk", "folder deleted")
"""Faults after which a run goes on to its planned end, although it cannot be recorded."""
"""Plant time that a run was to last whose end is a fault, s."""

STRANGERS: Final = ("--insecure",)
"""Arguments with which a demo lets anybody write on its bus."""


@dataclass(kw_only=True, slots=True)
class Result:
    """Result of one fault in one pass.

    Attributes:
        fault: Its key.
        to_safe_s: See ``Effect``; ``None`` too if the run ended.
        to_recover_s: See ``Effect``.
        undriven_s: See ``Effect``.
        story: What log and terminal say of it.
        broken: Promises that it broke.
        h_min: Smallest barrier value of its run.
        lost: Whether the robot ever stopped being driven.
    """

    fault: str
    to_safe_s: float | None = None
    to_recover_s: float | None = None
    undriven_s: float = 0.0
    story: list[str] = field(default_factory=list)
    broken: list[str] = field(default_factory=list)
    h_min: float | None = None
    lost: bool = False


def run_through(faults: Sequence[Fault], rng: Random, folder: Path, *arguments: str) -> list[Result]:
    """Inject faults one after the other into one run, in random order at random moments; return their results."""
    order = rng.sample(faults, len(faults))
    moments = []
    with fault_system(folder / "log", folder, "--restart", *arguments) as system:
        sleep(2.0)  # the robot drives
        for fault in order:
            sleep(rng.uniform(0.3, 0.7))
            began_ns = now_ns()
            with fault.inject(system):
                sleep(fault.length_s)
                ended_ns = now_ns()
            sys.stdout.write(f"  {fault.key}\n")
            sys.stdout.flush()
            sleep(fault.settle_s)
            moments.append((fault, began_ns, ended_ns, now_ns()))
            if system.demo.process.poll() is not None:
                break
        with suppress(ProcessLookupError):
            system.demo.process.send_signal(2)
        system.demo.end()
        log = system.log
    read = of_one_plant(RunLog.read(log))
    timeline, verdict = Timeline.of(read), Verdict.of(read, CoreEvaluator(read.identity.scenario))
    results = [
        result_of(
            fault, timeline.effect(began_ns, ended_ns, until_ns), verdict, alive=until_ns < timeline.end_ns + 10**9
        )
        for fault, began_ns, ended_ns, until_ns in moments
    ]
    return results + [Result(fault=missing.key, broken=["the run had ended"]) for missing in order[len(moments) :]]


def of_one_plant(log: RunLog) -> RunLog:
    """Return a log with the states of one plant alone, the one that sent most: others are a stranger's."""
    states = log.of(PlantState)
    [(plant, _)] = Counter(state.header.epoch for state in states).most_common(1)
    own = [state for state in states if state.header.epoch == plant]
    return replace(log, messages=dict(log.messages) | {STATE.name: own})


def result_of(fault: Fault, effect: Effect, verdict: Verdict, *, alive: bool) -> Result:
    """Return the result of a fault that a run survives."""
    broken = [
        f"{name}: {entry.worst}" for name, entry in verdict.properties.items() if name in ASKED and entry.holds is False
    ]
    if effect.to_safe_s is not None and effect.to_safe_s > fault.safe_s:
        broken.append(f"safe after {effect.to_safe_s:.2f} s")
    if fault.drives_on and effect.to_safe_s is not None:
        broken.append(f"not driven for {effect.undriven_s:.2f} s")
    if effect.to_recover_s is None or effect.to_recover_s > fault.recover_s:
        got = "never" if effect.to_recover_s is None else f"after {effect.to_recover_s:.2f} s"
        broken.append(f"driven again {got}")
    if not alive:
        broken.append("the run ended")
    return Result(
        fault=fault.key,
        to_safe_s=effect.to_safe_s,
        to_recover_s=effect.to_recover_s,
        undriven_s=effect.undriven_s,
        story=list(effect.story[:3]),
        broken=broken,
        h_min=verdict.h_min,
        lost=effect.to_safe_s is not None,
    )


def run_to_end(fault: Fault, rng: Random, folder: Path) -> Result:
    """Inject a fault that ends a run into a run of its own; return its result."""
    with ExitStack() as stack:
        log_folder = folder / "log"
        log_folder.mkdir()
        if fault.name == "full disk" and os.geteuid() == 0:
            mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=2m", "tmpfs", log_folder], check=False)  # noqa: S607 - the system's
            if mounted.returncode == 0:
                stack.callback(subprocess.run, ["umount", "-l", log_folder], check=False)
        duration = SHORT_S if fault.name in GOES_ON else PLANNED_S
        system = stack.enter_context(fault_system(log_folder, folder, "--duration", duration))
        sleep(rng.uniform(1.0, 2.0))
        with fault.inject(system):
            code = system.demo.end()
        result = Result(fault=fault.key, lost=True)
        if code != fault.exit_code:
            result.broken.append(f"exit code {code}, not {fault.exit_code}")
        if not all_gone(list(system.pids.values()), ORPHANS_S):
            result.broken.append("processes outlived the run")
        judge_end(system, fault, result)
        return result


def judge_end(system: FaultSystem, fault: Fault, result: Result) -> None:
    """Add what the terminal and the log say of a run that ended."""
    said = [line.strip() for line in system.demo.lines if "died" in line or "ended:" in line or "error:" in line]
    result.story = said[:2] or ["nothing: the supervisor is dead"]
    verdicts = [line for line in system.demo.lines if line.startswith("verdict") or "has no log" in line]
    if fault.target != "demo" and (not verdicts or any(line.startswith("verdict   holds") for line in verdicts)):
        result.broken.append("no verdict" if not verdicts else "the verdict is: holds")
    result.story += [line.strip()[:120] for line in verdicts]
    if any("Traceback" in line for line in system.demo.lines):
        result.broken.append("a traceback")
    try:
        read = RunLog.read(system.log)
    except (LogFileError, IndexError):
        if fault.name != "folder deleted":
            result.broken.append("no readable log")
        return
    verdict = Verdict.of(read, CoreEvaluator(read.identity.scenario))
    result.h_min = verdict.h_min
    result.broken += [
        f"{name}: {verdict.properties[name].worst}" for name in ASKED if verdict.properties[name].holds is False
    ]
    if fault.target == "demo" and not read.finished:
        result.broken.append("the log is not finished")


def one_pass(seed: int, only: str = "") -> list[Result]:
    """Run every fault once, in the order and at the moments of a seed; return the results."""
    rng, results = Random(seed), []
    for faults, arguments in ((tuple(survived()), ()), (tuple(from_strangers()), STRANGERS)):
        chosen = [fault for fault in faults if only in fault.key]
        if chosen:
            with tempfile.TemporaryDirectory() as folder:
                results += run_through(chosen, rng, Path(folder), *arguments)
    for fault in ending():
        if only in fault.key:
            sys.stdout.write(f"  {fault.key}\n")
            with tempfile.TemporaryDirectory() as folder:
                results.append(run_to_end(fault, rng, Path(folder)))
    return results
