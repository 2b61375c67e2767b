"""The name that somebody most likely meant: the one place that makes suggestions for misspelt names."""

from collections.abc import Iterable
from difflib import get_close_matches


def suggestion(got: str, names: Iterable[str]) -> str:
    """Return ``; did you mean NAME?`` for the known name nearest to ``got``, or nothing where none is near."""
    near = get_close_matches(got, list(names), n=1)
    return f"; did you mean {near[0]}?" if near else ""
