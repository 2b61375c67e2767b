"""Identity of the monotonic clock."""

import sys
from pathlib import Path
from subprocess import run

import pytest
from passafe_services.loop.monotonic_clock import clock_id_of, monotonic_clock_id


def clock_of(folder: Path, boot: str, namespace: str) -> int:
    folder.mkdir()
    (folder / "boot").write_text(boot)
    (folder / "time").symlink_to(namespace)
    return clock_id_of(folder / "boot", folder / "time")


def test_hosts_and_time_namespaces_have_clocks_of_their_own(tmp_path: Path) -> None:
    first, again = (clock_of(tmp_path / name, "boot 1", "time:[7]") for name in ("first", "again"))
    other_host = clock_of(tmp_path / "host", "boot 2", "time:[7]")
    other_space = clock_of(tmp_path / "space", "boot 1", "time:[8]")

    assert first == again
    assert len({0, first, other_host, other_space}) == 4


def test_a_host_that_does_not_tell_has_no_known_clock(tmp_path: Path) -> None:
    assert clock_id_of(tmp_path / "boot", tmp_path / "time") == 0


@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not tell")
def test_processes_of_one_host_agree() -> None:
    program = "from passafe_services.loop.monotonic_clock import monotonic_clock_id; print(monotonic_clock_id())"
    found = run([sys.executable, "-c", program], capture_output=True, text=True, check=True)

    assert int(found.stdout) == monotonic_clock_id() != 0
