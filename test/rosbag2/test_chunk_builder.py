"""What is put into a chunk is what a reader finds in it."""

from collections import Counter

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from mcap.records import Channel, Schema

from satdyn_ros.base.sparse import SparseMessages
from satdyn_ros.rosbag2.chunk import CHUNK_SIZE, Contents
from satdyn_ros.rosbag2.chunk_builder import ChunkBuilder
from satdyn_ros.rosbag2.tick_table import TickTable

SCHEMA = Schema(1, b'float64 data', 'ros2msg', 'std_msgs/msg/Float64')


def rows(count, length, seed):
    """Return messages of a length, their bytes at random."""
    data = np.random.default_rng(seed).integers(0, 256, count * length, np.uint8)
    return data.view(f'V{length}')


def read(chunk):
    """Take a chunk; return the number of its messages by channel, all of them whole."""
    data = chunk.take()
    contents = Contents(data)
    assert len(contents.data) == len(data)
    assert len(contents.declarations[1]) <= 9
    return Counter(contents.counts)


@st.composite
def steps(draw):
    """Draw what is added to chunks: declarations, single messages, ticks with topics at some."""
    kind = draw(st.sampled_from(['declaration', 'message', 'ticks']))
    if kind != 'ticks':
        return kind, draw(st.integers(1, 9))
    count = draw(st.sampled_from([1, 7, 300, 5000]))
    full = draw(st.dictionaries(st.integers(1, 3), st.sampled_from([4, 68, 324]), max_size=3))
    some = draw(st.dictionaries(st.integers(4, 5), st.integers(1, 4), max_size=2))
    return kind, (count, full, some)


@given(st.lists(steps(), max_size=6))
def test_what_is_added_is_read(added):
    """Whatever is added, in whatever order, chunk by chunk."""
    chunk, stamp_ns = ChunkBuilder(), 10**18
    expected: Counter[int] = Counter()
    found: Counter[int] = Counter()
    for kind, what in added:
        if kind == 'declaration':
            chunk.add(SCHEMA)
            chunk.add(Channel(what, f'/topic_{what}', 'cdr', {}, 1))
        elif kind == 'message':
            chunk.add_message(what, stamp_ns, bytes(what))
            expected[what] += 1
        else:
            count, full, some = what
            stamps_ns = stamp_ns + 1000 * np.arange(count)
            stamp_ns = int(stamps_ns[-1])
            messages = {i: rows(count, length, i) for i, length in full.items()}
            table, between = TickTable.of(count, messages), {}
            table.stamp(stamps_ns)
            for i, every in some.items():
                indices = np.arange(0, count, every)
                between[i] = SparseMessages(indices, rows(len(indices), 16, i))
            expected.update(dict.fromkeys(full, count))
            expected.update({i: len(each.rows) for i, each in between.items()})
            done = 0
            while (full or some) and done < count:
                rest = {i: each[done:] for i, each in between.items()}
                done += chunk.add_ticks(stamps_ns[done:], table[done:], rest)
                if chunk.is_full:
                    found += read(chunk)
    assert found + read(chunk) == expected


def test_a_full_chunk_has_its_size():
    """Ticks are added until the contents reach the size of a chunk, and no more."""
    chunk = ChunkBuilder()
    table = TickTable.of(10**5, {1: rows(10**5, 100, 1)})
    done = chunk.add_ticks(np.arange(10**5), table)
    size = len(chunk.take())
    assert CHUNK_SIZE <= size < CHUNK_SIZE + 131
    assert size == 131 * done


def test_whole_ticks_end_with_a_full_chunk():
    """As many ticks as are named fill the chunk that was begun, and further ones, exactly."""
    chunk, table = ChunkBuilder(), TickTable.of(10**4, {1: rows(10**4, 300, 1)})
    assert chunk.whole(table[:10]) == 10
    chunk.add(SCHEMA)
    chunk.add_ticks(np.arange(7), table[:7])
    ticks, done, chunks = chunk.whole(table), 0, 0
    while done < ticks:
        done += chunk.add_ticks(np.arange(done, ticks), table[done:])
        if chunk.is_full:
            chunk.take()
            chunks += 1
    assert chunk.is_empty
    assert chunks > 1
