"""Reading in a thread of its own, for a writer whose library leaves Python's lock alone."""

from collections.abc import Generator, Iterable
from concurrent.futures import ThreadPoolExecutor

from ..base.interruption import uninterrupted
from .columns import Columns


def read_ahead(blocks: Iterable[Columns]) -> Generator[Columns, None, None]:
    """Yield blocks, in order; the next one is read in a thread while the caller writes one."""
    left = iter(blocks)
    thread = ThreadPoolExecutor(max_workers=1)
    try:
        # An exception within the executor's functions could leave a lock taken, for which its
        # thread would wait for ever: interruptions act between them.
        with uninterrupted():
            reading = thread.submit(next, left, None)
        while True:
            with uninterrupted():
                block = reading.result()
                if block is None:
                    return
                reading = thread.submit(next, left, None)
            yield block
    finally:
        with uninterrupted():
            thread.shutdown()
