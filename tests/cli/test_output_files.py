"""No command writes over a file that it reads, nor two of its files into one."""

import os
import shutil
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path

import pytest
from passafe_services.cli.app import app
from passafe_services.cli.errors import OptionError
from passafe_services.cli.output_files import require_separate
from passafe_services.scenarios.load import load_scenario
from passafe_services.tools.export.whole_file import whole_output
from short_run import write_log
from typer.testing import CliRunner

Refused = Callable[..., str]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_log(tmp_path_factory.mktemp("log") / "l.mcap", load_scenario("notomista-cai-2020"))


@pytest.fixture
def refused(recorded: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Refused:
    """Return a function that runs a command beside ``l.mcap`` and ``s.toml``, and returns what it says."""
    monkeypatch.chdir(tmp_path)
    log, scenario = Path(shutil.copy(recorded, "l.mcap")), Path("s.toml")
    scenario.write_text("schema_version = 1", encoding="utf-8")
    before = log.read_bytes(), scenario.read_bytes()

    def run(*command: str) -> str:
        result = CliRunner().invoke(app, list(command))
        assert isinstance(result.exception, OptionError)
        assert (log.read_bytes(), scenario.read_bytes()) == before
        return str(result.exception)

    return run


@pytest.mark.parametrize(
    "command",
    [
        "review l.mcap --html ./l.mcap",
        "review l.mcap --junit l.mcap --json",
        "compare l.mcap l.mcap --svg l.mcap",
        "compare l.mcap l.mcap --html l.mcap",
        "whatif l.mcap --set filter.k_i=5 --out l.mcap",
        "whatif l.mcap --set filter.k_i=5 --out w.mcap --html l.mcap",
        "export l.mcap --foxglove l.mcap",
        "identify l.mcap --out l.mcap",
        "link import l.mcap --out l.mcap",
    ],
)
def test_a_log_is_not_written_over(refused: Refused, command: str) -> None:
    assert "allowed another file than l.mcap, which is read" in refused(*command.split())


def test_two_outputs_need_two_files(refused: Refused) -> None:
    assert refused("review", "l.mcap", "--html", "z", "--junit", "./z").startswith("--junit: got z, allowed another")
    assert "that of --out" in refused("whatif", "l.mcap", "--out", "w.mcap", "--html", "w.mcap")


def test_a_link_to_a_file_is_that_file(tmp_path: Path) -> None:
    (tmp_path / "a").touch()
    (tmp_path / "b").symlink_to(tmp_path / "a")
    (tmp_path / "c").hardlink_to(tmp_path / "a")
    for name in ("b", "c"):
        with pytest.raises(OptionError, match="which is read"):
            require_separate({"--out": tmp_path / name}, [tmp_path / "a"])
    require_separate({"--out": tmp_path / "d", "--html": None, "--svg": tmp_path / "e"}, [tmp_path / "a"])


def test_a_link_that_is_written_to_stays(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("before")
    (tmp_path / "b").symlink_to("a")
    with whole_output(tmp_path / "b") as unfinished:
        unfinished.write_text("after")

    assert (tmp_path / "b").is_symlink()
    assert (tmp_path / "a").read_text() == "after"


@pytest.mark.parametrize(
    ("place", "kind"), [("/dev/null", "device or pipe"), ("pipe", "device or pipe"), (".", "folder")]
)
@pytest.mark.parametrize(
    "command",
    [
        "review l.mcap --html",
        "review l.mcap --junit",
        "compare l.mcap l.mcap --svg",
        "whatif l.mcap --set filter.k_i=5 --out",
        "export l.mcap --foxglove",
        "identify l.mcap --out",
        "link import l.mcap --out",
        "simulate --out",
    ],
)
def test_what_is_no_file_keeps_its_place(refused: Refused, command: str, place: str, kind: str) -> None:
    os.mkfifo("pipe")

    assert f"got {place}, a {kind}, allowed a file" in refused(*command.split(), place)


def test_a_scenario_is_not_written_over(tmp_path: Path) -> None:
    shipped = files("passafe_services.scenarios").joinpath("wrong-mass.toml").read_text(encoding="utf-8")
    scenario = tmp_path / "t.toml"
    scenario.write_text(shipped, encoding="utf-8")
    result = CliRunner().invoke(app, ["simulate", "--scenario", str(scenario), "--out", str(scenario)])

    assert isinstance(result.exception, OptionError)
    assert scenario.read_text(encoding="utf-8") == shipped
