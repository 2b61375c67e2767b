import ast
from importlib import import_module
from pathlib import Path

import casadi as ca
import pytest

import passafe


def test_public_names_exist_and_are_listed_once() -> None:
    assert all(hasattr(passafe, name) for name in passafe.__all__)
    assert sorted(set(passafe.__all__)) == passafe.__all__


def test_names_imported_on_first_use_are_those_of_checkers() -> None:
    tree = ast.parse(Path(passafe.__file__).read_text(encoding="utf-8"))
    imported = {
        str(alias.asname): node.module
        for block in tree.body
        if isinstance(block, ast.If)
        for node in block.body
        if isinstance(node, ast.ImportFrom) and node.module is not None
        for alias in node.names
    }

    assert sorted(imported) == passafe.__all__
    for name, module in imported.items():
        assert getattr(passafe, name) is getattr(import_module(module), name)


def test_dir_lists_the_public_names() -> None:
    assert dir(passafe) == passafe.__all__


def test_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="'passafe' has no attribute 'damped_pint'"):
        _ = passafe.damped_pint


def test_example_of_the_package_docstring_decides() -> None:
    robot = passafe.damped_point(sigma=1.0, gamma_1=10.0)
    gains = (passafe.Linear(gain=10.0), passafe.Linear(gain=10.0), passafe.Cubic(gain=100.0))
    disk = passafe.disk_keep_out(robot.position, centre=(0, 0), radius=1.0)
    design = passafe.FilterDesign(
        system=robot.system,
        u_fb=robot.proportional_derivative(k_p=10.0, k_d=5.0),
        fail_safe=robot.fail_safe,
        barriers=(passafe.Barrier(name="disk", h=disk, class_k=gains),),
        passivity=passafe.Passivity(V=ca.sumsqr(robot.system.x)),
        k_i=100.0,
        dt_s=1e-3,
        input_bound=100.0,
    )
    decision = passafe.SafetyPassivityFilter(design).decide((2, 2, -1, -1), (0, 0), (0, 0), (0, 0))

    assert decision.status in {passafe.Status.PASSED, passafe.Status.MODIFIED}
    assert len(decision.u) == 2
