"""JSON of what the server sends: numbers that JSON cannot hold become null."""

from pydantic_core import to_json


def json_text(value: object) -> str:
    """Return the JSON text of a value; NaN and infinities become null."""
    return to_json(value, inf_nan_mode="null").decode()
