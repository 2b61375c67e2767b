"""The manifest of a checkpoint: what goes in comes out, for any numbers that a log can have."""

from hashlib import sha256

import pytest
from hypothesis import given
from hypothesis import strategies as st
from passafe_services.log.manifest import TAG_BYTES, Entry, Manifest, entries_of, key_prefix, message_digest

DIGEST = sha256(b"").digest()
ENTRIES = st.lists(
    st.tuples(st.integers(1, 2**16 - 1), st.integers(0, 2**32 - 1), st.integers(0, 2**64 - 1)), max_size=30
)


@given(entries=ENTRIES)
def test_entries_survive_the_manifest(entries: list[tuple[int, int, int]]) -> None:
    manifest = Manifest()
    for entry in entries:
        manifest.add(*entry, DIGEST)
    assert entries_of(manifest.text, len(entries)) == [Entry(*entry, DIGEST[:TAG_BYTES]) for entry in entries]
    assert manifest.digest == sha256(DIGEST * len(entries)).hexdigest()


@pytest.mark.parametrize("text", ["", "no base 64 !", "aGVsbG8=", "eJwDAAAAAAE="])
def test_what_is_no_manifest_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r".+"):
        entries_of(text, 3)


def test_the_digest_is_the_documented_one() -> None:
    key = b"passafe/robot/plant/state"
    wire = (7).to_bytes(4, "little") + (8).to_bytes(8, "little") + (9).to_bytes(8, "little")
    wire += len(key).to_bytes(2, "little") + key + b"data"
    assert message_digest(key_prefix(key.decode()), 7, 8, 9, b"data") == sha256(wire).digest()
