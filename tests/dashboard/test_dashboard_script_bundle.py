"""Scripts joined into one: order, scopes, and what Node.js makes of them."""

import re
import shutil
import subprocess
from graphlib import CycleError
from pathlib import Path

import pytest
from passafe_dashboard import script_bundle as bundling
from passafe_dashboard.markup import STATIC
from passafe_dashboard.script_bundle import script_bundle

NODE = shutil.which("node")


@pytest.fixture
def static(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(bundling, "STATIC", tmp_path)
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    return tmp_path


def run_script(text: str, path: Path) -> str:
    """Return what Node.js prints on running a script."""
    if NODE is None:
        pytest.skip("Node.js is not installed")
    path.write_text(text, "utf-8")
    done = subprocess.run([NODE, str(path)], capture_output=True, text=True, check=True, timeout=30)
    return done.stdout.strip()


def test_equal_names_of_two_modules_stay_apart(static: Path) -> None:
    (static / "a/one.js").write_text("const N = 1;\nexport function one() {\n  return N;\n}\n")
    (static / "b/two.js").write_text(
        'import { one as first } from "../a/one.js";\nconst N = 2;\nexport const two = () => N + first();\n'
    )
    (static / "a/main.js").write_text(
        'import {\n  one,\n} from "./one.js";\nimport { two } from "../b/two.js";\n'
        "export function sum() {\n  return one() + two();\n}\n"
    )
    joined = script_bundle.__wrapped__("a/main.js")
    assert run_script(f"{joined}console.log(sum());", static / "joined.mjs") == "4"
    assert joined.count("const N = 1;") == 1


def test_modules_that_import_each_other_are_refused(static: Path) -> None:
    (static / "a/one.js").write_text('import { two } from "./two.js";\nexport const one = () => two();\n')
    (static / "a/two.js").write_text('import { one } from "./one.js";\nexport const two = () => one();\n')
    with pytest.raises(CycleError):
        script_bundle.__wrapped__("a/one.js")


@pytest.mark.parametrize("entry", ["live/main.js", "report/report.js"])
def test_scripts_of_the_pages_join_whole(entry: str) -> None:
    joined = script_bundle(entry)
    assert not re.search(r"^(import|export) ", joined, re.MULTILINE)
    folder = STATIC / Path(entry).parent
    for module in folder.glob("*.js"):
        has_code = re.search(
            r"^(?:export )?(?:async )?(?:function|class|const) \w+", module.read_text("utf-8"), re.MULTILINE
        )
        name = f"module_{folder.name}_{module.stem} ="
        assert has_code is None or name in joined, f"{module.name} is not part of {entry}"
