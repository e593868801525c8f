"""Blocks that are read while others are written."""

import threading

import numpy as np
import pytest

from satdyn_ros.bag.columns import Columns
from satdyn_ros.bag.table_files import read_ahead


def block(tick: int) -> Columns:
    """Return a block of one row."""
    return {'tick': np.array([tick])}


def test_the_next_block_is_read_while_one_is_written():
    """The reader waits for nobody before it begins with the next block."""
    begun = threading.Event()

    def blocks():
        yield block(0)
        begun.set()
        yield block(1)

    written = []
    for rows in read_ahead(blocks()):
        assert begun.wait(60.0)
        written += rows['tick'].tolist()
    assert written == [0, 1]


def test_no_more_than_one_block_is_read_ahead():
    """Memory does not grow where writing is slower than reading."""
    read = -1

    def blocks():
        nonlocal read
        for tick in range(100):
            read = tick
            yield block(tick)

    for written, rows in enumerate(read_ahead(blocks())):
        assert rows['tick'] == written
        assert read <= written + 1


def test_what_reading_raises_comes_after_the_blocks_before_it():
    """A damaged bag gives what can be read, and then its sentence."""

    def blocks():
        yield block(0)
        raise ValueError('the bag is damaged')

    left = read_ahead(blocks())
    assert next(left)['tick'] == 0
    with pytest.raises(ValueError, match='the bag is damaged'):
        next(left)


def test_a_writer_that_stops_leaves_no_thread():
    """The thread ends where the writer does, such as on a full disk."""
    before = set(threading.enumerate())
    left = read_ahead(block(tick) for tick in range(100))
    assert next(left)['tick'] == 0
    begun = set(threading.enumerate()) - before
    assert len(begun) == 1
    left.close()
    assert not begun & set(threading.enumerate())
