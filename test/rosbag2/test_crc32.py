"""Where a flipped bit is: held against zlib."""

import random
import zlib

import pytest

from satdyn_ros.rosbag2.crc32 import flipped_byte


@pytest.mark.parametrize('size', [1, 3, 50, 10_000])
def test_a_flipped_bit_is_found(size):
    """In the first byte, the last one and others, whatever the data."""
    draw = random.Random(size)
    data = bytearray(draw.randbytes(size))
    sound = zlib.crc32(data)
    for byte in (0, size - 1, *(draw.randrange(size) for _ in range(20))):
        data[byte] ^= (bit := 1 << draw.randrange(8))
        assert flipped_byte(sound ^ zlib.crc32(data), size) == byte
        data[byte] ^= bit


def test_other_changes_are_no_flipped_bit():
    """No change, two bits, and a bit in front of the data that are searched."""
    data = bytearray(1000)
    sound = zlib.crc32(data)
    assert flipped_byte(0, 1000) is None
    data[7] = 1
    assert flipped_byte(sound ^ zlib.crc32(data), 992) is None
    data[900] = 1
    assert flipped_byte(sound ^ zlib.crc32(data), 1000) is None


def test_data_longer_than_the_period_have_several_such_bits():
    """The same difference is made every 2**32 - 1 bits, half a gigabyte."""
    assert flipped_byte(1, 2**29) is None
