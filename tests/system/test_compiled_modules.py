"""The list of modules that the wheel compiles is that of a period of the loop."""

import ast
import sys
import tomllib
from collections import Counter
from pathlib import Path
from types import FrameType

from passafe_services.scenarios.load import load_scenario
from passafe_services.simulation import lockstep_loop

ROOT = Path(__file__).parents[2]
PACKAGES = [ROOT / "passafe", ROOT / "protocol" / "passafe_protocol", ROOT / "services" / "passafe_services"]
PERIODS = 200
BAD_LINK = {"delay_s": 0.1, "jitter_s": 0.02, "loss": 0.1}


def listed_modules() -> set[str]:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    hooks = project["tool"]["hatch"]["build"]["targets"]["wheel"]["hooks"]
    return set(hooks["custom"]["modules"])


def source_of(module: str) -> Path:
    [path] = [package.parent / module for package in PACKAGES if (package.parent / module).exists()]
    return path


def has_class_options(module: str) -> bool:
    classes = [node for node in ast.parse(source_of(module).read_text()).body if isinstance(node, ast.ClassDef)]
    return any(node.keywords for node in classes)


def modules_called_in_most_periods() -> set[str]:
    bad = {f"links.{link}": BAD_LINK for link in ("plant-to-filter", "filter-to-plant")}
    loop = lockstep_loop(load_scenario("notomista-cai-2020", bad))
    loop.run(PERIODS)
    calls: Counter[str] = Counter()

    def count(frame: FrameType, event: str, _: object) -> None:
        if event == "call":
            calls[frame.f_code.co_filename] += 1

    before = sys.getprofile()
    sys.setprofile(count)
    loop.run(PERIODS)
    sys.setprofile(before)
    often = [Path(file) for file, number in calls.items() if number > PERIODS / 2]
    return {
        str(path.relative_to(package.parent)) for path in often for package in PACKAGES if path.is_relative_to(package)
    }


def test_modules_of_a_period_are_compiled() -> None:
    called = modules_called_in_most_periods()

    assert {module for module in called if not has_class_options(module)} <= listed_modules()


def test_modules_with_class_options_are_not_compiled() -> None:
    assert not [module for module in listed_modules() if has_class_options(module)]
