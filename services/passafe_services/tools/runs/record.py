"""Base of all that sweeps write down: results, summaries and their parts."""

from pydantic import BaseModel, ConfigDict


class SweepRecord(BaseModel):
    """A record that JSON keeps to the last bit: immutable, unknown keys refused, infinities and NaN by name."""

    model_config = ConfigDict(frozen=True, extra="forbid", ser_json_inf_nan="constants")
