"""Functions that return robots: every wrong one is one clear line."""

import sys
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest
from passafe_services.scenarios.errors import RobotCodeError, ScenarioError
from passafe_services.scenarios.load import load_scenario, scenario_from
from passafe_services.scenarios.robots import robot_source
from passafe_services.scenarios.robots.robot_source import installed_robot, is_robot_file, robot_of_file

CODE = """
import casadi as ca
import passafe
from beside import GAIN

x, u = ca.SX.sym("x", 2), ca.SX.sym("u", 1)
y = ca.MX.sym("y", 2)


def cart(*, rows=2, **other):
    system = passafe.System(x=x, u=u, f=ca.vertcat(x[1], u)[:rows], y=x[1])
    return passafe.Robot(system=system, position=x[0], fail_safe=-GAIN * x[1], **other)


def braked():
    from beside_only_when_called import BRAKE
    return cart()


def number():
    return 3


def raises():
    raise KeyError("two\\nlines")


def ends():
    raise SystemExit(0)


def interrupts():
    raise KeyboardInterrupt


def odd():
    raise BaseException("odd")


def mute():
    class Mute(Exception):
        def __str__(self):
            raise ValueError

    raise Mute


def speaks():
    print("hello")
    return cart()


def asks(what):
    return what


def symbols():
    return passafe.System(x=y, u=y, f=y, y=y)


def many():
    z = ca.SX.sym("z", 65)
    return passafe.Robot(system=passafe.System(x=z, u=u, f=z, y=z[0]), position=z, velocity=z, fail_safe=z[0])


constant = 5
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "mine.py").write_text(CODE, encoding="utf-8")
    (tmp_path / "beside.py").write_text("GAIN = 2.0\n", encoding="utf-8")
    (tmp_path / "broken.py").write_text("def f(:\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    robot_source._functions.cache_clear()
    return tmp_path


def test_function_of_a_file_makes_the_robot(folder: Path) -> None:
    made = robot_of_file("mine.py:cart", {})

    assert (made.states, made.inputs, made.made_by) == (2, 1, "mine.py:cart")
    (folder / "mine.py").unlink()
    assert made.robot().system.n == 2


def test_function_imports_a_file_beside_its_own(folder: Path) -> None:
    (folder / "beside_only_when_called.py").write_text("BRAKE = 1.0\n", encoding="utf-8")
    before = list(sys.path)

    assert robot_of_file("mine.py:braked", {}).states == 2
    assert sys.path == before


def test_file_may_hold_a_dataclass_with_deferred_types(folder: Path) -> None:
    head = "from __future__ import annotations\nfrom dataclasses import dataclass\n"
    more = "\n@dataclass\nclass Motor:\n    torque: float = 1.0\n"
    (folder / "mine.py").write_text(head + CODE + more, encoding="utf-8")

    assert robot_of_file("mine.py:cart", {}).states == 2


def test_what_the_code_prints_stays_out_of_the_output(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert folder.is_dir()
    robot_of_file("mine.py:speaks", {})

    assert capsys.readouterr() == ("", "hello\n")


def test_file_is_run_once(folder: Path) -> None:
    with (folder / "mine.py").open("a", encoding="utf-8") as file:
        file.write("with open('runs', 'a') as runs:\n    runs.write('x')\n")
    for _ in range(3):
        robot_of_file("mine.py:cart", {})

    assert (folder / "runs").read_text(encoding="utf-8") == "x"


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("mine.py", "got 'mine.py', allowed FILE.py:FUNCTION"),
        ("mine.txt:cart", "got 'mine.txt:cart', allowed FILE.py:FUNCTION"),
        ("other.py:cart", "got no file other.py, allowed FILE.py:FUNCTION of a file that exists"),
        ("mine.py:cat", "got no function 'cat', allowed one of the file; did you mean cart?"),
        ("mine.py:constant", "got no function 'constant'"),
        ("broken.py:f", "got SyntaxError"),
        ("mine.py:number", "got the return value 3 (int), allowed a passafe.Robot"),
        ("mine.py:raises", "KeyError in line 25: 'two\\\\nlines'"),
        ("mine.py:ends", "got SystemExit in line 29: 0"),
        ("mine.py:interrupts", "got KeyboardInterrupt in line 33, allowed"),
        ("mine.py:odd", "got BaseException in line 37: odd"),
        ("mine.py:mute", "got Mute in line 45: its text raises ValueError"),
        ("mine.py:asks", "missing 1 required positional argument"),
        ("mine.py:symbols", "allowed a casadi.SX expression"),
        ("mine.py:many", "got states 65, allowed at most 64"),
    ],
)
def test_what_makes_no_robot_is_one_line(text: str, words: str) -> None:
    with pytest.raises(RobotCodeError) as refused:
        robot_of_file(text, {})

    assert words.replace("\\\\", "\\") in str(refused.value)
    assert "\n" not in str(refused.value)
    assert str(refused.value).startswith(
        f"robot {text.split(':', maxsplit=1)[0]}" if "broken" not in text else "robot "
    )


@pytest.mark.usefixtures("folder")
def test_wrong_shape_is_the_cores_own_message() -> None:
    with pytest.raises(RobotCodeError, match=r"system f: got shape \(1, 1\), allowed shape \(2, 1\)"):
        robot_of_file("mine.py:cart", {"rows": 1})


def test_tilde_that_no_shell_replaced_is_the_home_folder(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(folder))
    monkeypatch.chdir("/")

    assert robot_of_file("~/mine.py:cart", {}).made_by == "mine.py:cart"
    with pytest.raises(RobotCodeError, match=r"got no file ~nobody-has-this-name/mine\.py"):
        robot_of_file("~nobody-has-this-name/mine.py:cart", {})


@pytest.mark.parametrize(
    ("text", "expected"),
    [("a.py:b", True), ("dir/a.py:b", True), ("a.py", True), ("a:b", True), ("robot-1", False)],
)
def test_file_is_no_name(text: str, expected: bool) -> None:
    assert is_robot_file(text) is expected


@pytest.mark.usefixtures("folder")
def test_entry_point_makes_the_robot(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(Path.cwd()))
    entry = EntryPoint(name="cart", value="mine:cart", group=robot_source.ENTRY_POINTS)
    monkeypatch.setattr(robot_source, "entry_points", lambda group: [entry] if group == entry.group else [])

    made = installed_robot("cart", {})
    assert made is not None
    assert made.states == 2
    assert installed_robot("horse", {}) is None


@pytest.mark.parametrize(("others", "refused"), [(("theirs:cart",), True), (("mine:cart",), False)])
@pytest.mark.usefixtures("folder")
def test_name_of_two_distributions_is_refused(
    monkeypatch: pytest.MonkeyPatch, others: tuple[str, ...], refused: bool
) -> None:
    monkeypatch.syspath_prepend(str(Path.cwd()))
    entries = [EntryPoint("cart", value, robot_source.ENTRY_POINTS) for value in ("mine:cart", *others)]
    monkeypatch.setattr(robot_source, "entry_points", lambda **_: entries)

    if not refused:  # one distribution, found twice
        assert installed_robot("cart", {}) is not None
        return
    with pytest.raises(RobotCodeError, match=r"entry point cart: .* mine:cart and theirs:cart, allowed one of them"):
        installed_robot("cart", {})


def test_data_from_elsewhere_runs_no_code() -> None:
    with pytest.raises(ScenarioError, match="model: got 'unicycle'"):
        scenario_from(load_scenario("unicycle-posts").model_dump(exclude={"plant": {"robot"}}), "a log")


def test_unknown_model_is_refused_with_a_suggestion() -> None:
    with pytest.raises(
        ScenarioError,
        match=r"got 'unicycl', allowed 'damped-point', .*, 'unicycle', .*--robot .*: none.; did you mean unicycle\?",
    ):
        load_scenario("unicycle-posts", {"plant.model": "unicycl"})


def test_unknown_model_lists_installed_robots(monkeypatch: pytest.MonkeyPatch) -> None:
    entry = EntryPoint(name="horse", value="mine:horse", group=robot_source.ENTRY_POINTS)
    monkeypatch.setattr(robot_source, "entry_points", lambda **_: [entry])

    with pytest.raises(ScenarioError, match=r"'horse', or any .*: horse.; did you mean horse\?"):
        load_scenario("unicycle-posts", {"plant.model": "hors", "plant.robot": None})


@pytest.mark.usefixtures("folder")
def test_parameter_that_is_no_number_is_the_only_error() -> None:
    with pytest.raises(
        ScenarioError, match=r"^scenario unicycle-posts: plant.parameters.sigma: got '1', allowed a number$"
    ):
        load_scenario("unicycle-posts", {"plant.parameters": {"sigma": "1"}}, robot="mine.py:cart")
