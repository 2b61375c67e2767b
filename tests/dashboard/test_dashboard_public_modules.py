"""Modules that the dashboard's docstring calls public, and those that import-linter protects, are all there are."""

import re
import tomllib
from pathlib import Path
from pkgutil import iter_modules

import passafe_dashboard

PYPROJECT = Path(__file__).parents[2] / "pyproject.toml"


def test_every_module_is_either_public_or_protected() -> None:
    public = set(re.findall(r"\* ``(passafe_dashboard\.\w+)``", passafe_dashboard.__doc__ or ""))
    contracts = tomllib.loads(PYPROJECT.read_text("utf-8"))["tool"]["importlinter"]["contracts"]
    [protected] = [set(one["protected_modules"]) for one in contracts if one["type"] == "protected"]

    assert {
        f"passafe_dashboard.{module.name}" for module in iter_modules(passafe_dashboard.__path__)
    } == public | protected
    assert not public & protected
