import numpy as np
from messages import examples
from messages.readers import TYPESTORE, plain
from messages.test_examples import assert_alike

from satdyn_ros.base.sparse import SparseMessages
from satdyn_ros.messages.contents import message
from satdyn_ros.messages.packers import pack_tf_static, packer
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import Simulation
from satdyn_ros.run.topics import TOPICS

SCENARIO = Scenario(
    {
        'time.epoch_ns': 3 * 10**9,
        'sensors.names': ['gyro', 'star_tracker'],
        'sensors.seed': 1,
        'sensors.gyro.frame_id': 'gyro',
        'sensors.gyro.noise_density': 1e-4,
        'sensors.gyro.resolution': 1e-6,
        'sensors.star_tracker.cross_boresight': 2e-5,
        'sensors.star_tracker.roll': 2e-4,
        'sensors.star_tracker.divisor': 10,
        'sensors.star_tracker.latency': 3,
    }
)


def messages(name, count=40):
    """Return indices and messages, read by another's program, of the first ticks of a sensor."""
    _, samples = Simulation(SCENARIO).advance(count)
    packed = packer(name, SCENARIO).pack(samples)
    if isinstance(packed, SparseMessages):
        indices, rows = packed.indices, packed.rows
    else:
        indices, rows = np.arange(count), packed
    read = [TYPESTORE.deserialize_cdr(row.tobytes(), TOPICS[name].type) for row in rows]
    return samples, indices, [plain(message) for message in read]


def test_a_gyro_says_what_it_measures_and_how_well():
    """Stamp, frame, rate, variance N^2 / dt + resolution^2 / 12, and what it does not measure."""
    samples, indices, read = messages('gyro')
    assert indices.tolist() == list(range(40))
    message = read[7]
    assert message['header'] == {'stamp': {'sec': 3, 'nanosec': 70_000_000}, 'frame_id': 'gyro'}
    assert (
        list(message['angular_velocity'].values()) == samples.measured['gyro'].values[7].tolist()
    )
    variance = 1e-8 / 0.01 + 1e-12 / 12.0
    assert message['angular_velocity_covariance'] == [
        variance,
        0,
        0,
        0,
        variance,
        0,
        0,
        0,
        variance,
    ]
    assert message['orientation_covariance'][0] == -1.0
    assert message['linear_acceleration_covariance'][0] == -1.0


def test_a_star_tracker_says_when_it_looked():
    """Published three ticks after the exposure that its stamp names, with its variances."""
    samples, indices, read = messages('star_tracker')
    assert indices.tolist() == [3, 13, 23, 33]
    stamps = [message['header']['stamp']['nanosec'] for message in read]
    assert stamps == [0, 100_000_000, 200_000_000, 300_000_000]
    assert read[0]['orientation_covariance'] == [2e-5**2, 0, 0, 0, 2e-5**2, 0, 0, 0, 2e-4**2]
    assert read[0]['angular_velocity_covariance'][0] == -1.0
    q = np.array(list(read[2]['orientation'].values()))
    assert abs(abs(q @ samples.states.q_ib[20]) - 1.0) < 1e-6


def test_the_examples_say_what_the_node_says():
    """Frames, lengths and which fields are not zero are those of a real message."""
    for name in ('gyro', 'star_tracker'):
        example = examples.load(examples.ROOT / 'topics' / f'{name}.yaml')
        assert_alike(example.values, messages(name)[2][1])
    mounting = (-np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5))
    scenario = SCENARIO.with_values({'sensors.star_tracker.mounting': mounting})
    data = pack_tf_static(scenario)
    example = examples.load(examples.ROOT / 'topics' / 'tf_static.yaml')
    assert_alike(example.values, plain(TYPESTORE.deserialize_cdr(data, TOPICS['tf_static'].type)))


def test_the_mountings_are_static_transforms_from_the_body():
    """One for each sensor, as another program reads them; /tf, at every tick, has none of them."""
    mounting = (0.0, 0.6, 0.0, 0.8)
    scenario = SCENARIO.with_values({'sensors.star_tracker.mounting': mounting})
    data = pack_tf_static(scenario)
    gyro, tracker = plain(TYPESTORE.deserialize_cdr(data, TOPICS['tf_static'].type))['transforms']
    for transform, name in ((gyro, 'gyro'), (tracker, 'star_tracker')):
        stamp = {'sec': 3, 'nanosec': 0}
        assert transform['header'] == {'stamp': stamp, 'frame_id': 'base_link'}
        assert transform['child_frame_id'] == name
        assert list(transform['transform']['translation'].values()) == [0.0, 0.0, 0.0]
    assert list(tracker['transform']['rotation'].values()) == list(mounting)
    assert list(gyro['transform']['rotation'].values()) == [0.0, 0.0, 0.0, 1.0]
    _, samples = Simulation(scenario).advance(1)
    (row,) = message(TOPICS['tf'], scenario.frames, scenario.system).pack(samples)
    read = plain(TYPESTORE.deserialize_cdr(row.tobytes(), TOPICS['tf'].type))['transforms']
    assert [transform['child_frame_id'] for transform in read] == ['lvlh', 'base_link']
