"""Reading bags, complete or unfinished, from satdyn_ros or another program; the run in them."""

from contextlib import closing

import flights
import numpy as np
import pytest
from mcap.records import Metadata
from mcap.writer import CompressionType, Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as RosbagsWriter
from rosbags.typesys import Stores, get_typestore

from satdyn_ros.bag.read_run import RecordedRun
from satdyn_ros.messages import schemas
from satdyn_ros.rosbag2.metadata import TopicMetadata
from satdyn_ros.rosbag2.reader import Bag, TopicBlock
from satdyn_ros.rosbag2.writer import BagWriter
from satdyn_ros.run.events import Timeout
from satdyn_ros.run.simulation import Simulation


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    return flights.record(tmp_path_factory.mktemp('reader') / 'bag')


def test_messages_are_those_that_the_mcap_library_reads(bag):
    """Topic by topic, log times and bytes; also where the topic comes and goes."""
    sequence = flights.sequence(bag)
    for topic in ('/attitude', '/imu', '/rotor', '/torque', '/markers'):
        expected = [(stamp, data) for name, stamp, data in sequence if name == topic]
        found = Bag(bag).messages(topic)
        assert found.log_times_ns.tolist() == [stamp for stamp, _ in expected]
        assert [bytes(row) for row in found.data] == [data for _, data in expected]
        assert isinstance(found.data, np.ndarray)
        assert found.data.ndim == 2
    assert len(Bag(bag).messages('/none').log_times_ns) == 0


def test_topics_are_described_as_they_were_written(bag):
    """Type, definition, hash and quality of service come back, silent topics with them."""
    topics = Bag(bag).topics
    assert list(topics) == [
        f'/{name}' for name in (*flights.TOPIC_NAMES, 'torque', 'rotor_command')
    ]
    imu = topics['/imu']
    assert (imu.name, imu.type) == ('/imu', 'sensor_msgs/msg/Imu')
    assert imu.schema == schemas.schema_text(imu.type)
    assert imu.type_hash == schemas.type_hash(imu.type)
    assert imu.qos.startswith('- history: keep_last\n  depth: 30\n')


def test_messages_of_changing_length_come_as_bytes(tmp_path):
    """Another's bag may hold strings: lengths differ from message to message."""
    texts = [b'', b'a', b'longer', b'b']
    with open(tmp_path / 'foreign.mcap', 'wb') as file:
        writer = Writer(file, 100, CompressionType.NONE)
        writer.start('ros2', 'another')
        schema = writer.register_schema('std_msgs/msg/String', 'ros2msg', b'string data')
        channel = writer.register_channel('/text', 'cdr', schema, {})
        for k, text in enumerate(texts):
            writer.add_message(channel, k, text, k)
        writer.finish()
    found = Bag(tmp_path / 'foreign.mcap').messages('/text')
    assert found.data == texts
    assert found.log_times_ns.tolist() == [0, 1, 2, 3]


@pytest.mark.parametrize('version', [8, 9])
def test_a_bag_written_by_rosbags_is_read(tmp_path, version):
    """A directory of another maker, its chunks without checksums, also of an older version."""
    store = get_typestore(Stores.ROS2_JAZZY)
    Int64 = store.types['std_msgs/msg/Int64']
    path = tmp_path / 'foreign'
    with RosbagsWriter(path, version=version, storage_plugin=StoragePlugin.MCAP) as writer:
        connection = writer.add_connection('/count', Int64.__msgtype__, typestore=store)
        for k in range(1000):
            data = store.serialize_cdr(Int64(k), Int64.__msgtype__)
            writer.write(connection, 10 * k, data)
    bag = Bag(path)
    found = bag.messages('/count')
    assert found.log_times_ns.tolist() == list(range(0, 10_000, 10))
    assert isinstance(found.data, np.ndarray)
    assert found.data[:, 4:12].copy().view('<i8')[:, 0].tolist() == list(range(1000))
    assert bag.topics['/count'].type == 'std_msgs/msg/Int64'
    assert bag.problem is None
    with pytest.raises(ValueError, match='holds no scenario: satdyn_ros did not write it'):
        RecordedRun(path)


def test_a_bag_stored_otherwise_is_refused(tmp_path):
    """The other storage of rosbag2 is named, not misread."""
    with RosbagsWriter(tmp_path / 'bag', version=9, storage_plugin=StoragePlugin.SQLITE3):
        pass
    with pytest.raises(ValueError, match='is stored as sqlite3; only mcap is supported'):
        Bag(tmp_path / 'bag')


def test_an_unfinished_bag_is_read_as_far_as_it_goes(tmp_path):
    """While its writer is still at work, too."""
    topic = TopicMetadata('/a', 'std_msgs/msg/Int8', 'int8 data', '', '')
    with closing(BagWriter(tmp_path / 'bag', [topic])) as writer:
        writer.write(np.arange(5), {'/a': np.zeros(5, 'V5')})
        writer.flush()
        bag = Bag(tmp_path / 'bag')
        assert len(bag.messages('/a').data) == 5
        assert bag.problem == f'{bag.files[0]} ends in mid-write; satdyn recover completes it'
        assert bag.topics == {'/a': topic}


def test_events_come_back_in_their_order(bag):
    """Requests, resets, timeouts and changes of topics from metadata, torques from messages."""
    run = RecordedRun(bag)
    first = flights.EVENTS[:2]
    assert run.events == [*first, Timeout(45, 'torque'), *flights.EVENTS[2:]]
    assert run.scenario == flights.GYROSTAT
    assert run.names['attitude'] == '/attitude'


def test_metadata_stands_before_what_it_affects(bag):
    """An event's record comes after all messages before its tick and before those of the tick."""
    before, period_ns = {}, 10**9 / 30
    last_ns = 0
    for item in Bag(bag).items():
        if isinstance(item, TopicBlock):
            last_ns = int(item.contents.log_times[-1])
        elif isinstance(item, Metadata) and item.name == 'satdyn_ros/event':
            before[item.metadata['event'], int(item.metadata['tick'])] = last_ns
    assert list(before) == [('Timeout', 45), ('Request', 60), ('Topics', 80), ('Reset', 100)]
    for (_, tick), last_ns in before.items():
        assert last_ns == flights.EPOCH_NS + round((tick - 1) * period_ns)


def test_an_input_is_recorded_ahead_of_its_tick(bag):
    """The torque's log time is the stamp of the tick where it acts, before the tick's samples."""
    sequence = flights.sequence(bag)
    stamp = flights.EPOCH_NS + round(20 * 10**9 / 30)
    at_tick = [topic for topic, log_time, _ in sequence if log_time == stamp]
    assert at_tick[:3] == ['/torque', '/rotor_command', '/attitude']
    first = [log_time for _, log_time, _ in sequence].index(stamp)
    assert sequence[first][0] == '/torque'


def test_a_bag_begun_in_mid_run_knows_where(tmp_path):
    """Its snapshot names the tick and leads to the bits of the run that began at tick 0."""
    scenario = flights.GYROSTAT.with_values({'record.max_duration_s': 2.0})
    path = flights.record(tmp_path / 'bag', scenario)
    whole = Simulation(scenario, flights.EVENTS)
    states = {}
    while whole.next_tick < 150:
        _, samples = whole.advance(1)
        states[samples.first_tick] = samples.states[0]
    for number, tick in ((1, 61), (2, 122)):
        run = RecordedRun(path / f'bag_{number}.mcap')
        assert run.snapshot is not None
        assert run.snapshot['tick'] == tick
        _, samples = run.simulation().advance(1)
        assert samples.first_tick == tick
        assert samples.states[0].q_ib.tolist() == states[tick].q_ib.tolist()
        assert samples.states[0].omega_bi_b.tolist() == states[tick].omega_bi_b.tolist()
        assert run.snapshot['state']['q_ib'] == states[tick].q_ib.tolist()
