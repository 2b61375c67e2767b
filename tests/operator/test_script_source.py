"""From the scenario's words to a source that fits the robot."""

from pathlib import Path

import pytest
from passafe_services.operator.errors import RecordingError, SourceConfigError
from passafe_services.operator.keyboard.keys import Key
from passafe_services.operator.sources.command import Command
from passafe_services.operator.sources.script_source import build_source
from passafe_services.operator.sources.source import CommandSource, SourceClock
from passafe_services.scenarios import source_schema as schema
from pydantic import TypeAdapter

SOURCE: TypeAdapter[schema.SourceConfig] = TypeAdapter(schema.SourceConfig)


def build(inputs: int = 2, **config: object) -> CommandSource:
    return build_source(SOURCE.validate_python(config), inputs)


def test_the_lag_of_the_scenario() -> None:
    source = build(kind="lag", target=[-3.0, 0.0], time_constant_s=0.2)
    assert source.device == "lag"
    assert source.command(0.0) == Command((0.0, 0.0), (-15.0, 0.0), True)


def test_a_constant() -> None:
    source = build(kind="constant", value=[1.0, 2.0])
    assert source.device == "constant"
    assert source.command(5.0).u_h == (1.0, 2.0)


def test_a_sine_without_offset_and_phase_starts_at_zero() -> None:
    source = build(kind="sine", amplitude=[1.0, 2.0], frequency_hz=0.25)
    assert source.device == "sine"
    assert source.command(0.0).u_h == (0.0, 0.0)
    assert source.command(1.0).u_h == pytest.approx((1.0, 2.0))


def test_a_sine_with_offset_and_phase() -> None:
    source = build(kind="sine", amplitude=[1.0], frequency_hz=1.0, offset=[5.0], phase_rad=[1.5], inputs=1)
    assert source.command(0.0).u_h[0] == pytest.approx(5.9974949866)


def test_waypoints() -> None:
    source = build(kind="waypoints", points=[{"at_s": 0, "value": [0, 0]}, {"at_s": 2, "value": [4, -2]}])
    assert source.device == "waypoints"
    assert source.command(1.0) == Command((2.0, -1.0), (2.0, -1.0), True)


def test_recording_is_found_beside_its_scenario_and_held_at_end(tmp_path: Path) -> None:
    (tmp_path / "drive.csv").write_text("time_s,u_h_0,u_h_1\n0,0,0\n1,2,4\n")
    source = build_source(schema.RecordedSource(kind="recorded", path="drive.csv"), 2, folder=tmp_path)
    assert source.device == "recorded"
    assert source.command(0.5) == Command((1.0, 2.0), (2.0, 4.0), True)
    assert source.command(7.0) == Command((2.0, 4.0), (0.0, 0.0), True)


def test_missing_recording_is_a_recording_error(tmp_path: Path) -> None:
    with pytest.raises(RecordingError) as caught:
        build_source(schema.RecordedSource(kind="recorded", path="none.csv"), 2, folder=tmp_path)
    assert isinstance(caught.value, RecordingError)
    assert caught.value.path == tmp_path / "none.csv"


@pytest.mark.parametrize("inputs", [1, 2])
def test_a_keyboard_drives_one_or_two_inputs_with_its_authority(inputs: int) -> None:
    pressed = [[Key.RIGHT]]
    source = build_source(
        schema.KeyboardSource(kind="keyboard", authority=8.0),
        inputs,
        keys=lambda: pressed.pop() if pressed else (),
    )
    assert source.device == "keyboard"
    assert source.clock is SourceClock.LOCAL
    assert source.command(0.0).u_h_rate == pytest.approx((80.0, 0.0)[:inputs])


@pytest.mark.parametrize("inputs", [0, 3])
def test_a_keyboard_refuses_other_robots(inputs: int) -> None:
    with pytest.raises(SourceConfigError, match="1 or 2 inputs"):
        build_source(schema.KeyboardSource(kind="keyboard"), inputs, keys=list)


def test_a_keyboard_needs_keys() -> None:
    with pytest.raises(SourceConfigError, match="nobody is at a terminal"):
        build(kind="keyboard")


@pytest.mark.parametrize(
    ("config", "field"),
    [
        ({"kind": "lag", "target": [1.0], "time_constant_s": 1.0}, "target"),
        ({"kind": "lag", "target": [1.0, 2e6], "time_constant_s": 1.0}, "target"),
        ({"kind": "lag", "target": [1.0, 1.0], "time_constant_s": 1e-300}, "time_constant_s"),
        ({"kind": "constant", "value": [1.0, 2.0, 3.0]}, "value"),
        ({"kind": "constant", "value": [1.0, -1e300]}, "value"),
        ({"kind": "sine", "amplitude": [1.0], "frequency_hz": 1.0}, "amplitude"),
        ({"kind": "sine", "amplitude": [1.0, 1.0], "frequency_hz": 1.0, "offset": [0.0]}, "offset"),
        ({"kind": "sine", "amplitude": [1.0, 1.0], "frequency_hz": 1.0, "phase_rad": [0.0]}, "phase_rad"),
        (
            {"kind": "waypoints", "points": [{"at_s": 0, "value": [1, 2]}, {"at_s": 1, "value": [1]}]},
            "points[1].value",
        ),
        (
            {"kind": "waypoints", "points": [{"at_s": 0, "value": [1, 2]}, {"at_s": 1e-12, "value": [1, 2]}]},
            "points[1].at_s",
        ),
    ],
)
def test_what_does_not_fit_is_named(config: dict[str, object], field: str) -> None:
    with pytest.raises(SourceConfigError) as caught:
        build_source(SOURCE.validate_python(config), 2)
    assert caught.value.field == field
    assert f"operator.source.{field}: got " in str(caught.value)
    assert "\n" not in str(caught.value)
