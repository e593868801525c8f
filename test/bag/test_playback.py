"""Bags of other makers are played as they were recorded, or refused in a correct sentence."""

import random
import struct

import flights
import pytest
from mcap.reader import make_reader
from mcap.records import Chunk
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, Writer
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as RosbagsWriter
from rosbags.typesys import Stores, get_typestore

from satdyn_ros.bag.playback import Playback
from satdyn_ros.bag.read_run import RecordedRun
from satdyn_ros.rosbag2.errors import BagError, Damaged
from satdyn_ros.rosbag2.reader import Bag
from satdyn_ros.rosbag2.recover import recover
from satdyn_ros.rosbag2.scan import scan


def played(path, from_ns=0):
    """Return what is played of all topics, as (log time, topic, bytes)."""
    bag = Playback(path)
    return [tuple(message) for message in bag.messages(list(bag.types), from_ns)]


def compressed(path, mode):
    """Write a bag with the rosbags library as rosbag2 compresses; return its messages."""
    store = get_typestore(Stores.ROS2_JAZZY)
    Int64 = store.types['std_msgs/msg/Int64']
    writer = RosbagsWriter(path, version=9, storage_plugin=StoragePlugin.MCAP)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    messages = []
    with writer:
        connection = writer.add_connection('/n', Int64.__msgtype__, typestore=store)
        for k in range(100):
            data = bytes(store.serialize_cdr(Int64(k), Int64.__msgtype__))
            writer.write(connection, 10 * k, data)
            messages.append((10 * k, '/n', data))
    return messages


def test_messages_that_rosbag2_compressed_are_played(tmp_path):
    """compression_mode MESSAGE: each message is a zstd frame of its own."""
    messages = compressed(tmp_path / 'bag', CompressionMode.MESSAGE)
    assert played(tmp_path / 'bag') == messages
    with pytest.raises(BagError, match='holds no scenario: satdyn_ros did not write it'):
        RecordedRun(tmp_path / 'bag')
    with pytest.raises(BagError, match='which recover does not keep'):
        recover(tmp_path / 'bag')


def test_files_that_rosbag2_compressed_are_refused(tmp_path):
    """compression_mode FILE: the sentence says what it is, and what helps."""
    compressed(tmp_path / 'bag', CompressionMode.FILE)
    for read in (Playback, Bag, RecordedRun, recover):
        with pytest.raises(BagError, match=r'by rosbag2 .* ros2 bag convert decompresses it'):
            read(tmp_path / 'bag')


def test_another_compression_of_messages_is_refused(tmp_path):
    """A plugin of rosbag2 may compress otherwise."""
    compressed(tmp_path / 'bag', CompressionMode.MESSAGE)
    path = tmp_path / 'bag/metadata.yaml'
    path.write_text(path.read_text().replace('compression_format: zstd', 'compression_format: x'))
    with pytest.raises(BagError, match='compression_mode message, compression_format x'):
        Playback(tmp_path / 'bag')


@pytest.mark.parametrize('use_chunking', [True, False])
def test_messages_come_in_the_order_of_their_times(tmp_path, use_chunking):
    """Whatever their order in the file; the mcap library's reader gives the same."""
    path = tmp_path / 'foreign.mcap'
    draw = random.Random(5)
    with open(path, 'wb') as file:
        writer = Writer(file, 500, CompressionType.LZ4, use_chunking=use_chunking)
        writer.start('ros2', 'another')
        schema = writer.register_schema('std_msgs/msg/Int8', 'ros2msg', b'int8 data')
        channels = [writer.register_channel(name, 'cdr', schema, {}) for name in ('/a', '/b')]
        times = [max(0, k + draw.randrange(-30, 30)) for k in range(400)]
        for k, time in enumerate(times):
            writer.add_message(channels[k % 2], time, struct.pack('<I', k), time)
        writer.finish()
    found = played(path, from_ns=100)
    assert [time for time, _, _ in found] == sorted(time for time in times if time >= 100)
    with open(path, 'rb') as file:
        wanted = make_reader(file).iter_messages(starting_at=100)
        assert sorted(found) == sorted((m.log_time, c.topic, m.data) for _, c, m in wanted)


def test_our_bags_are_played_in_their_own_order(tmp_path):
    """At one log time too: inputs ahead of samples, topic after topic, file after file."""
    scenario = flights.GYROSTAT.with_values({'record.max_duration_s': 2.0})
    path = flights.record(tmp_path / 'bag', scenario)
    wanted = [(time, topic, data) for topic, time, data in flights.sequence(path)]
    assert played(path) == wanted


def test_an_index_that_points_elsewhere_ends_at_once(tmp_path):
    """A summary that is sound in its checksum may still lie."""
    path = flights.record(tmp_path / 'bag', ticks=20, events=()) / 'bag_0.mcap'
    chunk = next(r for r in StreamReader(str(path), emit_chunks=True).records if type(r) is Chunk)
    data = path.read_bytes()
    (index,) = flights.summary(path).chunk_indexes
    offset = struct.pack('<Q', index.chunk_start_offset)
    for lie in (0, 8, len(data) - 5, 2**63, 2**64 - 1):
        # Without a checksum of the summary: 0 is none.
        forged = data.replace(offset, struct.pack('<Q', lie))[:-12] + bytes(4) + data[-8:]
        path.write_bytes(forged)
        with pytest.raises(Damaged, match='is not where the summary places it'):
            played(path)
    assert chunk.data in data


def test_a_chunk_that_is_listed_twice_is_played_once(tmp_path):
    """The summary may list it a thousand times as well."""
    path = flights.record(tmp_path / 'bag', ticks=20, events=()) / 'bag_0.mcap'
    (index,) = flights.summary(path).chunk_indexes
    file = flights.rewritten([found.item for found in scan(path)], tmp_path / 'twice.mcap')
    file.summary.chunk_indexes.append(index)
    file.finish()
    assert played(file.path) == played(path)


def test_an_unfinished_bag_is_refused_with_what_helps(tmp_path):
    """Playing takes an index."""
    path = flights.record(tmp_path / 'bag', ticks=20, events=()) / 'bag_0.mcap'
    path.write_bytes(path.read_bytes()[:-40])
    with pytest.raises(BagError, match='is not complete; satdyn recover completes it'):
        Playback(path)
