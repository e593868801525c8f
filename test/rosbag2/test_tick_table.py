"""A table of ticks holds records that mcap's own parser reads."""

import io

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Message

from satdyn_ros.rosbag2.tick_table import TickTable

STAMPS_NS = 10**18 + 7 * np.arange(3)
EACH = np.array([b'one', b'two', b'six'], 'V3')
SAME = np.array([b'same!'], 'V5')


def read(table):
    """Return the messages of a table, parsed by mcap."""
    data = table.records.tobytes()
    stream, messages = ReadDataStream(io.BytesIO(data)), []
    while stream.count < len(data):
        assert stream.read1() == Opcode.MESSAGE
        messages.append(Message.read(stream, stream.read8()))
    return messages


def test_rows_are_records():
    """Each tick's messages follow each other, with its stamp."""
    table = TickTable.of(3, {4: EACH, 2: SAME})
    table.stamp(STAMPS_NS)
    messages = read(table)
    assert [message.channel_id for message in messages] == [4, 2] * 3
    assert [message.log_time for message in messages] == np.repeat(STAMPS_NS, 2).tolist()
    assert [message.publish_time for message in messages] == np.repeat(STAMPS_NS, 2).tolist()
    assert {message.sequence for message in messages} == {0}
    data = [message.data for message in messages]
    assert data == [b'one', b'same!', b'two', b'same!', b'six', b'same!']


def test_messages_are_written_in_place():
    """What is written to a slice is in the table."""
    table = TickTable.of(3, {1: EACH, 2: SAME})
    table[1:].messages(1)[:] = np.array([b'new', b'few'], 'V3')
    table.stamp(STAMPS_NS)
    assert [message.data for message in read(table)[::2]] == [b'one', b'new', b'few']
    assert len(table) == 3
    assert len(table[1:]) == 2
