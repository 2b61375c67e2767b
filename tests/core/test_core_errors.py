import pickle

import pytest

from passafe.errors import DesignError, IntegrationError, PassafeError, RelativeDegreeError, ShapeError


def test_one_base_catches_whatever_the_core_refuses() -> None:
    for error in (DesignError, ShapeError, RelativeDegreeError, IntegrationError):
        assert issubclass(error, PassafeError)
    assert issubclass(ShapeError, DesignError)
    assert issubclass(RelativeDegreeError, DesignError)
    assert not issubclass(IntegrationError, DesignError)


@pytest.mark.parametrize("kind", [DesignError, ShapeError])
def test_design_errors_say_what_got_and_allowed(kind: type[DesignError]) -> None:
    error = kind("disk radius", -1.0, "a positive number, m")

    assert (error.field, error.got, error.allowed) == ("disk radius", -1.0, "a positive number, m")
    assert str(error) == "disk radius: got -1.0, allowed a positive number, m"


def test_relative_degree_error_names_barrier_and_derivatives() -> None:
    error = RelativeDegreeError("disk", 4)

    assert (error.barrier, error.tried, error.field) == ("disk", 4, "barrier 'disk'")
    assert str(error).startswith("barrier 'disk': got an h whose first 4 time derivatives do not contain the input, ")


def test_integration_errors_carry_their_values() -> None:
    error = IntegrationError(2.5e-9, 1e-10, 256)

    assert (error.error, error.tolerance, error.substeps) == (2.5e-9, 1e-10, 256)
    assert str(error) == "integration error: got 2.5e-09 with 256 substeps, allowed 1e-10"


def test_an_error_survives_the_way_from_a_worker() -> None:
    error = ShapeError("x", (1.0,), "4 numbers")
    arrived = pickle.loads(pickle.dumps(error))  # noqa: S301 - our own bytes

    assert type(arrived) is ShapeError
    assert (str(arrived), vars(arrived)) == (str(error), vars(error))
