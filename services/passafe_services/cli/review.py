"""``passafe review``: judge a run from its log."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from passafe_services.cli.errors import OptionError
from passafe_services.cli.judging import judged
from passafe_services.cli.junit import write_junit
from passafe_services.cli.options import writable_folder
from passafe_services.cli.output_files import require_separate
from passafe_services.cli.verdict import exit_code, print_verdict
from passafe_services.cli.verification import print_verification
from passafe_services.log.log_files import files_of
from passafe_services.log.log_pass import LogConsumer
from passafe_services.log.verification import verify as verify_log
from passafe_services.suggestion import suggestion
from passafe_services.tools.review.contract import PROPERTIES, LogContract, load_contract, under
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_identity import RunIdentity
from passafe_services.tools.review.verdict import Verdict
from passafe_services.tools.review.verified_verdict import VerifiedVerdict


def review(
    run: Annotated[
        Path,
        typer.Argument(
            metavar="LOG|FOLDER", help="MCAP log, whole or torn: its first file, or a folder that holds one recording."
        ),
    ],
    html: Annotated[
        Path | None, typer.Option("--html", metavar="FILE", help="Write an HTML report to this file.")
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print the verdict as one JSON object.")] = False,
    junit: Annotated[
        Path | None,
        typer.Option("--junit", metavar="FILE", help="Write the properties to this file, as JUnit XML."),
    ] = None,
    require: Annotated[
        list[str] | None,
        typer.Option("--require", metavar="PROPERTY", help="Require this property, whatever the mode; repeatable."),
    ] = None,
    contract: Annotated[
        Path | None,
        typer.Option("--contract", metavar="FILE", help="Also ask for the bounds in this TOML file (a log contract)."),
    ] = None,
    verify: Annotated[
        bool, typer.Option("--verify", help="Also check that the log is as its recorder wrote and signed it.")
    ] = False,
    authority: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Certificate (PEM) of the authority that you trust, or of the recorder itself; with it --verify.",
        ),
    ] = None,
) -> None:
    """Judge a run from its log.

    Barriers and power margin are recomputed from the plant's states alone, between samples too; filter telemetry is
    not trusted. Exits with 0 only if every required property holds, and with `--verify` only if all of the log is
    signed and as it was written.

    Examples:
    - `passafe review runs/bad.mcap --html report.html`
    - `passafe review runs/bad.mcap --json`
    - `passafe review runs/ci.mcap --contract contract.toml --require protected-start --junit review.xml`
    - `passafe review runs/bad.mcap --verify --authority keys/authority/ca.pem` names each message that was changed
    """
    require_separate({"--html": html, "--junit": junit}, (*files_of(run), *filter(None, (contract, authority))))
    asked = _asked(require or (), contract)
    if junit is not None:
        _require_file(junit, "--junit")
    verdict = _reported(run, html, asked) if html is not None else under(judged(run).verdict, asked)
    if junit is not None:
        write_junit(junit, verdict, run)
    verification = verify_log(run, authority) if verify or authority is not None else None
    if json:
        shown = verdict if verification is None else VerifiedVerdict.with_verification(verdict, verification)
        typer.echo(shown.model_dump_json(indent=2))
    else:
        print_verdict(verdict, run)
        if verification is not None:
            print_verification(verification)
    is_verified = verification is None or verification.holds
    raise typer.Exit(exit_code(verdict) if is_verified else 1)


def _asked(require: Sequence[str], contract: Path | None) -> LogContract:
    """Return what is asked for besides the scenario's own requirements."""
    asked = LogContract() if contract is None else load_contract(contract)
    for name in require:
        if name not in PROPERTIES:
            raise OptionError("--require", name, ", ".join(PROPERTIES) + suggestion(name, PROPERTIES))
    return asked.model_copy(update={"require": (*asked.require, *require)})


def _require_file(path: Path, option: str) -> None:
    if path.is_dir():
        raise OptionError(option, f"{path}, a folder", "a file")
    writable_folder(path.parent, option)


def _reported(run: Path, html: Path, asked: LogContract) -> Verdict:
    """Write the report of a log and return its verdict, both from one pass over it."""
    from passafe_dashboard.run_report import (  # noqa: PLC0415 - a second that other reviews need not wait
        RunCollector,
        render_report,
        write_report,
    )

    _require_file(html, "--html")
    records: list[RunCollector] = []

    def join(identity: RunIdentity, evaluator: CoreEvaluator) -> Sequence[LogConsumer]:
        records.append(RunCollector(identity.scenario, evaluator))
        return records

    found = judged(run, join)
    verdict = under(found.verdict, asked)
    write_report(html, render_report(records[0], verdict, found.identity))
    return verdict
