"""JSON of what the server sends: numbers that JSON cannot hold become null."""

import json
from math import isfinite
from typing import Any


def json_text(value: object) -> str:
    """Return the JSON text of a value; NaN and infinities become null."""
    try:
        return json.dumps(value, allow_nan=False, separators=(",", ":"), ensure_ascii=False)
    except ValueError:
        return json.dumps(_finite(value), allow_nan=False, separators=(",", ":"), ensure_ascii=False)


def _finite(value: Any) -> Any:  # noqa: ANN401 - JSON values of any kind
    if isinstance(value, float):
        return value if isfinite(value) else None
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return value
