"""Compression of chunk contents, and decompression within memory limits."""

import threading
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
# Rows repeat what stands a row before: a table of so few slots (2^11) finds it, and stays in the
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
        contents = _DECOMPRESS[compression](data, size)
    except KeyError:
        raise Damaged(f'its compression is {compression!r}; lz4 and zstd are supported') from None
    except (zstandard.ZstdError, RuntimeError, MemoryError) as error:
        raise Damaged(f'it cannot be decompressed: {error}') from None
    if len(contents) != size:
        raise Damaged(f'it does not hold the {size} bytes that it claims')
    return contents


def zstd_size(data: bytes) -> int:
    """Return the size of the contents that a zstd frame claims; Damaged: it claims none."""
    try:
        size = zstandard.get_frame_parameters(data).content_size
    except zstandard.ZstdError:
        raise Damaged('it is not compressed with zstd') from None
    if size == zstandard.CONTENTSIZE_UNKNOWN:
        raise Damaged('its zstd frame does not give the size of its contents')
    return size


class _PerThread(threading.local):
    def __init__(self):
        # To make one takes ten times as long as decompressing a message.
        self.zstd = zstandard.ZstdDecompressor()


_PER_THREAD = _PerThread()


def _decompress_zstd(data, size):
    # Where a frame gives its size, zstandard uses that and not max_output_size.
    claimed = zstandard.get_frame_parameters(data).content_size
    if claimed not in (size, zstandard.CONTENTSIZE_UNKNOWN):
        raise Damaged(f'its zstd frame holds {claimed} bytes, not {size}')
    return _PER_THREAD.zstd.decompress(data, max_output_size=size)


def _decompress_lz4(data, size):
    return lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=size + 1)


_DECOMPRESS = {'zstd': _decompress_zstd, 'lz4': _decompress_lz4, '': lambda data, size: data}
