"""The keyboard in virtual time: what presses, repeats, silence, stop and quit do to the command."""

from collections.abc import Sequence
from math import exp, hypot, sqrt

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from passafe_services.operator.keyboard.keyboard import PRESS_HOLD_S, RAMP_S, REPEAT_HOLD_S, REST_SHARE, Keyboard
from passafe_services.operator.keyboard.keys import DIRECTIONS, Key
from passafe_services.operator.sources.command import Command

AUTHORITY = 15.0


class Person:
    """Someone whose key presses are known beforehand, in front of a keyboard asked every millisecond."""

    def __init__(self, presses: Sequence[tuple[float, Key]], *, inputs: int = 2, period_s: float = 1e-3) -> None:
        self.presses = sorted(presses, key=lambda press: press[0])
        self.keyboard = Keyboard(authority=AUTHORITY, inputs=inputs, keys=self.poll)
        self.period_s = period_s
        self.steps = 0

    @property
    def t_s(self) -> float:
        """Time now, s."""
        return self.steps * self.period_s

    def poll(self) -> list[Key]:
        """Return the keys that came by now."""
        came = [key for at_s, key in self.presses if at_s <= self.t_s + 1e-9]
        self.presses = self.presses[len(came) :]
        return came

    def until(self, t_s: float) -> Command:
        """Let time pass up to ``t_s`` and return the command then."""
        command = self.keyboard.command(self.t_s)
        while self.t_s < t_s - 1e-9:
            self.steps += 1
            command = self.keyboard.command(self.t_s)
        return command


def held(key: Key, start_s: float, end_s: float, *, wait_s: float = 0.5) -> list[tuple[float, Key]]:
    """Return the events of a held key: the press, a delay, then 25 repeats a second."""
    repeats = range(int((end_s - start_s - wait_s) / 0.04) + 1) if end_s - start_s >= wait_s else range(0)
    return [(start_s, key), *((start_s + wait_s + 0.04 * index, key) for index in repeats)]


def test_at_rest_the_command_is_zero_and_the_dead_man_released() -> None:
    assert Person([]).until(1.0) == Command((0.0, 0.0), (0.0, 0.0), False)


@pytest.mark.parametrize("key", DIRECTIONS)
def test_a_held_key_ramps_to_full_authority_along_its_direction(key: Key) -> None:
    command = Person(held(key, 0.0, 1.0)).until(0.3)
    direction = [c / hypot(*DIRECTIONS[key]) for c in DIRECTIONS[key]]
    reached = AUTHORITY * (1 - exp(-0.3 / RAMP_S))
    assert command.u_h == pytest.approx([c * reached for c in direction])
    assert command.u_h_rate == pytest.approx([c * (AUTHORITY - reached) / RAMP_S for c in direction])
    assert command.enabled


@pytest.mark.parametrize("wait_s", [0.25, 0.5, 0.66])
def test_held_key_acts_without_a_gap_for_any_repeat_delay(
    wait_s: float,
) -> None:
    person = Person(held(Key.RIGHT, 0.0, 3.0, wait_s=wait_s))
    levels = [person.until(t_ms / 1000).u_h[0] for t_ms in range(3000)]
    assert levels == sorted(levels)
    assert levels[-1] == pytest.approx(AUTHORITY)


def test_repeating_key_fades_after_its_hold_time() -> None:
    presses = held(Key.RIGHT, 0.0, 1.3)
    over_s = presses[-1][0] + REPEAT_HOLD_S
    person = Person(presses)
    assert person.until(over_s - 0.002).u_h_rate[0] >= 0.0
    full = person.until(over_s).u_h[0]
    command = person.until(over_s + 0.1)
    assert command.u_h[0] == pytest.approx(full * exp(-0.1 / RAMP_S), rel=1e-3)
    assert command.u_h_rate[0] == pytest.approx(-command.u_h[0] / RAMP_S)
    assert command.enabled


def test_a_tap_counts_for_its_stated_time() -> None:
    person = Person([(0.0, Key.UP)])
    assert person.until(PRESS_HOLD_S - 0.002).u_h_rate[1] > 0
    assert person.until(PRESS_HOLD_S + 0.002).u_h_rate[1] < 0


def test_a_fade_ends_at_exactly_zero_with_the_dead_man_released() -> None:
    person = Person([(0.0, Key.UP)])
    # e^{-6.9} is the share of the authority that counts as rest.
    assert person.until(PRESS_HOLD_S + RAMP_S * 6.8).enabled
    assert person.until(PRESS_HOLD_S + RAMP_S * 7.0) == Command((0.0, 0.0), (0.0, 0.0), False)


def test_space_stops_at_once() -> None:
    person = Person([*held(Key.LEFT, 0.0, 1.0), (1.001, Key.STOP)])
    assert person.until(1.0).u_h[0] < -0.9 * AUTHORITY
    assert person.until(1.001) == Command((0.0, 0.0), (0.0, 0.0), False)
    assert person.until(2.0) == Command((0.0, 0.0), (0.0, 0.0), False)


def test_pending_repeats_do_not_undo_a_stop() -> None:
    late = [(1.0 + 0.04 * index, Key.LEFT) for index in range(20)]
    person = Person([*held(Key.LEFT, 0.0, 0.99), (0.995, Key.STOP), *late, (2.5, Key.LEFT)])
    person.until(0.995)
    for t_ms in range(996, 2500):
        assert person.until(t_ms / 1000) == Command((0.0, 0.0), (0.0, 0.0), False)
    assert person.until(2.6).u_h[0] < -0.5 * AUTHORITY


def test_a_stop_and_an_arrow_read_together_stop() -> None:
    person = Person([(0.5, Key.LEFT), (0.5, Key.STOP), (0.5, Key.LEFT)])
    assert person.until(0.6) == Command((0.0, 0.0), (0.0, 0.0), False)


def test_the_opposite_key_takes_over_at_once() -> None:
    person = Person([*held(Key.RIGHT, 0.0, 1.0), (1.001, Key.LEFT)])
    before = person.until(1.0).u_h[0]
    assert before == pytest.approx(AUTHORITY, rel=1e-3)
    assert person.until(1.001).u_h_rate[0] == pytest.approx(-2 * AUTHORITY / RAMP_S, rel=1e-3)


def test_a_diagonal_key_releases_only_what_opposes_it() -> None:
    person = Person([(0.0, Key.UP), (0.0, Key.RIGHT), (0.1, Key.DOWN_RIGHT)])
    person.until(0.0)
    command = person.until(0.1)
    goal = [c + RAMP_S * rate for c, rate in zip(command.u_h, command.u_h_rate, strict=True)]
    assert goal == pytest.approx([AUTHORITY * 2 / sqrt(5), -AUTHORITY / sqrt(5)])


def test_two_keys_together_share_the_authority() -> None:
    command = Person([(0.0, Key.UP), (0.0, Key.RIGHT)]).until(0.6)
    assert command.u_h[0] == command.u_h[1]
    assert hypot(*command.u_h) == pytest.approx(AUTHORITY * (1 - exp(-6)))


def test_robot_with_one_input_uses_left_and_right_only() -> None:
    assert Person([(0.0, Key.UP)], inputs=1).until(0.3).u_h == (0.0,)
    assert Person([(0.0, Key.UP_RIGHT)], inputs=1).until(0.3).u_h == pytest.approx((AUTHORITY * (1 - exp(-3)),))


def test_quit_stops_at_once_and_for_good() -> None:
    person = Person([*held(Key.LEFT, 0.0, 1.0), (1.001, Key.QUIT), (2.0, Key.LEFT)])
    person.until(1.0)
    assert not person.keyboard.finished
    assert person.until(1.001) == Command((0.0, 0.0), (0.0, 0.0), False)
    assert person.keyboard.finished
    assert person.until(2.5) == Command((0.0, 0.0), (0.0, 0.0), False)


# In sixteenths of a second, which floats hold exactly and which meet no hold time on its edge.
PRESSES = st.lists(st.tuples(st.integers(0, 64).map(lambda count: count / 16), st.sampled_from(Key)), max_size=12)


@settings(deadline=None)  # each example is seconds of virtual time
@given(presses=PRESSES)
def test_any_keys_stay_within_the_authority_and_end_at_rest(
    presses: list[tuple[float, Key]],
) -> None:
    person = Person(presses, period_s=0.01)
    for step in range(420):
        command = person.until(step * 0.01)
        assert hypot(*command.u_h) <= AUTHORITY * (1 + 1e-12)
        assert command.enabled or command == Command((0.0, 0.0), (0.0, 0.0), False)
    assert person.until(4.0 + PRESS_HOLD_S + 8 * RAMP_S) == Command((0.0, 0.0), (0.0, 0.0), False)


@settings(deadline=None)  # each example is seconds of virtual time
@given(presses=PRESSES)
def test_command_does_not_depend_on_the_command_rate(presses: list[tuple[float, Key]]) -> None:
    often, seldom = Person(presses, period_s=1 / 128), Person(presses, period_s=1 / 16)
    for sixteenth in range(100):
        fine, coarse = often.until(sixteenth / 16).u_h, seldom.until(sixteenth / 16).u_h
        # Only where a fade counts as over is judged at the moments asked for.
        assert fine == pytest.approx(coarse, abs=1.01 * REST_SHARE * AUTHORITY)


@settings(deadline=None)  # each example is seconds of virtual time
@given(presses=PRESSES, step=st.integers(1, 4500))
def test_the_rate_is_the_derivative_of_what_follows(presses: list[tuple[float, Key]], step: int) -> None:
    person = Person(presses)
    person.until(step * 1e-3)
    # Keys come and go on whole milliseconds: nothing happens between these two.
    command = person.keyboard.command(person.t_s + 0.5e-3)
    after = person.keyboard.command(person.t_s + 0.5e-3 + 1e-6)
    if command.u_h != after.u_h and after.enabled:
        difference = [(b - a) / 1e-6 for a, b in zip(command.u_h, after.u_h, strict=True)]
        assert command.u_h_rate == pytest.approx(difference, rel=1e-4, abs=0.05)


def test_keys_are_released_at_their_time_after_a_suspension() -> None:
    person = Person([(0.0, Key.RIGHT)])
    person.until(0.0)
    woken = person.keyboard.command(PRESS_HOLD_S + 0.2)
    assert woken.u_h[0] == pytest.approx(AUTHORITY * (1 - exp(-PRESS_HOLD_S / RAMP_S)) * exp(-0.2 / RAMP_S))
