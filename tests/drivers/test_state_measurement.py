"""Measured states: noise by seed and period, within its bound; quantised to whole steps."""

import numpy as np
from passafe_services.drivers.state_measurement import BLOCK, StateMeasurement

ZEROS = (0.0, 0.0)


def test_no_errors_leave_a_state_as_it_is() -> None:
    x = (0.1, 0.2)

    assert StateMeasurement(bound=ZEROS, seed=1, steps=ZEROS).of(x, 7) is x


def test_noise_is_a_function_of_seed_and_period() -> None:
    one, same, other = (StateMeasurement(bound=(1.0, 0.0), seed=seed, steps=ZEROS) for seed in (1, 1, 2))
    periods = [0, BLOCK - 1, BLOCK, 5 * BLOCK, 3]

    assert [one.of(ZEROS, k) for k in periods] == [same.of(ZEROS, k) for k in reversed(periods)][::-1]
    assert one.of(ZEROS, 3) != other.of(ZEROS, 3)
    assert one.of(ZEROS, 3)[1] == 0.0


def test_noise_fills_its_bound_evenly() -> None:
    measurement = StateMeasurement(bound=(2.0, 0.0), seed=1, steps=ZEROS)
    noise = np.array([measurement.of(ZEROS, k)[0] for k in range(20_000)])

    assert np.abs(noise).max() <= 2.0
    assert abs(noise.std() - 2.0 / np.sqrt(3)) < 0.02
    assert abs(noise.mean()) < 0.03


def test_states_are_rounded_to_whole_steps() -> None:
    assert StateMeasurement(bound=ZEROS, seed=1, steps=(0.25, 0.0)).of((0.4, 0.4), 0) == (0.5, 0.4)
