"""The committed page and the generated code are current, and the tables say what the code does."""

import runpy
import sys
from pathlib import Path

import pytest
from google.protobuf.descriptor_pb2 import FileDescriptorProto
from passafe_protocol import passafe_pb2, wire_table
from passafe_protocol.topics import TOPICS
from passafe_protocol.wire_table import BEGIN, END, compiled, main, render, with_generated_part

PAGE = Path(wire_table.__file__).parents[2] / "docs" / "wire-protocol.md"


def row_of(markdown: str, heading: str, first: str) -> list[str]:
    """Cells of the row under ``heading`` whose first or second cell is ``first``."""
    section = markdown.split(f"{heading}\n", 1)[1].split("\n#", 1)[0]
    rows = [[cell.strip() for cell in line.strip("| ").split(" | ")] for line in section.splitlines() if "|" in line]
    return next(row for row in rows if first in row[:2])


def test_generated_code_is_current() -> None:
    from_source, committed = compiled(), FileDescriptorProto()
    passafe_pb2.DESCRIPTOR.CopyToProto(committed)
    from_source.ClearField("source_code_info")
    for message in from_source.message_type:
        for field in message.field:
            field.ClearField("json_name")

    assert committed == from_source, "run make proto"


def test_committed_page_is_current() -> None:
    page = PAGE.read_text(encoding="utf-8")

    assert page == with_generated_part(page, render()), (
        "run python -m passafe_protocol.wire_table --write docs/wire-protocol.md"
    )


def test_every_topic_message_and_field_is_described() -> None:
    markdown = render()

    for topic in TOPICS:
        assert row_of(markdown, "## Topics", topic.name)[2] == f"`{topic.selector('{robot}')}`"
    for message in passafe_pb2.DESCRIPTOR.message_types_by_name.values():
        for field in message.fields:
            assert row_of(markdown, f"### {message.name}", f"`{field.name}`")[0] == str(field.number)


def test_field_row_has_number_type_meaning_and_allowed_values() -> None:
    markdown = render()

    assert row_of(markdown, "### PlantState", "`x`") == [
        "3",
        "`x`",
        "list of double",
        "state at plant_ns",
        "1 to 64 numbers",
    ]
    assert row_of(markdown, "### FilterTick", "`rows`")[2] == "list of [RowReport](#rowreport)"
    assert row_of(markdown, "### PlantState", "`phase`")[2] == "[PlantPhase](#plantphase)"
    assert row_of(markdown, "### PlantPhase", "`RUNNING`")[0] == "2"
    assert row_of(markdown, "### PlantPhase", "`PLANT_PHASE_UNSPECIFIED`")[2].startswith("never sent")


def test_row_of_a_topic_holds_its_rate_and_deadline() -> None:
    markdown = render()

    assert row_of(markdown, "## Topics", "state")[3:6] == ["plant", "`rate_hz` of the scenario", "0.05 s"]
    assert row_of(markdown, "## Topics", "health")[4:7] == ["1 Hz", "3 s", "drop"]
    assert row_of(markdown, "## Topics", "scenario")[4:7] == ["occasional", "never", "block"]


def test_bar_in_a_comment_does_not_break_the_table() -> None:
    assert r"\|zᵀz − λᵀd\|" in render()


def test_only_the_part_between_the_markers_is_replaced() -> None:
    page = f"above\n{BEGIN}\nold\n{END}\nbelow\n"

    assert with_generated_part(page, "new\n") == f"above\n{BEGIN}\n\nnew\n\n{END}\nbelow\n"


@pytest.mark.parametrize("page", ["", BEGIN, END, f"{END}\n{BEGIN}"])
def test_page_without_its_markers_is_refused(page: str) -> None:
    with pytest.raises(ValueError, match="marker lines"):
        with_generated_part(page, "new")


def test_main_prints(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(sys, "argv", ["wire_table"])

    runpy.run_path(wire_table.__file__, run_name="__main__")

    assert capsys.readouterr().out == render()


def test_main_rewrites_the_page(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(f"α\n{BEGIN}\n{END}\n", encoding="utf-8")

    main(["--write", str(page)])

    assert page.read_text(encoding="utf-8") == f"α\n{BEGIN}\n\n{render()}\n{END}\n"


def test_main_checks_the_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = tmp_path / "page.md"
    page.write_text(f"{BEGIN}\n\n{render()}\n{END}\n", encoding="utf-8")
    main(["--check", str(page)])
    page.write_text(f"{BEGIN}\n{END}\n", encoding="utf-8")

    with pytest.raises(SystemExit, match="1"):
        main(["--check", str(page)])

    assert capsys.readouterr().err.startswith(f"{page} is not current")
    assert page.read_text(encoding="utf-8") == f"{BEGIN}\n{END}\n"


@pytest.mark.parametrize("content", [None, "no markers"])
@pytest.mark.parametrize("option", ["--write", "--check"])
def test_main_reports_errors_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], content: str | None, option: str
) -> None:
    page = tmp_path / "page.md"
    if content is not None:
        page.write_text(content, encoding="utf-8")

    with pytest.raises(SystemExit, match="2"):
        main([option, str(page)])

    assert str(page) in capsys.readouterr().err.splitlines()[-1]


def test_source_that_does_not_compile_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(wire_table, "_PROTO", "passafe_protocol/absent.proto")

    with pytest.raises(SystemExit, match=r"absent\.proto"):
        compiled()
