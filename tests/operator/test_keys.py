"""Decoding of keys from terminal input."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st
from passafe_services.operator.keyboard.keys import Key, KeyReader

ARROWS = [Key.UP, Key.DOWN, Key.RIGHT, Key.LEFT]


@pytest.mark.parametrize(
    ("data", "keys"),
    [
        (b"\x1b[A\x1b[B\x1b[C\x1b[D", ARROWS),
        (b"\x1bOA\x1bOB\x1bOC\x1bOD", ARROWS),
        (b"\x1b[1;2A\x1b[1;5B", [Key.UP, Key.DOWN]),
        (b"wsda", ARROWS),
        (b"kjlh", ARROWS),
        (b"WSDAKJLH", ARROWS * 2),
        (b"yubn", [Key.UP_LEFT, Key.UP_RIGHT, Key.DOWN_LEFT, Key.DOWN_RIGHT]),
        (b" ", [Key.STOP]),
        (b"x", [Key.EMERGENCY_STOP]),
        (b"T", [Key.TAKE_OVER]),
        (b"q", [Key.QUIT]),
        (b"Q", [Key.QUIT]),
        (b"\x03", [Key.QUIT]),
        (b"\x04", [Key.QUIT]),
    ],
)
def test_keys_by_their_bytes(data: bytes, keys: list[Key]) -> None:
    assert KeyReader().feed(data) == keys


@pytest.mark.parametrize(
    "data",
    [b"", b"z7;", b"\x1b", b"\x1b[3~", b"\x1b[15~", b"\x1b[H", b"\x1bOP", b"\x1b[200~", "é☃".encode()],
)
def test_other_bytes_mean_nothing(data: bytes) -> None:
    assert KeyReader().feed(data) == []


def test_a_sequence_of_another_key_does_not_swallow_what_follows() -> None:
    assert KeyReader().feed(b"\x1b[3~w\x1b\x1b[A\x1bd") == [Key.UP, Key.UP, Key.RIGHT]


def test_the_last_letter_of_a_sequence_is_not_a_letter_key() -> None:
    # Read as letters, the arrows to the left and down would push to the right and down-left.
    reader = KeyReader()
    assert reader.feed(b"\x1b[") == []
    assert reader.feed(b"D") == [Key.LEFT]
    assert reader.feed(b"D") == [Key.RIGHT]


@given(data=st.binary(max_size=60), cuts=st.lists(st.integers(0, 60), max_size=4))
def test_where_reads_are_cut_does_not_matter(data: bytes, cuts: list[int]) -> None:
    places = [0, *sorted(min(cut, len(data)) for cut in cuts), len(data)]
    reader = KeyReader()
    pieces = [key for start, end in pairwise(places) for key in reader.feed(data[start:end])]
    assert pieces == KeyReader().feed(data)


@given(noise=st.binary(max_size=60))
def test_after_any_noise_an_arrow_is_an_arrow(noise: bytes) -> None:
    reader = KeyReader()
    reader.feed(noise)
    assert reader.feed(b"\x1b[A") == [Key.UP]
