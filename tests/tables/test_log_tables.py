import sys
from pathlib import Path

import pytest
from small_log import small_log

import passafe.log
from passafe.errors import MissingPackageError


def test_reads_a_log_into_tables(tmp_path: Path) -> None:
    run = passafe.log.read(str(small_log(tmp_path / "run.mcap")), topics=("state",))

    assert run.states["x_1"].tolist() == [0.0, 1.0, 2.0, 3.0]


def test_names_the_extra_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [one for one in sys.modules if one.startswith("passafe_services.tables")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "google.protobuf.descriptor", None)

    with pytest.raises(MissingPackageError, match=r"pip install 'passafe\[run\]'"):
        passafe.log.read("run.mcap")


def test_a_missing_module_of_ours_is_a_defect() -> None:
    defect = ModuleNotFoundError("no", name="passafe_services.tables.run_tables")

    with pytest.raises(ModuleNotFoundError, match="no"):
        MissingPackageError.of(defect, "run")


def test_missing_package_names_package_and_extra() -> None:
    error = MissingPackageError.of(ModuleNotFoundError("no", name="mcap.records"), "run")

    assert (error.package, error.extra) == ("mcap", "run")
    assert "pip install 'passafe[run]'" in str(error)
