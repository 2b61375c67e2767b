"""Errors of the core: all raised while a filter is designed, none in the loop.

* ``PassafeError``
    * ``DesignError``: a part of the design that cannot be used as given
        * ``ShapeError``: an expression or vector of the wrong shape
        * ``RelativeDegreeError``: a barrier that the input never reaches
    * ``IntegrationError``: a step of a nonlinear plant that did not reach its stated accuracy
"""


class PassafeError(Exception):
    """Anything that the core refuses."""


class DesignError(PassafeError):
    """A part of the design that cannot be used as given.

    Attributes:
        part: What it is about, for example ``barrier 'disk' class_k``.
        got: What was given.
        allowed: What is allowed, in words.
    """

    def __init__(self, part: str, got: object, allowed: str) -> None:
        self.part = part
        self.got = got
        self.allowed = allowed
        super().__init__(f"{part}: got {got}, allowed {allowed}")


class ShapeError(DesignError):
    """An expression or vector of the wrong shape."""


class RelativeDegreeError(DesignError):
    """A barrier whose derivatives never contain the input.

    Attributes:
        barrier: Name of the barrier.
        tried: Number of derivatives that were taken.
    """

    def __init__(self, barrier: str, tried: int) -> None:
        self.barrier = barrier
        self.tried = tried
        super().__init__(
            f"barrier {barrier!r}",
            f"an h whose first {tried} time derivatives do not contain the input",
            "an h with a relative degree: the input must reach it through the dynamics",
        )


class IntegrationError(PassafeError):
    """A step of a nonlinear plant that did not reach its stated accuracy.

    Attributes:
        error: Estimated local error that remained.
        tolerance: Stated accuracy.
        substeps: Number of substeps at which the attempt ended.
    """

    def __init__(self, error: float, tolerance: float, substeps: int) -> None:
        self.error = error
        self.tolerance = tolerance
        self.substeps = substeps
        super().__init__(f"integration error: got {error:.3g} with {substeps} substeps, allowed {tolerance:.3g}")
