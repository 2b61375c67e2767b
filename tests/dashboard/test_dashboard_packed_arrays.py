"""Arrays of a page: what a browser unpacks holds every value, to three digits in a hundred thousand."""

import zlib
from base64 import b64decode

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from passafe_dashboard.run_record.bucket_table import FloatArray
from passafe_dashboard.run_record.packed_arrays import DROPPED_BITS, BitArray, PackedArrays, Rounding, rounded_bits

PRECISION = 2.0 ** (DROPPED_BITS - 23)
FINITE = arrays(np.float64, st.integers(0, 50), elements=st.floats(-1e30, 1e30))


def unpack(text: str, offset: int, count: int) -> BitArray:
    """Return numbers as ``static/report/unpack.js`` reads them."""
    bytes_ = np.frombuffer(zlib.decompress(b64decode(text)), dtype=np.uint8)
    weights = bytes_[4 * offset : 4 * (offset + count)].reshape(4, count).astype(np.uint32)
    folded = weights[0] | weights[1] << 8 | weights[2] << 16 | weights[3] << 24
    steps = (folded >> 1) ^ (0 - (folded & 1)).astype(np.uint32)
    return np.cumsum(steps, dtype=np.uint32)


def values(bits: BitArray) -> FloatArray:
    return bits.view(np.float32).astype(np.float64)


@given(FINITE)
def test_an_envelope_holds_its_samples(samples: FloatArray) -> None:
    low = values(rounded_bits(samples, Rounding.DOWN))
    high = values(rounded_bits(samples, Rounding.UP))
    assert (low <= samples).all()
    assert (samples <= high).all()
    room = PRECISION * np.abs(samples) + 1e-42  # the smallest numbers have less precision
    assert (samples - low <= room).all()
    assert (high - samples <= room).all()


@given(FINITE)
def test_a_value_keeps_its_sign(samples: FloatArray) -> None:
    for rounding in Rounding:
        packed = values(rounded_bits(samples, rounding))
        assert not ((samples >= 0) & (packed < 0)).any()
        assert not ((samples <= 0) & (packed > 0)).any()
    assert (values(rounded_bits(samples, Rounding.DOWN))[samples < 0] < 0).all()


@given(st.lists(FINITE, max_size=4))
def test_arrays_are_found_by_their_offsets(columns: list[FloatArray]) -> None:
    packed = PackedArrays()
    offsets = [packed.floats(column) for column in columns]
    text = packed.text()
    for offset, column in zip(offsets, columns, strict=True):
        found = unpack(text, offset, column.size)
        assert found.tolist() == rounded_bits(column, Rounding.TO_ZERO).tolist()


def test_infinities_are_the_largest_and_nan_remains() -> None:
    found = values(rounded_bits(np.array([np.inf, -np.inf, np.nan]), Rounding.UP))
    assert found[0] > 2.9e38
    assert found[1] < -2.9e38
    assert np.isnan(found[2])


def test_times_are_microseconds_without_drift() -> None:
    t_ns = 7 + np.arange(10_000) * 1_234_567
    packed = PackedArrays()
    offset = packed.times(t_ns)
    steps = unpack(packed.text(), offset, t_ns.size)
    assert np.cumsum(steps.astype(np.int64)) * 1000 == pytest.approx(t_ns - t_ns[0], abs=501)


def test_a_smooth_signal_takes_two_bytes_a_sample() -> None:
    packed = PackedArrays()
    packed.floats(np.sin(np.arange(100_000) / 300))
    assert len(packed.text()) < 230_000
