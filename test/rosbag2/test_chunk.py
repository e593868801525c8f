"""The messages of a chunk, however many channels they are on."""

import numpy as np
import pytest
from mcap.records import Message

from satdyn_ros.rosbag2.chunk import Contents
from satdyn_ros.rosbag2.records import written

LENGTH = 31 + 4


@pytest.mark.parametrize(
    'channel_ids',
    [
        [],
        [65535],
        [3, 1, 1, 3, 0, 3],
        # As many channels as there are: nothing may take its time for each of them.
        [*range(65536), *reversed(range(65536))],
    ],
    ids=['none', 'the last', 'a few', 'all'],
)
def test_messages_are_found_by_their_channels(channel_ids):
    """In their order, with their log times and where they begin."""
    messages = [
        Message(channel_id, 10 * index, bytes(4), publish_time=0, sequence=0)
        for index, channel_id in enumerate(channel_ids)
    ]
    contents = Contents(np.frombuffer(written(messages), np.uint8))
    expected: dict[int, list[int]] = {i: [] for i in sorted(channel_ids)}
    for index, channel_id in enumerate(channel_ids):
        expected[channel_id].append(index)
    assert {i: indices.tolist() for i, indices in contents.indices.items()} == expected
    assert contents.counts == {i: len(indices) for i, indices in expected.items()}
    assert contents.span_ns == (0, max(0, 10 * (len(messages) - 1)))
    for channel_id, indices in list(expected.items())[:100]:
        rows = [[10 * i, LENGTH * i] for i in indices]
        assert contents.index_of(channel_id).tolist() == rows
