"""No flipped bit passes for another message, and other programs can check the same sum."""

from binascii import crc32

import pytest
from hypothesis import given
from hypothesis import strategies as st
from passafe_protocol import passafe_pb2
from passafe_protocol.checksum import CHECKSUM_BYTES, is_intact, with_checksum
from passafe_protocol.codec import decode, encode
from passafe_protocol.errors import ChecksumError
from passafe_protocol.messages import Header, Message
from passafe_protocol.topics import TOPIC_OF_BODY


def test_the_check_value_of_the_standard() -> None:
    assert with_checksum(b"123456789")[-4:] == (0xCBF43926).to_bytes(4, "little")


def test_any_flipped_bit_of_any_message_is_found(header: Header, body: Message) -> None:
    whole = encode(header, body)
    for bit in range(8 * len(whole)):
        damaged = bytearray(whole)
        damaged[bit // 8] ^= 1 << bit % 8
        with pytest.raises(ChecksumError):
            decode(TOPIC_OF_BODY[type(body)], bytes(damaged))


def test_the_checksum_is_a_field_of_the_message(header: Header, body: Message) -> None:
    whole = encode(header, body)
    message = getattr(passafe_pb2, type(body).__name__).FromString(whole)

    assert message.checksum == crc32(whole[:-CHECKSUM_BYTES])


@given(st.binary(max_size=200))
def test_what_was_sealed_is_intact_and_what_was_not_is_not(data: bytes) -> None:
    assert is_intact(with_checksum(data))
    assert not is_intact(with_checksum(data)[:-1])
    assert not is_intact(with_checksum(data) + b"\0")


@pytest.mark.parametrize("size", range(CHECKSUM_BYTES))
def test_less_than_a_checksum_is_not_intact(size: int) -> None:
    assert not is_intact(with_checksum(b"")[:size])
