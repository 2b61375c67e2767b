"""Checks of the parts of a robot that are no expressions: words, counts, and parts of one kind."""

from collections.abc import Iterable
from typing import Final, TypeVar

from passafe.arguments.numbers import described, is_one_number, members, numbers
from passafe.errors import DesignError

LONGEST_WORD: Final = 200
"""Characters of a name or a unit: what a log keeps."""

LONGEST_TEXT: Final = 1000

Part = TypeVar("Part")


def text(part: str, value: object, longest: int = LONGEST_WORD) -> str:
    """Return a text, perhaps an empty one.

    Raises:
        DesignError: It is none, or a longer one.
    """
    if not isinstance(value, str):
        raise DesignError(part, described(value), "text")
    if len(value) > longest:
        raise DesignError(part, f"{len(value)} characters", f"at most {longest}")
    return value


def name(part: str, value: object) -> str:
    """Return a name.

    Raises:
        DesignError: It is none, or an empty or a longer one, or does not fit in a line.
    """
    word = text(part, value)
    if not word:
        raise DesignError(part, "no characters", f"a name of 1 to {LONGEST_WORD} characters")
    if not word.isprintable():
        raise DesignError(part, described(word), "printable characters in one line")
    return word


def texts(part: str, value: object, count: int) -> tuple[str, ...]:
    """Return so many texts, or none at all.

    Raises:
        DesignError: They are none, or another number of them.
    """
    found = members(value)
    if found is None:
        raise DesignError(part, described(value), f"a sequence of {count} words, or none")
    words = tuple(text(part, each) for each in found)
    if words and len(words) != count:
        raise DesignError(part, f"{len(words)} words", f"{count}, one for each, or none")
    return words


def count(part: str, value: object, most: int) -> int:
    """Return a whole number from 0.

    Raises:
        DesignError: It is none, or a larger one.
    """
    allowed = f"a whole number from 0 to {most}"
    if isinstance(value, bool) or not is_one_number(value):
        raise DesignError(part, described(value), allowed)
    [found] = numbers(part, value, allowed)
    if found not in range(most + 1):
        raise DesignError(part, described(value), allowed)
    return int(found)


def kinds(part: str, value: object, kind: type[Part], allowed: str) -> tuple[Part, ...]:
    """Return the members of a sequence, all of one kind.

    Raises:
        DesignError: It is no sequence, or has another member.
    """
    found = members(value)
    others: Iterable[object] = [value] if found is None else [each for each in found if not isinstance(each, kind)]
    for other in others:
        raise DesignError(part, described(other), allowed)
    return tuple(each for each in found or () if isinstance(each, kind))


def kind_or_none(part: str, value: object, kind: type[object]) -> None:
    """Refuse what is neither of a kind nor ``None``.

    Raises:
        DesignError: It is something else.
    """
    if value is not None and not isinstance(value, kind):
        raise DesignError(part, described(value), f"a passafe.{kind.__name__}, or None")
