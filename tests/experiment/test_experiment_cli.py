"""``passafe experiment`` as a process: what it writes, how it ends, and that it resumes."""

import json
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from passafe_services.tools.experiment.load import shipped_experiments
from pyarrow import parquet

EXAMPLES = Path(__file__).parents[2] / "services" / "passafe_services" / "tools" / "experiment" / "examples"
SMALL = """
schema_version = 2
name = "small"
title = "Small & <plain>"
scenario = "notomista-cai-2020"
seeds = { count = 2 }
[overrides]
duration_s = 0.2
[variants]
off = { "filter.mode" = "off", "plant.x0" = [1.1, 0.0, -2.0, 0.0] }
both = {}
[[axes]]
key = "links.plant-to-filter.delay_s"
values = [0.0, 0.02]
"""


def experiment(*arguments: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-P", "-m", "passafe_services.cli", "experiment", *arguments],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
        cwd=cwd,
    )


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("small")
    (folder / "small.toml").write_text(SMALL, encoding="utf-8")
    done = experiment(str(folder / "small.toml"), "--out", str(folder / "out"), "--keep-most", "2", "--workers", "1")
    assert done.returncode == 0, done.stderr
    assert "2 of 2" in done.stdout
    return folder


@pytest.mark.live
def test_tables_page_and_logs_are_written(small: Path) -> None:
    out = small / "out"

    assert parquet.read_table(out / "runs.parquet").num_rows == 8
    assert parquet.read_table(out / "cells.parquet").num_rows == 4
    assert json.loads((out / "summary.json").read_text(encoding="utf-8"))["runs"] == 8
    logs = sorted((out / "logs").glob("*.mcap"))
    assert len(logs) == 2
    reviewed = subprocess.run(
        [sys.executable, "-P", "-m", "passafe_services.cli", "review", str(logs[0]), "--json"],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert json.loads(reviewed.stdout)["mode"] == "off"


@pytest.mark.live
def test_the_page_stands_alone_and_shows_what_is_typed_as_text(small: Path) -> None:
    page = (small / "out" / "report.html").read_text(encoding="utf-8")

    assert "<h1>Small &amp; &lt;plain&gt;</h1>" in page
    assert "<script" not in page
    sources = re.findall(r'(?:src|href)="([^"]*)"', page)
    assert all(source.startswith("data:") or (small / "out" / source).exists() for source in sources)
    assert sum(source.startswith("data:image/svg+xml") for source in sources) == 2


@pytest.mark.live
def test_the_same_command_runs_nothing_again(small: Path) -> None:
    before = (small / "out" / "results.jsonl").read_text(encoding="utf-8")

    done = experiment(str(small / "small.toml"), "--out", str(small / "out"), "--keep", "none")

    assert done.returncode == 0
    assert (small / "out" / "results.jsonl").read_text(encoding="utf-8") == before


@pytest.mark.live
def test_finished_experiment_says_so_and_does_nothing_twice(small: Path, tmp_path: Path) -> None:
    out = shutil.copytree(small / "out", tmp_path / "out")
    command = str(small / "small.toml"), "--out", str(out), "--keep-most", "2"
    experiment(*command)  # another test may have kept no logs
    files = (out / "report.html", out / "kept.jsonl", *(out / "logs").iterdir())
    before = {path: path.stat().st_mtime_ns for path in files}

    done = experiment(*command)

    assert done.returncode == 0, done.stderr
    assert f"finished before: all 8 runs of small are in {out}" in done.stdout
    assert "2 of 2" in done.stdout
    assert "logs      2 in" in done.stdout
    assert {path: path.stat().st_mtime_ns for path in before} == before
    more = experiment(*command[:-1], "3")
    assert "finished before" not in more.stdout
    assert {path.name for path in files if path.stat().st_mtime_ns != before[path]} == {"report.html", "kept.jsonl"}


@pytest.mark.live
@pytest.mark.parametrize("workers", ["1", "2"])
def test_ctrl_c_loses_nothing_and_the_command_resumes(workers: str, tmp_path: Path) -> None:
    file, out = tmp_path / "small.toml", tmp_path / "out"
    file.write_text(SMALL, encoding="utf-8")
    command = str(file), "--out", str(out), "--seeds", "40", "--workers", workers, "--keep", "none"
    running = subprocess.Popen(
        [sys.executable, "-P", "-m", "passafe_services.cli", "experiment", *command],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        lines = wait_for_lines(out / "results.jsonl", 4, running)
        running.send_signal(signal.SIGINT)
        stdout, stderr = running.communicate(timeout=60)
    finally:
        running.kill()
        running.wait()

    assert running.returncode == 130, stderr
    assert "Traceback" not in stderr
    assert "the same command resumes" in stdout
    kept = (out / "results.jsonl").read_text(encoding="utf-8").splitlines()
    assert len(kept) >= lines
    assert len(kept) < 1 + 160
    done = experiment(*command)
    whole = (out / "results.jsonl").read_text(encoding="utf-8").splitlines()
    assert done.returncode == 0, done.stderr
    assert len(whole) == 1 + 160
    assert whole[: len(kept)] == kept


def wait_for_lines(path: Path, lines: int, running: "subprocess.Popen[str]") -> int:
    """Wait until the running command has written so many lines; return how many there are."""
    deadline_s = time.monotonic() + 120
    while time.monotonic() < deadline_s:
        assert running.poll() is None, running.stderr and running.stderr.read()
        found = path.read_text(encoding="utf-8").count("\n") if path.exists() else 0
        if found >= lines:
            return found
        time.sleep(0.02)
    raise AssertionError("nothing was written")


@pytest.mark.live
@pytest.mark.parametrize("name", shipped_experiments())
def test_a_slice_of_every_shipped_experiment_runs(name: str, tmp_path: Path) -> None:
    text = (EXAMPLES / f"{name}.toml").read_text(encoding="utf-8")
    file = tmp_path / "slice.toml"
    text = re.sub(r"^duration_s = .*$", "duration_s = 0.1", text, flags=re.MULTILINE)
    text = re.sub(r"^values = \[(\S+), (\S+), .*\]$", r"values = [\1, \2]", text, flags=re.MULTILINE)
    file.write_text(text.replace("scan = 4", "scan = 0"), encoding="utf-8")

    done = experiment(str(file), "--seeds", "1", "--workers", "1", "--keep", "none", "--out", str(tmp_path / "out"))

    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / "report.html").exists()
    assert (tmp_path / "out" / "boundaries.svg").exists() == ('kind = "bisect"' in text)


@pytest.mark.live
def test_runs_that_cannot_be_run_are_reported_with_exit_code_1(tmp_path: Path) -> None:
    unsafe = '[-0.1, -0.1, 0.0, 0.0]\n"plant.start_high" = [0.1, 0.1, 0.0, 0.0]'
    text = SMALL.replace("duration_s = 0.2", f'duration_s = 0.2\n"plant.start_low" = {unsafe}')
    (tmp_path / "small.toml").write_text(text.replace("seeds =", 'start = "random"\nseeds ='), encoding="utf-8")

    done = experiment("small.toml", "--out", "out", "--seeds", "1", "--workers", "1", cwd=tmp_path)

    assert done.returncode == 1
    assert "4 runs could not be run" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("nonsense",), "allowed a TOML file or one of bad-network"),
        (("delay", "--out", "/proc/no"), "/proc/no"),
        (("bad-network", "--seeds", "1000000000"), "--seeds: got 2000000000 runs, allowed up to 1000000"),
        (("delay", "--scheduler", "nowhere"), "--scheduler nowhere"),
        (("delay", "--scheduler", "tcp://127.0.0.1:1"), "refused"),
    ],
)
def test_nonsense_gets_one_clear_line(arguments: tuple[str, ...], expected: str, tmp_path: Path) -> None:
    out = () if "--out" in arguments else ("--out", "out")

    done = experiment(*arguments, *out, cwd=tmp_path)

    assert done.returncode == 2
    assert expected in done.stderr
    assert done.stderr.count("\n") == 1


def test_help_teaches() -> None:
    done = experiment("--help")

    assert done.returncode == 0
    assert "Example" in done.stdout
    assert "--scheduler" in done.stdout
