"""Builds command sources that depend on the number of inputs only, and checks their settings."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Final, assert_never

from passafe_protocol.messages import Vector

from passafe_services.operator.errors import SourceConfigError
from passafe_services.operator.keyboard.keyboard import Keyboard
from passafe_services.operator.keyboard.keys import Key
from passafe_services.operator.sources.command_recording import LARGEST, SPACING_S, load_recording
from passafe_services.operator.sources.constant import Constant
from passafe_services.operator.sources.lag import Lag
from passafe_services.operator.sources.piecewise import PiecewiseLinear
from passafe_services.operator.sources.sine import Sine
from passafe_services.operator.sources.source import CommandSource
from passafe_services.scenarios import source_schema as schema

TIME_CONSTANT_MIN_S: Final = 1e-6
"""Smallest time constant: shorter lags are steps at every allowed rate, and their rate may overflow."""
KEYBOARD_INPUTS_MAX: Final = 2


def build_source(
    config: schema.ScriptSource,
    inputs: int,
    *,
    folder: Path | None = None,
    keys: Callable[[], Sequence[Key]] | None = None,
) -> CommandSource:
    """Return the command source that ``config`` describes.

    Args:
        config: The scenario's ``operator.source``.
        inputs: m, the robot's number of inputs.
        folder: Folder of the scenario file, base of a recording's relative path; ``None``: the current folder.
        keys: Returns the keys of a keyboard, as in ``Keyboard``; required there and only there.

    Raises:
        SourceConfigError: A setting does not fit the robot or is out of range.
        RecordingError: Recorded commands cannot be read.
    """
    match config:
        case schema.LagSource():
            return _lag(config, inputs)
        case schema.ConstantSource():
            return Constant(value=_vector("value", config.value, inputs))
        case schema.SineSource():
            return _sine(config, inputs)
        case schema.WaypointSource():
            return _waypoints(config, inputs)
        case schema.RecordedSource():
            recording = load_recording((folder or Path()) / config.path, inputs)
            return PiecewiseLinear.through(device="recorded", times_s=recording.times_s, values=recording.values)
        case schema.KeyboardSource():
            return _keyboard(config, inputs, keys)
        case _:
            assert_never(config)


def _vector(field: str, values: Vector, inputs: int) -> Vector:
    if len(values) != inputs:
        raise SourceConfigError(field, values, f"{inputs} numbers, one for each of the robot's inputs")
    if any(abs(value) > LARGEST for value in values):
        raise SourceConfigError(field, values, f"numbers from {-LARGEST:g} to {LARGEST:g}")
    return values


def _lag(config: schema.LagSource, inputs: int) -> Lag:
    if config.time_constant_s < TIME_CONSTANT_MIN_S:
        raise SourceConfigError(
            "time_constant_s", config.time_constant_s, f"{TIME_CONSTANT_MIN_S:g} or more, in seconds"
        )
    return Lag(target=_vector("target", config.target, inputs), time_constant_s=config.time_constant_s)


def _sine(config: schema.SineSource, inputs: int) -> Sine:
    zeros = (0.0,) * inputs
    return Sine(
        amplitude=_vector("amplitude", config.amplitude, inputs),
        offset=zeros if config.offset is None else _vector("offset", config.offset, inputs),
        phase_rad=zeros if config.phase_rad is None else _vector("phase_rad", config.phase_rad, inputs),
        frequency_hz=config.frequency_hz,
    )


def _waypoints(config: schema.WaypointSource, inputs: int) -> PiecewiseLinear:
    times_s = [point.at_s for point in config.points]
    for index, (earlier, later) in enumerate(pairwise(times_s), start=1):
        if later - earlier < SPACING_S:
            raise SourceConfigError(f"points[{index}].at_s", later, f"at least {SPACING_S:g} s after {earlier}")
    values = [_vector(f"points[{index}].value", point.value, inputs) for index, point in enumerate(config.points)]
    return PiecewiseLinear.through(device="waypoints", times_s=times_s, values=values)


def _keyboard(config: schema.KeyboardSource, inputs: int, keys: Callable[[], Sequence[Key]] | None) -> Keyboard:
    if keys is None:
        raise SourceConfigError("kind", config.kind, "a source that needs no person: nobody is at a terminal here")
    if not 1 <= inputs <= KEYBOARD_INPUTS_MAX:
        raise SourceConfigError("kind", config.kind, f"a robot with 1 or 2 inputs; this one has {inputs}")
    return Keyboard(authority=config.authority, inputs=inputs, keys=keys)
