"""Input files without an end are refused before they are read, by every reader of files."""

import os
from pathlib import Path

import pytest
from passafe_services.operator.errors import RecordingError
from passafe_services.operator.sources.command_recording import load_recording
from passafe_services.scenarios.bounded_file import MOST_BYTES, require_bounded
from passafe_services.scenarios.errors import LinkTraceError, UnknownScenarioError, UnreadableScenarioError
from passafe_services.scenarios.link_trace import read_trace
from passafe_services.scenarios.load import load_scenario
from passafe_services.tools.experiment.errors import UnknownExperimentError, UnreadableExperimentError
from passafe_services.tools.experiment.load import load_study

ENDLESS = Path("/dev/zero")


@pytest.fixture
def large(tmp_path: Path) -> Path:
    """Return a file with a hole, larger than allowed, that takes no room."""
    path = tmp_path / "large.toml"
    path.touch()
    os.truncate(path, MOST_BYTES + 1)
    return path


def test_size_is_bounded_to_the_byte(large: Path) -> None:
    with pytest.raises(OSError, match=f"{MOST_BYTES + 1} bytes, more than {MOST_BYTES}"):
        require_bounded(large)
    os.truncate(large, MOST_BYTES)
    require_bounded(large)


def test_pipe_is_no_file(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")

    with pytest.raises(OSError, match="not a regular file"):
        require_bounded(tmp_path / "pipe")


def test_endless_device_is_refused_everywhere() -> None:
    with pytest.raises(LinkTraceError, match="not a regular file"):
        read_trace(ENDLESS)
    with pytest.raises(RecordingError, match="not a regular file"):
        load_recording(ENDLESS, 2)
    with pytest.raises(UnknownScenarioError):
        load_scenario(str(ENDLESS))
    with pytest.raises(UnknownExperimentError):
        load_study(str(ENDLESS))


def test_large_file_is_refused_everywhere(large: Path) -> None:
    with pytest.raises(LinkTraceError, match="bytes, more than"):
        read_trace(large)
    with pytest.raises(RecordingError, match="bytes, more than"):
        load_recording(large, 2)
    with pytest.raises(UnreadableScenarioError, match="bytes, more than"):
        load_scenario(str(large))
    with pytest.raises(UnreadableExperimentError, match="bytes, more than"):
        load_study(str(large))


@pytest.mark.parametrize(
    ("content", "said"),
    [(None, "got No such file or directory"), (b"\x1f\x8b\x08", "got bytes that are no text in UTF-8")],
)
def test_why_a_file_cannot_be_read_is_said_in_words(content: bytes | None, said: str, tmp_path: Path) -> None:
    path = tmp_path / "trace.csv"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(LinkTraceError) as refused:
        read_trace(path)

    assert said in str(refused.value)


def test_a_trace_may_begin_with_a_mark_of_byte_order(tmp_path: Path) -> None:
    path = tmp_path / "trace.csv"
    path.write_bytes(b"\xef\xbb\xbfsent_s,delay_s\r\n0,0.01\r\n0.01,0.02\r\n")

    assert len(read_trace(path).delay_trace_s) == 2
