"""A recorded command series: what is read, and the one line that says where a file is wrong."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from passafe_services.operator.errors import RecordingError
from passafe_services.operator.sources import command_recording as recording
from passafe_services.operator.sources.command_recording import load_recording

HEADER = "time_s,u_h_0,u_h_1\n"


def write(folder: Path, text: str) -> Path:
    path = folder / "series.csv"
    path.write_text(text, encoding="utf-8")
    return path


def failure(path: Path, inputs: int = 2) -> RecordingError:
    with pytest.raises(RecordingError) as caught:
        load_recording(path, inputs)
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)
    return caught.value


def test_recording_is_read_unchanged(tmp_path: Path) -> None:
    path = write(tmp_path, HEADER + "0,1.5,-2\n0.5,3e1,+4\n")
    assert load_recording(path, 2) == ((0.0, 0.5), ((1.5, -2.0), (30.0, 4.0)))


def test_column_order_blanks_and_byte_order_mark_are_accepted(tmp_path: Path) -> None:
    path = write(tmp_path, "\ufeffu_h_1, time_s ,u_h_0\r\n\r\n 2 ,0,1\r\n4,1,3\r\n\r\n")
    assert load_recording(path, 2) == ((0.0, 1.0), ((1.0, 2.0), (3.0, 4.0)))


FINITE = st.floats(-1e6, 1e6)


@settings(deadline=None)  # each example writes a file
@given(rows=st.lists(st.tuples(FINITE, FINITE), min_size=1, max_size=20))
def test_what_is_written_with_all_digits_is_read_back_exactly(
    rows: list[tuple[float, float]], tmp_path_factory: pytest.TempPathFactory
) -> None:
    lines = "".join(f"{index * 0.001!r},{a!r},{b!r}\n" for index, (a, b) in enumerate(rows))
    path = write(tmp_path_factory.mktemp("series"), HEADER + lines)
    assert load_recording(path, 2) == (tuple(index * 0.001 for index in range(len(rows))), tuple(rows))


@pytest.mark.parametrize(
    ("text", "line", "column"),
    [
        ("", 0, "time_s"),
        ("t,u_h_0,u_h_1\n0,0,0\n", 1, "time_s"),
        ("time_s,u_h_0\n0,0\n", 1, "u_h_1"),
        ("time_s,u_h_0,u_h_1,u_h_2\n0,0,0,0\n", 1, "u_h_2"),
        ("time_s,u_h_0,u_h_0,u_h_1\n0,0,0,0\n", 1, "u_h_0"),
        (HEADER, 0, ""),
        (HEADER + "0,0,0\n1,2\n", 3, ""),
        (HEADER + "0,0,0\n1,2,3,4\n", 3, ""),
        (HEADER + "0,0,0\n1,x,0\n", 3, "u_h_0"),
        (HEADER + "0,0,\n", 2, "u_h_1"),
        (HEADER + "0,1_0,0\n", 2, "u_h_0"),
        (HEADER + "0,0,nan\n", 2, "u_h_1"),
        (HEADER + "0,-inf,0\n", 2, "u_h_0"),
        (HEADER + "0,0,1.1e6\n", 2, "u_h_1"),
        (HEADER + "2e6,0,0\n", 2, "time_s"),
        (HEADER + "-0.1,0,0\n", 2, "time_s"),
        (HEADER + "0,0,0\n1,0,0\n\n1,0,0\n", 5, "time_s"),
        (HEADER + "0,0,0\n1e-10,0,0\n", 3, "time_s"),
        (HEADER + '0,"0"x,0\n', 2, ""),
    ],
)
def test_an_error_names_line_and_column(tmp_path: Path, text: str, line: int, column: str) -> None:
    error = failure(write(tmp_path, text))
    assert (error.line, error.column) == (line, column)
    if line:
        assert f":{line}" in str(error)
    assert column in str(error)


def test_recording_for_another_robot_is_refused(tmp_path: Path) -> None:
    error = failure(write(tmp_path, HEADER + "0,0,0\n"), inputs=3)
    assert error.column == "u_h_2"
    assert "3 inputs" in str(error)


def test_files_that_cannot_be_opened_are_named(tmp_path: Path) -> None:
    assert "No such file" in str(failure(tmp_path / "missing.csv"))
    assert "directory" in str(failure(tmp_path))


def test_bytes_that_are_no_text_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "series.csv"
    path.write_bytes(HEADER.encode() + b"0,\xff,0\n")
    assert "UTF-8" in str(failure(path))


def test_a_file_without_end_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recording, "ROWS_MAX", 2)
    rows = HEADER + "0,0,0\n1,0,0\n"
    assert len(load_recording(write(tmp_path, rows), 2).times_s) == 2
    assert failure(write(tmp_path, rows + "2,0,0\n")).line == 4
