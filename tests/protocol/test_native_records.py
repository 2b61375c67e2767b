"""Records as the compiled wheel has them are made, compared, hashed and printed as msgspec's are."""

import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import get_type_hints

import pytest
from any_message import MESSAGES
from hypothesis import given, settings
from hypothesis import strategies as st
from passafe_protocol import messages
from passafe_protocol.messages import Message
from passafe_protocol.shapes import shape_of

ROOT = Path(__file__).parents[2]

SOURCE = '''"""A module."""

from typing import ClassVar

from msgspec import Struct

SHARED = [1]  # type: ignore[assignment]  # a comment that mypy needs


class Point(Struct, frozen=True, kw_only=True, gc=False):
    """A point."""

    x: float
    y: float = 2.0
    kind: ClassVar[str] = "point"

    @property
    def sum(self) -> float:
        return self.x + self.y


class Held(Struct, frozen=True, eq=False):
    what: list[int] = SHARED


class Other:
    x: int = 1
'''


def loaded(name: str, path: Path) -> ModuleType:
    spec = spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


NATIVE = loaded("native_records", ROOT / "wheel_build" / "native_records.py")


def run(source: str, name: str) -> ModuleType:
    """Return the module that a source with plain classes makes."""
    module = ModuleType(name)
    sys.modules[name] = module  # where annotations are looked up
    exec(compile(NATIVE.native(source), name, "exec"), module.__dict__)  # noqa: S102 - our own source
    return module


MADE_NATIVE = run(Path(messages.__file__).read_text(), "native_messages")


@settings(max_examples=200, deadline=None)
@given(st.one_of(list(MESSAGES.values())), st.one_of(list(MESSAGES.values())))
def test_messages_are_made_compared_hashed_and_printed_as_before(message: Message, other: Message) -> None:
    plain = getattr(MADE_NATIVE, type(message).__name__)
    values = shape_of(type(message)).read(message)

    made, again = plain(*values), plain(**dict(zip(shape_of(type(message)).names, values, strict=True)))

    assert repr(made) == repr(message)
    assert made == again
    assert hash(made) == hash(again)
    same_type = type(other) is type(message)
    assert (made == getattr(MADE_NATIVE, type(other).__name__)(*shape_of(type(other)).read(other))) == (
        same_type and message == other
    )


@pytest.mark.parametrize("body_type", MESSAGES, ids=lambda body_type: body_type.__name__)
def test_annotations_are_told_as_before(body_type: type[Message]) -> None:
    hints = get_type_hints(getattr(MADE_NATIVE, body_type.__name__))

    # Records within are those of the other module.
    assert {
        name: str(hint).replace("native_messages", "passafe_protocol.messages") for name, hint in hints.items()
    } == {name: str(hint) for name, hint in get_type_hints(body_type).items()}


def test_what_is_no_record_stays_as_it_is() -> None:
    native = NATIVE.native(SOURCE)

    assert "SHARED = [1]  # type: ignore[assignment]  # a comment that mypy needs\n" in native
    assert native.endswith("\n\nclass Other:\n    x: int = 1\n")
    assert NATIVE.native("class Other:\n    x: int = 1\n") == "class Other:\n    x: int = 1\n"


def test_options_of_a_record_are_kept() -> None:
    module = run(SOURCE, "native_points")
    point, held = module.Point(x=1.0), module.Held()

    assert (point.x, point.y, point.kind, point.sum) == (1.0, 2.0, "point", 3.0)
    assert module.Point.__doc__ == "A point."
    with pytest.raises(TypeError, match="positional"):
        module.Point(1.0)
    assert point == module.Point(x=1.0, y=2.0)
    assert point != module.Point(x=1.0, y=3.0)
    assert held != module.Held()
    assert held.what is module.SHARED


def test_the_collector_passes_over_what_msgspecs_passes_over() -> None:
    decorators = [line for line in NATIVE.native(SOURCE).splitlines() if line.startswith("@mypyc_attr")]

    assert decorators == ["@mypyc_attr(acyclic=True, free_list_len=1)", "@mypyc_attr(free_list_len=1)"]


def test_a_field_that_is_no_name_is_refused() -> None:
    with pytest.raises(ValueError, match=r"got 'Other\.x: int', allowed NAME: TYPE"):
        NATIVE.native("from msgspec import Struct\n\n\nclass Odd(Struct):\n    Other.x: int\n")


def test_files_are_rewritten_in_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "points.py"
    path.write_text(SOURCE)
    monkeypatch.setattr(sys, "argv", ["native_records.py", str(path)])

    NATIVE.main()

    assert path.read_text() == NATIVE.native(SOURCE)
