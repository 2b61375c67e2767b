"""No shape, robot or storage function is shipped without its suite."""

import sys
from collections.abc import Callable, Iterator
from importlib import import_module
from inspect import getmembers, isfunction, signature
from pkgutil import iter_modules
from types import FrameType, ModuleType

import casadi as ca
import pytest
import test_boundary_barriers
import test_boundary_plants
from boundary_suite import BarrierSuite
from plant_suite import PlantSuite, StorageSuite
from shipped_robots import ROBOTS

import passafe.barriers
import passafe.models
import passafe.storage
from passafe.models.robot import Robot

SHAPES = (ca.SX, tuple[ca.SX, ...])

OTHERWISE_TESTED = {"passafe.models.seven_joint_arm.seven_joint_arm", "passafe.models.unicycle.unicycle"}
"""The arm moves as a joint chain does to the last digit, which is a test beside its port's: ``test_rigid_links``; the
state of a car does not begin with the position that barriers are of: ``test_unicycle``."""


def public_functions(module: ModuleType, results: tuple[object, ...]) -> Iterator[str]:
    """Names of a module's own public functions that return one of these types."""
    for name, function in getmembers(module, isfunction):
        own = function.__module__ == module.__name__ and not name.startswith("_")
        if own and signature(function).return_annotation in results:
            yield f"{module.__name__}.{name}"


def modules_of(package: ModuleType) -> Iterator[ModuleType]:
    for info in iter_modules(package.__path__):
        yield import_module(f"{package.__name__}.{info.name}")


def suites(base: type, module: ModuleType) -> list[type]:
    """Return the suite's subclasses that a test module makes pytest collect."""
    return [one for name, one in vars(module).items() if name.startswith("Test") and issubclass(one, base)]


def called_by(work: Callable[[], object]) -> set[str]:
    """Qualified names of all functions that are called while something is done."""
    seen: set[str] = set()

    def note(frame: FrameType, event: str, _: object) -> None:
        if event == "call":
            seen.add(f"{frame.f_globals.get('__name__')}.{frame.f_code.co_name}")

    before = sys.getprofile()
    sys.setprofile(note)
    try:
        work()
    finally:
        sys.setprofile(before)
    return seen


def test_every_shape_and_every_motion_is_in_the_suite() -> None:
    shipped = {name for module in modules_of(passafe.barriers) for name in public_functions(module, SHAPES)}
    seen: set[str] = set()
    for suite in suites(BarrierSuite, test_boundary_barriers):
        for robot in suite.robots:
            seen |= called_by(lambda suite=suite, robot=robot: suite().h(ROBOTS[robot].build(1.0, 1.0)))

    assert len(shipped) >= 11
    assert shipped - seen == set()
    assert {name.rpartition(".")[2] for name in shipped} == set(passafe.barriers.__all__)


def test_every_robot_is_in_the_suite() -> None:
    shipped = {name for module in modules_of(passafe.models) for name in public_functions(module, (Robot,))}
    seen: set[str] = set()
    for suite in suites(PlantSuite, test_boundary_plants):
        seen |= called_by(lambda suite=suite: ROBOTS[suite.name].build(1.0, 1.0))

    assert len(shipped) >= 6
    assert shipped - seen == OTHERWISE_TESTED
    assert {suite.name for suite in suites(PlantSuite, test_boundary_plants)} == set(ROBOTS)


def test_every_robot_is_among_those_of_some_shape() -> None:
    assert {name for suite in suites(BarrierSuite, test_boundary_barriers) for name in suite.robots} == set(ROBOTS)


def test_every_storage_function_is_in_the_suite() -> None:
    shipped = set(public_functions(passafe.storage, SHAPES))
    robot = ROBOTS["damped point"].build(1.0, 1.0)
    seen: set[str] = set()
    for suite in suites(StorageSuite, test_boundary_plants):
        seen |= called_by(lambda suite=suite: suite().storage(robot))

    assert len(shipped) >= 3
    assert shipped - seen == set()


@pytest.mark.parametrize("base", [BarrierSuite, PlantSuite, StorageSuite])
def test_a_suite_is_one_of_tests(base: type) -> None:
    assert sum(name.startswith("test_") for name in vars(base)) >= 2
