"""What reading a file may cost, whatever its bytes: one budget, in bytes."""

from .errors import Damaged

# A file may hold this much when it is expanded, or this many times its own size.  The most
# repetitive topic of satdyn_ros, markers of a body at rest, is 45 times the size of its file.
_LEAST, _LARGEST_RATIO = 2**29, 64

# What else takes its reader work counts as so many bytes.  A message in a chunk of its own, with
# the indexes of both, has over 200 bytes of a file, and so four times the first of these.
RECORD = _LARGEST_RATIO * 50
CHUNK = 2 * RECORD
MESSAGE = 128
# A part of the file that is damaged, or only looks like a record where one is searched for.
DAMAGE = 100_000


class Budget:
    """What a file may still cost: a small one must not keep its reader busy for hours."""

    def __init__(self, file_size: int):
        self._allowed = self._left = max(_LEAST, _LARGEST_RATIO * file_size)

    def spend(self, cost: int) -> None:
        """Subtract a cost; Damaged: it is more than is left, which stays."""
        if cost > self._left:
            raise Damaged(
                f'reading it takes more than the work of {self._allowed} bytes, the limit for a '
                'file of its size'
            )
        self._left -= cost


def objects(count: int, size: int) -> int:
    """Return what records cost that become so many objects of Python, of so many bytes."""
    return _LARGEST_RATIO * (256 * count + size)
