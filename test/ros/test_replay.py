"""A bag's topics published again: what a subscriber hears is what the bag holds."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest
from flights import sequence
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from ros.live import ENVIRONMENT, PATIENCE_S, Participant
from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String

from satdyn_ros.bag.playback import offered
from satdyn_ros.bag.simulate import simulate
from satdyn_ros.ros.publishing import message_class
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.topics import TOPICS

NAMES = ('attitude', 'imu', 'odometry')


@pytest.fixture
def listener():
    """Return a participant in the namespace where replayed topics are, the root."""
    participant = Participant('/')
    yield participant
    participant.close()


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    """Return a bag of 2 s of three topics at 50 Hz."""
    directory = tmp_path_factory.mktemp('replay') / 'bag'
    scenario = Scenario({'publish.rate': 50.0, 'publish.topics': NAMES, 'time.epoch_ns': 10**18})
    for _ in simulate(scenario, 2, directory):
        pass
    return directory


def replay(*arguments):
    """Start the command `satdyn replay`."""
    return subprocess.Popen(
        [sys.executable, '-m', 'satdyn_ros.cli.main', 'replay', *map(str, arguments)],
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def ended(process, number=None):
    """Return the exit code and what was said, after a signal if wanted."""
    if number is not None:
        process.send_signal(number)
    said, errors = process.communicate(timeout=PATIENCE_S)
    return process.returncode, said, errors


def hear(listener, heard, kind, topic, qos):
    """Fill a list with (topic, data) from a topic."""
    listener.node.create_subscription(
        kind, topic, lambda data: heard.append((topic, data)), qos, raw=True
    )


def hear_all(listener):
    heard: list[tuple[str, bytes]] = []
    for name in NAMES:
        hear(listener, heard, message_class(TOPICS[name].type), f'/{name}', QoSProfile(depth=1000))
    return heard


def test_every_message_comes_as_it_is(bag, listener):
    """The bytes on the wire are those in the bag, each topic in its order."""
    heard = hear_all(listener)
    process = replay(bag, '--wait', '--rate', 4)
    listener.wait_until(lambda: len(heard) == 300, '300 messages')
    assert ended(process) == (0, f'{bag}: 300 messages\n', '')
    for name in NAMES:
        recorded = [data for topic, _, data in sequence(bag) if topic == f'/{name}']
        assert [data for topic, data in heard if topic == f'/{name}'] == recorded


@pytest.mark.long
def test_the_clock_is_that_of_the_bag(bag, listener):
    """With --clock, /clock shows log times of the bag, ascending; an offset begins later."""
    times = []
    listener.node.create_subscription(
        Clock,
        '/clock',
        lambda m: times.append(m.clock.sec * 10**9 + m.clock.nanosec),
        QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT),
    )
    heard = hear_all(listener)
    process = replay(bag, '--clock', '--wait', '--start-offset', 1.5)
    code, said, _ = ended(process)
    assert code == 0
    assert said.endswith(f'{bag}: 75 messages\n')
    listener.wait_until(lambda: len(heard) == 75, 'the last half second')
    log_times = sorted({log_time_ns for _, log_time_ns, _ in sequence(bag)})
    assert times == sorted(set(times))
    assert times
    assert set(times) <= set(log_times[75:])


@pytest.mark.long
def test_a_loop_goes_on_until_ctrl_c(bag, listener):
    """With --loop the bag begins anew, and Ctrl-C ends it quietly."""
    heard = hear_all(listener)
    process = replay(bag, '--loop', '--rate', 10)
    first = next(data for topic, _, data in sequence(bag) if topic == '/imu')
    listener.wait_until(lambda: heard.count(('/imu', first)) >= 2, 'a second round')
    assert ended(process, signal.SIGINT) == (130, '', '')


def test_the_next_message_may_be_centuries_away(bag, listener):
    """A rate may be as small as a number can be; Ctrl-C ends that quietly too."""
    heard = hear_all(listener)
    process = replay(bag, '--wait', '--rate', 1e-300)
    listener.wait_until(lambda: heard, 'the first message')
    with pytest.raises(subprocess.TimeoutExpired):
        process.wait(timeout=3.0)
    assert ended(process, signal.SIGINT)[2] == ''


@pytest.mark.long
@pytest.mark.parametrize(
    ('arguments', 'sentence'),
    [
        (['--rate', 0], '--rate is 0; it must be a number above 0'),
        (['--rate', 'nan'], '--rate is nan'),
        (['--start-offset', 2], '--start-offset is 2; it must be 0 to 1.98 s'),
    ],
)
def test_refused(bag, arguments, sentence):
    """What cannot be played is said in one sentence, with exit code 2."""
    code, said, errors = ended(replay(bag, *arguments))
    assert (code, said) == (2, '')
    assert sentence in errors
    assert errors.count('\n') == 1


def test_a_bag_that_is_not_complete_is_refused(bag, tmp_path):
    """A killed writer's file is not played in part: recover completes it."""
    (tmp_path / 'cut_0.mcap').write_bytes((bag / 'bag_0.mcap').read_bytes()[:-1000])
    code, _, errors = ended(replay(tmp_path))
    assert code == 2
    assert 'is not complete; satdyn recover completes it' in errors


def profile(reliability, durability):
    """Return a profile as ros2 bag record finds it: history unknown, no deadlines."""
    forever = QosTime(9223372036, 854775807)
    return Qos(
        QosHistory.UNKNOWN,
        0,
        QosReliability[reliability],
        QosDurability[durability],
        forever,
        forever,
        QosLiveliness.AUTOMATIC,
        forever,
        False,
    )


def foreign(path: Path) -> Path:
    """Write a bag with another program: a latched text, a sensor's stream, an unknown type."""
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg('uint8 value', 'nobody_msgs/msg/Thing'))
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:

        def channel(topic, kind, reliability, durability):
            return writer.add_connection(
                topic,
                kind,
                typestore=store,
                offered_qos_profiles=[profile(reliability, durability)],
            )

        latched = channel('/description', 'std_msgs/msg/String', 'RELIABLE', 'TRANSIENT_LOCAL')
        sensor = channel('/sensor', 'std_msgs/msg/String', 'BEST_EFFORT', 'VOLATILE')
        thing = channel('/thing', 'nobody_msgs/msg/Thing', 'RELIABLE', 'VOLATILE')
        text, unknown = store.types['std_msgs/msg/String'], store.types['nobody_msgs/msg/Thing']
        for k in range(20):
            data = store.serialize_cdr(text(data=f'reading {k}'), 'std_msgs/msg/String')
            writer.write(sensor, 10**9 + k * 10**7, data)
            writer.write(thing, 10**9 + k * 10**7, store.serialize_cdr(unknown(k), thing.msgtype))
        data = store.serialize_cdr(text(data='a satellite'), 'std_msgs/msg/String')
        writer.write(latched, 10**9, data)
    return path


@pytest.mark.long
def test_a_foreign_bag_is_played(tmp_path, listener):
    """
    Its topics have their quality of service and come in the order of time.

    A late subscriber gets the latched text; a type that is not installed is left out and named.
    """
    path = foreign(tmp_path / 'foreign')
    heard: list[tuple[str, bytes]] = []
    best_effort = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
    hear(listener, heard, String, '/sensor', best_effort)
    process = replay(path, '--wait', '--loop')
    listener.wait_until(lambda: len(heard) >= 20, 'the readings')
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    hear(listener, heard, String, '/description', latched)
    listener.wait_until(lambda: heard[-1][0] == '/description', 'the latched text')
    by_topic = listener.node.get_publishers_info_by_topic
    assert by_topic('/sensor')[0].qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT
    assert by_topic('/description')[0].qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
    code, _, errors = ended(process, signal.SIGINT)
    assert code == 130
    assert errors == '/thing is left out: nobody_msgs/msg/Thing is not installed\n'
    assert b'a satellite' in heard[-1][1]


@pytest.mark.parametrize(
    ('text', 'reliability', 'durability', 'depth'),
    [
        ('', 'reliable', 'volatile', 10),
        ('[]', 'reliable', 'volatile', 10),
        ('- {depth: 50, reliability: reliable, durability: volatile}', 'reliable', 'volatile', 50),
        ('- {depth: 1, reliability: 2, durability: 2}', 'best_effort', 'volatile', 10),
        ('- {depth: 0, reliability: 1, durability: 1}', 'reliable', 'transient_local', 10),
        (
            '- {depth: 1, reliability: reliable, durability: transient_local}\n'
            '- {depth: 1, reliability: best_effort, durability: volatile}',
            'best_effort',
            'volatile',
            10,
        ),
    ],
)
def test_offered_profiles(text, reliability, durability, depth):
    """Words and rmw's numbers are read; of several publishers the least is offered."""
    found = offered(text)
    assert (found.reliability, found.durability, found.depth) == (reliability, durability, depth)
