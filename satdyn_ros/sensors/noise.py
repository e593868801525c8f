"""
Random numbers by tick: the noise of a tick depends on the seed, the stream and the tick alone.

Philox is a counter-based generator (Salmon, Moraes, Dror and Shaw 2011): the words of a tick are
those at its index in the stream, whatever ticks were drawn before.  Its raw words are specified;
what NumPy makes of them by `normal` may change with its version, so they become normal deviates
here, through the inverse of the normal distribution.
"""

from hashlib import sha256

import numpy as np

# Philox4x64 gives four words for each step of its counter.
_WORDS_PER_STEP = 4


# Those of version 0.2.
_STREAMS = {'gyro': 0, 'star_tracker': 1}


def stream_of(name: str) -> int:
    """
    Return the stream of a sensor's noise, from its name alone.

    >>> stream_of('gyro'), stream_of('star_tracker')
    (0, 1)
    """
    digest = sha256(name.encode()).digest()
    return _STREAMS.get(name, int.from_bytes(digest[:8], 'little'))


def slow_stream(stream: int) -> int:
    """Return the stream of the slow bias of a sensor that has this stream."""
    return stream_of(f'slow bias of {stream}')


def normals(seed: int, stream: int, ticks: range, count: int) -> np.ndarray:
    """
    Return independent standard normal deviates, shape (len(ticks), count).

    Parameters
    ----------
    seed : int
        0 to 2^64 - 1
    stream : int
        one for each sensor, so that two never share noise
    ticks : range
        evenly spaced
    count : int
        deviates of a tick

    Examples
    --------
    >>> later = normals(7, 0, range(5, 8), 3)
    >>> bool(np.all(normals(7, 0, range(0, 8), 3)[5:] == later))
    True
    """
    steps = -(-count // _WORDS_PER_STEP)
    generator = np.random.Philox(key=[seed, stream], counter=ticks.start * steps)
    span = ticks[-1] + 1 - ticks.start if ticks else 0
    words = generator.random_raw(span * steps * _WORDS_PER_STEP)
    chosen = words.reshape(span, steps * _WORDS_PER_STEP)[:: ticks.step, :count]
    # Imported here, and early by suite.py: runs without sensors start a tenth of a second sooner.
    from scipy.special import ndtri

    # The middles of 2^53 equal parts of the unit interval: neither 0 nor 1.
    return ndtri(((chosen >> np.uint64(11)) + 0.5) * 2.0**-53)
