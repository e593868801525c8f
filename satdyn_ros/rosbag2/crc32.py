"""Where a flipped bit is, by what it does to a CRC-32."""

from ..kernel.compile import compiled

# That of CRC-32, reversed, as the register goes backwards.
_POLYNOMIAL = 0x1DB710641
# Bits so far apart make the same difference.
_PERIOD = 2**32 - 1


def flipped_byte(difference: int, size: int) -> int | None:
    """
    Return the byte, of `size`, in which one flipped bit changes the checksum by difference.

    difference: the exclusive or of both checksums.  None: no bit does, or there are so many bytes
    that several may.
    """
    if 8 * size > _PERIOD:
        return None
    bits = _bits_from_end(difference, 8 * size)
    return size - (bits + 7) // 8 if bits else None


@compiled
def _bits_from_end(difference, count):
    """Return how far before the end, of `count` bits, the flipped one is; 0: it is none."""
    register = difference
    for bits in range(1, count + 1):
        register <<= 1
        # Not by a branch, which no processor could predict.
        register ^= _POLYNOMIAL & -(register >> 32)
        if register == 1:
            return bits
    return 0
