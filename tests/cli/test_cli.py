"""The command line as a user types it, in processes of its own."""

import json
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple, cast

import click
import pytest
import typer
from passafe_services.cli.app import app, main
from typer.testing import CliRunner

TIMEOUT_S = 120


def passafe(*arguments: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-P", "-m", "passafe_services.cli", *arguments],
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
        check=False,
        cwd=cwd,
    )


@pytest.fixture(scope="module")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    log = tmp_path_factory.mktemp("runs") / "run.mcap"
    done = passafe("simulate", "--duration", "0.5", "--out", str(log))
    assert done.returncode == 0, done.stderr
    return log


class Here(NamedTuple):
    """Exit code of a command in this process, and what it printed to stderr."""

    returncode: int
    stderr: str


@pytest.fixture
def here(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[[tuple[str, ...]], Here]:
    """Run a command in this process, in an empty folder: it is over before it would start anything."""

    def run(arguments: tuple[str, ...]) -> Here:
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(sys, "argv", ["passafe", *arguments])
        with pytest.raises(SystemExit) as ended:
            main()
        return Here(int(ended.value.code or 0), capsys.readouterr().err)

    return run


def commands(group: click.Group, before: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """Yield the words of every command and of every group of commands."""
    yield before
    for name, command in group.commands.items():
        if isinstance(command, click.Group):
            yield from commands(command, (*before, name))
        else:
            yield (*before, name)


@pytest.mark.parametrize("words", list(commands(cast("click.Group", typer.main.get_command(app)))), ids=" ".join)
def test_every_command_has_help(words: tuple[str, ...]) -> None:
    result = CliRunner().invoke(app, [*words, "--help"])

    assert result.exit_code == 0
    assert "Usage" in result.output


def test_the_program_has_help() -> None:
    done = passafe("--help")

    assert done.returncode == 0
    assert "Usage" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (("simulate", "--scenario", "nonsense", "--out", "x.mcap"), "notomista-cai-2020"),
        (("simulate", "--rate", "-5", "--out", "x.mcap"), "rate_hz"),
        (("simulate", "--mode", "maybe", "--out", "x.mcap"), "filter.mode"),
        (("simulate", "--link", "nonsense", "--out", "x.mcap"), "--link"),
        (("simulate", "--link", "nowhere:delay=1", "--out", "x.mcap"), "nowhere"),
        (("simulate", "--link", "plant-to-filter:delay=soon", "--out", "x.mcap"), "delay_s"),
        (("simulate", "--out", "/proc/no/run.mcap"), "/proc/no"),
        (("demo", "--out", "/proc/no", "--headless"), "/proc/no"),
        (("campaign", "nonsense", "--out", "x"), "notomista-cai-2020"),
        (("campaign", "notomista-cai-2020", "--out", "/proc/no"), "/proc/no"),
        (("review", "missing.mcap"), "missing.mcap"),
        (("replay", "missing.mcap"), "missing.mcap"),
        (("recover", "missing.mcap", "--out", "whole.mcap"), "missing.mcap"),
        (("run", "plant", "--router", "nowhere"), "--router"),
        (("kill", "filter", "--router", "127.0.0.1:1"), "127.0.0.1:1"),
        (("link", "set", "plant-to-moon", "delay=1"), "plant-to-moon"),
        (("link", "set", "plant-to-filter", "loss=2"), "loss"),
        (("link", "set", "plant-to-filter", "trace=x.csv"), "trace"),
        (("link", "show", "plant-to-moon"), "plant-to-moon"),
    ],
)
def test_unusable_input_is_refused_in_one_line(
    here: Callable[[tuple[str, ...]], Here], arguments: tuple[str, ...], named: str, tmp_path: Path
) -> None:
    done = here(arguments)

    assert done.returncode != 0
    assert named in done.stderr
    assert done.stderr.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "meant"),
    [
        (("revew",), "'review'"),
        (("link", "shw"), "'show'"),
        (("demo", "--durration", "3"), "--duration"),
        (("simulate", "--scenario", "notomista-cai-2002", "--out", "x.mcap"), "notomista-cai-2020?"),
        (("simulate", "--link", "plant-to-filter:dely=1", "--out", "x.mcap"), "delay?"),
        (("simulate", "--link", "plant-to-filtr:delay=1", "--out", "x.mcap"), "plant-to-filter?"),
        (("simulate", "--mode", "saef", "--out", "x.mcap"), "safe?"),
        (("experiment", "dela", "--out", "x"), "delay?"),
        (("link", "set", "plant-filter", "delay=1"), "plant-to-filter?"),
        (("link", "set", "plant-to-filter", "dely=1"), "delay?"),
    ],
)
def test_misspelt_name_is_answered_with_the_one_meant(
    here: Callable[[tuple[str, ...]], Here], arguments: tuple[str, ...], meant: str, tmp_path: Path
) -> None:
    done = here(arguments)

    assert done.returncode == 2
    assert meant in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_class_k_chain_of_wrong_length_is_refused(tmp_path: Path) -> None:
    shipped = passafe("scenarios")
    assert "notomista-cai-2020" in shipped.stdout
    from passafe_services.scenarios.load import load_scenario  # noqa: PLC0415 - only this test needs it

    data = json.loads(load_scenario("notomista-cai-2020").model_dump_json())
    data["filter"]["barriers"][0]["class_k"] = data["filter"]["barriers"][0]["class_k"][:1]
    path = tmp_path / "short.json"
    path.write_text(json.dumps(data), encoding="utf-8")

    done = passafe("simulate", "--scenario", str(path), "--out", str(tmp_path / "x.mcap"))

    assert done.returncode != 0
    assert "barrier 'disk' class_k: got 1 functions, allowed 3" in done.stderr


def test_taken_port_is_refused_before_any_process_starts(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        done = passafe("demo", "--headless", "--router-port", str(port), "--out", str(tmp_path))
        page = passafe("demo", "--port", str(port), "--router-port", "17447", "--out", str(tmp_path))

    for refused in (done, page):
        assert refused.returncode != 0
        assert str(port) in refused.stderr
        assert refused.stderr.count("\n") == 1


def test_review_prints_json_and_writes_a_report(simulated: Path, tmp_path: Path) -> None:
    report = tmp_path / "report.html"
    done = passafe("review", str(simulated), "--json", "--html", str(report))

    verdict = json.loads(done.stdout)
    assert done.returncode == 0
    assert verdict["verdict"] == "holds"
    assert verdict["duration_s"] == pytest.approx(0.5)
    assert verdict["solve_us_p50"] is None
    assert "<html" in report.read_text(encoding="utf-8")


def test_review_of_a_failing_run_exits_with_1(tmp_path: Path) -> None:
    log = tmp_path / "run.mcap"
    done = passafe("simulate", "--law", "continuous", "--mode", "passive", "--duration", "3", "--out", str(log))

    assert done.returncode == 1
    assert "fails" in done.stdout
    assert passafe("review", str(log)).returncode == 1


def test_run_with_a_simulated_person_reports_steering(tmp_path: Path) -> None:
    log = tmp_path / "steered.mcap"
    done = passafe("simulate", "--scenario", "human-steers", "--duration", "4", "--rate", "200", "--out", str(log))
    again = passafe("review", str(log), "--json")

    assert done.returncode == 0, done.stderr
    assert "reached after" in done.stdout
    assert "held back" in done.stdout
    assert json.loads(again.stdout)["steering"]["reached"] == 1


def test_replay_of_a_simulated_run_is_exact(simulated: Path) -> None:
    done = passafe("replay", str(simulated))

    assert done.returncode == 0
    assert "506 of 506 ticks identical" in done.stdout


def test_recover_writes_a_whole_log_from_a_torn_one(simulated: Path, tmp_path: Path) -> None:
    torn, whole = tmp_path / "torn.mcap", tmp_path / "whole.mcap"
    torn.write_bytes(simulated.read_bytes()[:-5000])

    done = passafe("recover", str(torn), "--out", str(whole))

    assert done.returncode == 0, done.stderr
    assert "kept" in done.stdout
    assert passafe("review", str(whole), "--json").stdout.startswith("{")


def test_campaign_resumes_and_reports_its_worst(tmp_path: Path) -> None:
    short = ("campaign", "notomista-cai-2020", "--duration", "0.2", "--workers", "1", "--out", str(tmp_path))
    first = passafe(*short, "--rollouts", "3")
    again = passafe(*short, "--rollouts", "5")

    assert first.returncode == again.returncode == 0, first.stderr + again.stderr
    assert "lowest h" in again.stdout
    assert len((tmp_path / "notomista-cai-2020.jsonl").read_text().splitlines()) == 1 + 5
    summary = json.loads((tmp_path / "notomista-cai-2020.summary.json").read_text())
    assert summary["rollouts"] == 5
    assert summary["worst"]["h_min"]["value"] > 0


def test_experiment_without_its_packages_prints_what_to_install() -> None:
    program = (
        "import sys; sys.modules['pyarrow'] = None; sys.argv = ['passafe', 'experiment', 'delay', '--out', 'x'];"
        "from passafe_services.cli.__main__ import main; main()"
    )

    done = subprocess.run([sys.executable, "-P", "-c", program], capture_output=True, text=True, check=False)

    assert done.returncode == 2
    assert done.stderr == "passafe: no module 'pyarrow': install the commands: pip install 'passafe[service]'\n"
