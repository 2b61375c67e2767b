"""``passafe simulate``: run a scenario in virtual time, with the same log as a live run."""

from pathlib import Path
from typing import Annotated

import typer
from rich.progress import Progress, TimeRemainingColumn

from passafe_services.cli.check import warn_at_load
from passafe_services.cli.judging import judged
from passafe_services.cli.options import (
    DEFAULT_SCENARIO,
    DurationOption,
    LawOption,
    LinkOption,
    ModeOption,
    RateOption,
    ScenarioOption,
    scenario_from_options,
    writable_folder,
)
from passafe_services.cli.output_files import require_separate
from passafe_services.cli.robot_option import OwnRobotOption
from passafe_services.cli.verdict import exit_code, print_verdict
from passafe_services.log.log_file import in_place_of
from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.recorder.lockstep_log import LockstepLog
from passafe_services.scenarios.info import versions
from passafe_services.simulation import lockstep_loop, steps_of


def simulate(
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FILE", help="MCAP log to write.")],
    scenario: ScenarioOption = DEFAULT_SCENARIO,
    mode: ModeOption = None,
    law: LawOption = None,
    duration: DurationOption = None,
    rate: RateOption = None,
    link: LinkOption = None,
    robot: OwnRobotOption = None,
) -> None:
    """Run a scenario in virtual time and write its log.

    Nodes, links and log format are those of `passafe demo`; only the clock is virtual, so two runs of the same
    scenario give the same messages to the last byte. Exits with 0 only if every required property holds.

    Examples:
    - `passafe simulate --out runs/good.mcap`
    - `passafe simulate --mode safe --link plant-to-filter:delay=0.2,loss=0.1 --out runs/bad.mcap`
    """
    chosen = scenario_from_options(
        scenario, mode=mode, law=law, duration_s=duration, rate_hz=rate, links=link or (), robot=robot
    )
    given = (scenario, robot.rpartition(":")[0] if robot else "")
    require_separate({"--out": out}, [Path(each) for each in given if each])
    warn_at_load(chosen)
    metadata = run_metadata(scenario_json=chosen.model_dump_json(), versions=versions(), driver="lockstep")
    writable_folder(out.parent)
    steps = steps_of(chosen)
    chunk = max(1, steps // 100)
    with (
        in_place_of(out, replace=True) as unfinished,
        LogWriter(unfinished, metadata) as log,
        Progress(*Progress.get_default_columns()[:3], TimeRemainingColumn()) as bar,
    ):
        loop = lockstep_loop(chosen, observer=LockstepLog(log))
        task = bar.add_task("simulating", total=steps)
        for start in range(0, steps, chunk):
            loop.run(min(chunk, steps - start))
            bar.advance(task, min(chunk, steps - start))
        loop.finish()
    verdict = judged(out).verdict
    print_verdict(verdict, out)
    raise typer.Exit(exit_code(verdict))
