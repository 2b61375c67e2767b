"""The wheel, installed into a fresh environment, beside folders that could shadow what it imports."""

import re
import socket
import tomllib
import zipfile
from pathlib import Path

import pytest
from installation import ROOT, Installation, built_wheel, downloaded_installation, linked_installation

pytestmark = pytest.mark.live

PACKAGES = ("passafe", "protocol/passafe_protocol", "services/passafe_services", "dashboard/passafe_dashboard")
FOLDERS = ("services", "protocol", "dashboard", "multiprocessing", "numpy", *(Path(name).name for name in PACKAGES))
MODULES = ("typing", "pickle", "signal", "casadi", "zenoh")


IMPORT_ALL = """
from importlib import import_module
from pkgutil import walk_packages

for package in {packages}:
    for module in walk_packages(import_module(package).__path__, package + "."):
        if module.name.endswith((".__main__", ".wire_table")):  # wire_table generates docs, with what dev installs
            continue
        try:
            import_module(module.name)
        except ModuleNotFoundError as error:
            if error.name.split(".")[0] not in {optional}:
                raise
"""

OPTIONAL = ("foxglove", "foxglove_schemas_protobuf", "mujoco", "rosbags")
"""Packages of extras that are neither in the base nor in ``service``."""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return built_wheel(tmp_path_factory.mktemp("wheel"))


def installation(request: pytest.FixtureRequest, folder: Path, wheel: Path, extra: str = "") -> Installation:
    interpreter = request.config.getoption("--interpreter")
    if interpreter is None:
        return linked_installation(folder, wheel, extra)
    return downloaded_installation(folder, wheel, interpreter, extra)


@pytest.fixture(scope="module")
def base(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory, wheel: Path) -> Installation:
    return installation(request, tmp_path_factory.mktemp("base"), wheel)


@pytest.fixture(scope="module")
def service(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory, wheel: Path) -> Installation:
    return installation(request, tmp_path_factory.mktemp("service"), wheel, "service")


@pytest.fixture
def shadowing_folder(tmp_path: Path) -> Path:
    """Folder with packages and modules that must never be imported."""
    places = [tmp_path / name / "__init__.py" for name in FOLDERS] + [tmp_path / f"{name}.py" for name in MODULES]
    for place in places:
        place.parent.mkdir(exist_ok=True)
        place.write_text(f"raise SystemExit('{place.name} of the working directory was imported')\n", encoding="utf-8")
    return tmp_path


def free_port() -> str:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return str(server.getsockname()[1])


def test_wheel_holds_every_file_of_the_packages(wheel: Path) -> None:
    sources = set()
    for package in PACKAGES:
        folder = ROOT / package
        files = (path for path in folder.rglob("*") if path.is_file() and "__pycache__" not in path.parts)
        sources |= {path.relative_to(folder.parent).as_posix() for path in files}

    names = {name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name}

    assert names == sources
    assert {f"{Path(package).name}/py.typed" for package in PACKAGES} <= names


def test_base_install_decides_as_the_readme_shows(base: Installation, shadowing_folder: Path) -> None:
    [program] = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), flags=re.DOTALL)

    done = base.run("python", "-P", "-c", program, cwd=shadowing_folder)

    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("MODIFIED")


def test_base_install_prints_what_to_install_for_commands(base: Installation, shadowing_folder: Path) -> None:
    done = base.run("passafe", "demo", cwd=shadowing_folder)

    assert done.returncode == 2
    assert "pip install 'passafe[service]'" in done.stderr
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize("extra", ["base", "service"])
def test_version_is_that_of_the_project(extra: str, request: pytest.FixtureRequest, tmp_path: Path) -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]

    done = request.getfixturevalue(extra).run("passafe", "--version", cwd=tmp_path)

    assert done.stdout == f"passafe {project['version']}\n"


@pytest.mark.parametrize(
    ("extra", "packages"), [("base", ["passafe"]), ("service", [Path(name).name for name in PACKAGES])]
)
def test_requirements_cover_every_import(
    extra: str, packages: list[str], request: pytest.FixtureRequest, shadowing_folder: Path
) -> None:
    installed: Installation = request.getfixturevalue(extra)

    done = installed.run(
        "python", "-P", "-c", IMPORT_ALL.format(packages=packages, optional=OPTIONAL), cwd=shadowing_folder
    )

    assert done.returncode == 0, done.stderr


def test_demo_runs_beside_shadowing_folders(service: Installation, shadowing_folder: Path) -> None:
    options = ("--headless", "--keep-awake", "--duration", "1", "--rate", "200", "--router-port", free_port())

    done = service.run("passafe", "demo", *options, "--out", "runs", cwd=shadowing_folder)

    assert done.returncode == 0, done.stdout + done.stderr
    assert "verdict   holds" in done.stdout
    assert "was imported" not in done.stdout + done.stderr


def test_workers_run_beside_shadowing_folders(service: Installation, shadowing_folder: Path) -> None:
    campaign = ("campaign", "notomista-cai-2020", "--rollouts", "2", "--duration", "0.05", "--workers", "2")
    sweep = ("experiment", "random-network", "--seeds", "1", "--workers", "2", "--keep-most", "1")

    for command in (campaign, sweep):
        done = service.run("passafe", *command, "--out", f"runs/{command[0]}", cwd=shadowing_folder)

        assert done.returncode == 0, done.stdout + done.stderr
        assert "was imported" not in done.stdout + done.stderr


def test_installed_review_writes_its_page(service: Installation, shadowing_folder: Path) -> None:
    simulated = service.run("passafe", "simulate", "--duration", "0.2", "--out", "run.mcap", cwd=shadowing_folder)
    reviewed = service.run("passafe", "review", "run.mcap", "--html", "report.html", cwd=shadowing_folder)

    assert (simulated.returncode, reviewed.returncode) == (0, 0), simulated.stderr + reviewed.stderr
    assert "<html" in (shadowing_folder / "report.html").read_text(encoding="utf-8")
