"""Mutated files and messages end in a typed error or are accepted; nothing else escapes."""

from pathlib import Path

import pytest
from fuzz_targets import TARGETS, corpus_of, survives, with_checksum
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

WORDS = (
    b"nan",
    b"inf",
    b"1e999",
    b"-1",
    b"18446744073709551616",
    b"true",
    b'""',
    b"[]",
    b"{}",
    b"\n",
    b",",
    b"\xff",
    b"\0",
)


@st.composite
def mutated(draw: st.DrawFn, seeds: list[bytes], *, is_message: bool) -> bytes:
    """Return a seed with some pieces replaced, repeated, cut out or put in; of a message with a valid checksum."""
    data = bytearray(draw(st.sampled_from(seeds)))
    if is_message:
        del data[-6:]
    for _ in range(draw(st.integers(0, 6))):
        at = draw(st.integers(0, len(data)))
        length = draw(st.integers(0, min(32, len(data) - at)))
        piece = bytes(data[at : at + length])
        put = draw(st.sampled_from([b"", piece * 3, *WORDS]) | st.binary(max_size=8))
        data[at : at + length] = put
    return with_checksum(bytes(data)) if is_message else bytes(data)


def fuzz(name: str, folder: Path, examples: int) -> None:
    seeds = corpus_of(name)

    @settings(max_examples=examples, deadline=None, suppress_health_check=list(HealthCheck), database=None)
    @given(mutated(seeds, is_message=name == "codec") | st.binary(max_size=200))
    def run(data: bytes) -> None:
        survives(name, data, folder)

    run()


@pytest.mark.parametrize("name", TARGETS)
def test_kept_inputs_do_no_harm(name: str, tmp_path: Path) -> None:
    accepted = [survives(name, data, tmp_path) for data in corpus_of(name)]
    assert any(accepted)


@pytest.mark.parametrize("name", TARGETS)
def test_some_mutations_do_no_harm(name: str, tmp_path: Path) -> None:
    fuzz(name, tmp_path, 60)


@pytest.mark.campaign
@pytest.mark.parametrize("name", TARGETS)
def test_many_mutations_do_no_harm(name: str, tmp_path: Path) -> None:
    fuzz(name, tmp_path, 5_000)
