"""Every error of every package: one root, drawn once, safe to send from a worker process."""

import pickle
import re
from collections.abc import Iterator
from importlib import import_module
from inspect import getmembers, isclass
from pathlib import Path
from pkgutil import walk_packages

import passafe_dashboard
import passafe_protocol
import passafe_services
import pytest
from passafe_dashboard.errors import (
    LinkAnswerError,
    LinkUpdateError,
    PageAccessError,
    PageAddressError,
    PagePortInUseError,
    SeriesError,
)
from passafe_protocol.errors import (
    ChecksumError,
    DecodeError,
    InvalidMessageError,
    LinkSettingsError,
    SchemaVersionError,
)
from passafe_services.cli.errors import OptionError
from passafe_services.log.errors import LogReadError, LogWriteError
from passafe_services.loop.errors import (
    BusError,
    EndpointError,
    LinkNameError,
    LinkRefusedError,
    LinkSilentError,
    PortInUseError,
    PublisherError,
)
from passafe_services.operator.errors import RecordingError, SourceConfigError, TerminalError
from passafe_services.scenarios.errors import LinkTraceError, ScenarioError, UnknownScenarioError
from passafe_services.scenarios.field_problems import FieldProblem

import passafe
from passafe.errors import DesignError, IntegrationError, NotAllowedError, PassafeError, RelativeDegreeError

ERRORS = [
    DesignError("disk radius", -1.0, "a positive number, m"),
    RelativeDegreeError("disk", 4),
    IntegrationError(2.5e-9, 1e-10, 256),
    DecodeError("state", 3, "no header"),
    ChecksumError("state", 3),
    InvalidMessageError("state", "x", (), "1 to 64 numbers"),
    SchemaVersionError("state", 2, 1),
    LinkSettingsError("loss", 2.0, "a number from 0 to 1"),
    EndpointError("port", 0, "1 to 65535"),
    BusError("tcp/127.0.0.1:7447", "no router answered"),
    PortInUseError("127.0.0.1", 7447),
    PublisherError("plant", "command", ("operator",)),
    LinkNameError("filter-to-moon", ("filter-to-plant",)),
    LinkSilentError("filter-to-plant", "plant", 3.0),
    LinkRefusedError("filter-to-plant", "outages in the past"),
    ScenarioError("mine", "k_i", 0, "above 0", FieldProblem(field="name", got="3", allowed="text in quotes")),
    UnknownScenarioError("mien", ("mine",)),
    LinkTraceError(Path("trace.csv"), "no times", "at least one"),
    SourceConfigError("kind", "keyboard", "a source that needs no person"),
    RecordingError(Path("run.csv"), line=3, column="u_h_1", got="a", allowed="a number"),
    TerminalError("an input that is no terminal", "a terminal"),
    LogReadError(Path("run.mcap"), "is empty"),
    LogWriteError(Path("run.mcap"), OSError(28, "No space left on device")),
    OptionError("--gain", 0, "above 0"),
    SeriesError("x", "1 rows", "2 or more"),
    PageAddressError("127.0.0.1", 80, "permission denied"),
    PagePortInUseError("127.0.0.1", 8080),
    PageAccessError("--page-token", "3 characters", "16"),
    LinkUpdateError(("loss",), 2, "0 to 1"),
    LinkAnswerError("filter-to-plant", "plant", "no answer"),
]


def all_errors() -> Iterator[type[BaseException]]:
    """Exception classes that our packages define."""
    seen = set()
    for package in (passafe, passafe_protocol, passafe_services, passafe_dashboard):
        for info in walk_packages(package.__path__, f"{package.__name__}."):
            if info.name.endswith("__main__"):
                continue
            module = import_module(info.name)
            for _, one in getmembers(module, isclass):
                if issubclass(one, BaseException) and one.__module__ == info.name and one not in seen:
                    seen.add(one)
                    yield one


def drawn() -> dict[str, str]:
    """Each class of the tree in the docstring of ``passafe.errors`` and the one above it."""
    above: list[str] = []
    found = {}
    text = passafe.errors.__doc__ or ""
    for indent, name in re.findall(r"^( *)\* ``(\w+)``", text, flags=re.MULTILINE):
        del above[len(indent) // 4 :]
        found[name] = above[-1] if above else "Exception"
        above.append(name)
    return found


def test_tree_of_errors_is_drawn_as_it_is() -> None:
    assert drawn() == {error.__name__: error.__bases__[0].__name__ for error in all_errors()}


def test_every_error_has_the_root() -> None:
    assert [error for error in all_errors() if not issubclass(error, PassafeError)] == []


@pytest.mark.parametrize("error", ERRORS, ids=lambda error: type(error).__name__)
def test_error_survives_the_way_from_a_worker_process(error: PassafeError) -> None:
    arrived = pickle.loads(pickle.dumps(error))  # noqa: S301 - our own bytes
    assert type(arrived) is type(error)
    assert str(arrived) == str(error)
    assert vars(arrived) == vars(error)


@pytest.mark.parametrize(
    "error", [one for one in ERRORS if isinstance(one, NotAllowedError)], ids=lambda error: type(error).__name__
)
def test_not_allowed_error_states_field_got_and_allowed(error: NotAllowedError) -> None:
    if not isinstance(error, PagePortInUseError):  # has words of its own
        assert ": got " in str(error)
        assert f"allowed {error.allowed}" in str(error)
        assert error.field in str(error)


def test_text_of_a_quoted_value_stays_short() -> None:
    assert len(str(InvalidMessageError("event", "text", "x" * 1_000_000, "less"))) < 200
    assert "got 'to the moon'" in str(EndpointError("host", "to the moon", "a host"))
