"""Compression of chunk contents, and decompression within memory limits."""

from collections.abc import Callable

import lz4.frame
import numpy as np
import zstandard

from .errors import Damaged

COMPRESSIONS = ('none', 'lz4', 'zstd')

# The most a chunk may hold [bytes]: rosbag2 and satdyn_ros write less than one per cent of it.
CEILING = 256 * 2**20

# The first of the fast levels: output two to six per cent larger than at the default level, in 70
# per cent of the time.
_ZSTD_LEVEL = -1
# Rows repeat what stands a row before: a table of so few places (2^11) finds it, and stays in the
# first-level cache.  A tenth less time; output 0 to 2 per cent larger.
_ZSTD_HASH_LOG = 11


def compressor(compression: str) -> Callable[[np.ndarray], bytes]:
    """Return the function that compresses contents (N,) uint8: 'zstd', 'lz4' or '' for none."""
    if compression == 'zstd':
        parameters = zstandard.ZstdCompressionParameters.from_level(
            _ZSTD_LEVEL, hash_log=_ZSTD_HASH_LOG
        )
        context = zstandard.ZstdCompressor(compression_params=parameters)
        return lambda contents: context.compress(contents.data)
    if compression == 'lz4':
        return lz4.frame.compress
    return np.ndarray.tobytes


def decompress(compression: str, data: bytes, size: int) -> bytes:
    """
    Return the contents, `size` bytes, of compressed data, by the name in a chunk.

    No more is expanded.  Damaged: data does not hold that many bytes, there are more than CEILING,
    or the compression is unknown.
    """
    if size > CEILING:
        raise Damaged(f'it claims to hold {size} bytes; the limit is {CEILING}')
    try:
        contents = _EXPAND[compression](data, size + 1)
    except KeyError:
        raise Damaged(f'its compression is {compression!r}; lz4 and zstd are supported') from None
    except _ERRORS as error:
        raise Damaged(f'it cannot be decompressed: {error}') from None
    if len(contents) != size:
        raise Damaged(f'it does not hold the {size} bytes that it claims')
    return contents


def decompress_begin(compression: str, data: bytes, size: int) -> bytes:
    """Return as much of the contents, `size` bytes, as is left in data that are cut off."""
    try:
        return _EXPAND[compression](data, min(size, CEILING))
    except (KeyError, *_ERRORS):
        return b''


def zstd_size(data: bytes) -> int:
    """Return the size of the contents that a zstd frame claims; Damaged: it claims none."""
    try:
        size = zstandard.get_frame_parameters(data).content_size
    except zstandard.ZstdError:
        raise Damaged('it is not compressed with zstd') from None
    if size == zstandard.CONTENTSIZE_UNKNOWN:
        raise Damaged('its zstd frame does not give the size of its contents')
    return size


_ERRORS = (zstandard.ZstdError, RuntimeError, MemoryError)
# Each expands no more bytes than it is told.
_EXPAND: dict[str, Callable[[bytes, int], bytes]] = {
    'zstd': lambda data, most: zstandard.ZstdDecompressor().stream_reader(data).read(most),
    'lz4': lambda data, most: lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=most),
    '': lambda data, most: data[:most],
}
