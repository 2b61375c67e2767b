"""Changes of a scenario from one run to another, key by key."""

from collections.abc import Iterator
from typing import Any, NamedTuple

from passafe_services.scenarios.link_schema import ScenarioLink
from passafe_services.scenarios.schema import Scenario

_NOTHING: Any = None


class Change(NamedTuple):
    """One key of a scenario that differs.

    Attributes:
        key: Its dotted name.
        before: Its value in the log; ``None`` if it had none.
        after: Its value in the re-run; ``None`` if it has none.
    """

    key: str
    before: Any
    after: Any

    def __str__(self) -> str:
        return f"{self.key} {_text(self.before)} -> {_text(self.after)}"


def changes_between(before: Scenario, after: Scenario) -> tuple[Change, ...]:
    """Return every key that differs between two scenarios, names and descriptions aside."""
    aside = {"name", "title", "description"}
    left, right = (each.model_dump(mode="json", exclude=aside) for each in (before, after))
    for name in {*left["links"], *right["links"]}:  # a link that is not named has no effect
        for each in (left, right):
            each["links"].setdefault(name, ScenarioLink().model_dump(mode="json"))
    return tuple(_differences("", left, right))


def _differences(path: str, before: Any, after: Any) -> Iterator[Change]:  # noqa: ANN401 - any JSON value
    if isinstance(before, dict) and isinstance(after, dict):
        for key in [*before, *(key for key in after if key not in before)]:
            yield from _differences(f"{path}.{key}" if path else key, before.get(key), after.get(key))
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        for index, (left, right) in enumerate(zip(before, after, strict=True)):
            yield from _differences(f"{path}.{index}", left, right)
    elif before != after:
        yield Change(path, before, after)


def _text(value: object) -> str:
    return "nothing" if value is None else f"{value:g}" if isinstance(value, float) else str(value)
