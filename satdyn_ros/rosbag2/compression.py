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

# What all chunks of a file may hold [bytes]: this much, or this many times the size of the file.
# The most repetitive topic of satdyn_ros, markers of a body at rest, is 45 times the size of its
# file.
_LEAST_IN_ALL, _LARGEST_RATIO = 2**29, 64

# A chunk counts as this many bytes at least, since each costs work.  The smallest message in a
# chunk, with its indexes, takes over 200 bytes of a file, which may expand to 64 times as many.
_LEAST_CHUNK = _LARGEST_RATIO * 200

# The first of the fast levels: output two to six per cent larger than at the default level, in 70
# per cent of the time.
_ZSTD_LEVEL = -1
# Rows repeat what stands a row before: a table of so few places (2^11) finds it, and stays in the
# first-level cache.  A tenth less time; output 0 to 2 per cent larger.
_ZSTD_HASH_LOG = 11

# How many messages all chunks may hold: this many, and one for each so many bytes of the file.  An
# entry of a message index has 16 bytes.
_LEAST_MESSAGES, _BYTES_PER_MESSAGE = 2**22, 4

# How many schemas and channels all chunks of a file may hold, and the most bytes of them: a
# thousand types have a few millions.
_MOST_DECLARATIONS, _MOST_DECLARED = 2**15, 8 * 2**20


class ResourceBudget:
    """What a file may still expand to: a small one must not keep its reader busy for hours."""

    def __init__(self, file_size: int):
        self._allowed = self._left = max(_LEAST_IN_ALL, _LARGEST_RATIO * file_size)
        self._most_messages = _LEAST_MESSAGES + file_size // _BYTES_PER_MESSAGE
        self._messages = self._declarations = self._declared = 0

    def spend(self, size: int) -> None:
        """Subtract what a chunk claims to hold [bytes]; Damaged: it is more than is left."""
        self._left -= max(size, _LEAST_CHUNK)
        if self._left < 0:
            raise Damaged(
                f'with it the chunks claim to hold more than {self._allowed} bytes, the limit for '
                'a file of this size'
            )

    def hold(self, count: int) -> None:
        """Count the messages of a chunk; Damaged: too many."""
        self._messages += count
        if self._messages > self._most_messages:
            raise Damaged(
                f'with it the chunks hold more than {self._most_messages} messages, the limit for '
                'a file of this size'
            )

    def declare(self, count: int, size: int) -> None:
        """Count the schemas and channels of a chunk and their bytes; Damaged: too many."""
        self._declarations += count
        self._declared += size
        if self._declarations > _MOST_DECLARATIONS or self._declared > _MOST_DECLARED:
            raise Damaged(
                f'with it the chunks hold more than {_MOST_DECLARATIONS} schemas and channels, or '
                f'{_MOST_DECLARED} bytes of them'
            )


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


def decompress(compression: str, data: bytes, size: int, ceiling: int = CEILING) -> bytes:
    """
    Return the contents, `size` bytes, of compressed data, by the name in a chunk.

    No more than size and ceiling [bytes] are expanded.  Damaged: data does not hold that many
    bytes, or the compression is unknown.
    """
    if size > ceiling:
        raise Damaged(f'it claims to hold {size} bytes; the limit is {ceiling}')
    try:
        contents = _DECOMPRESS[compression](data, size)
    except KeyError:
        raise Damaged(f'its compression is {compression!r}; lz4 and zstd are supported') from None
    except (zstandard.ZstdError, RuntimeError, MemoryError) as error:
        raise Damaged(f'it cannot be decompressed: {error}') from None
    if len(contents) != size:
        raise Damaged(f'it does not hold the {size} bytes that it claims')
    return contents


def decompress_begin(compression: str, data: bytes, ceiling: int = CEILING) -> bytes:
    """Return as much of the contents as can be recovered from data that is cut off."""
    try:
        if compression == 'zstd':
            return zstandard.ZstdDecompressor().stream_reader(data).read(ceiling)
        if compression == 'lz4':
            return lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=ceiling)
    except (zstandard.ZstdError, RuntimeError, MemoryError):
        return b''
    return data[:ceiling] if compression == '' else b''


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
