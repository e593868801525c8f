"""What other programs find in our bags: every message, its times and its values."""

import json
import math
import shutil
import subprocess
from fractions import Fraction
from pathlib import Path

import flights
import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.interfaces import ConnectionExtRosbag2
from rosbags.rosbag2 import Reader

from satdyn_ros.kernel import rotation
from satdyn_ros.run.topics import TOPICS

TICKS = 90
FOXGLOVE = Path(__file__).parent / 'foxglove'
COMPUTED_HERE = ('twist.twist.linear', 'wrench.torque')
INPUT = ('torque', 'rotor_command')


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    """Record all state topics for three seconds in two files."""
    scenario = flights.GYROSTAT.with_values({'record.max_duration_s': 2.0})
    return flights.record(tmp_path_factory.mktemp('foreign') / 'bag', scenario, TICKS, events=())


@pytest.fixture(scope='module')
def truth():
    """Return what the motion itself answers at every tick, by topic and field."""
    t_s = np.arange(TICKS) / 30.0
    states = flights.GYROSTAT.motion().at(t_s)
    v_b = rotation.rotate(rotation.conjugate(states.q_ib), states.v_i)
    inertia, c_b = flights.GYROSTAT.system.inertia, states.c_b
    gradient = states.orbit.gradient_at(states.orbit_s)[:, None]
    return {
        'attitude': {'quaternion': states.q_ib},
        'angular_velocity': {'velocity.angular': states.omega_bi_b},
        'imu': {'orientation': states.q_ib, 'angular_velocity': states.omega_bi_b},
        'odometry': {
            'pose.pose.position': states.r_i,
            'pose.pose.orientation': states.q_ib,
            'twist.twist.linear': v_b,
            'twist.twist.angular': states.omega_bi_b,
        },
        'attitude_lvlh': {'quaternion': states.q_lb},
        'gravity_gradient': {'wrench.torque': gradient * np.cross(c_b, c_b @ inertia)},
        'rotor': {
            'position': states.rotor_angle,
            'velocity': states.rotor_speed,
            'effort': np.zeros((TICKS, 1)),
        },
        'markers': {'markers.0.pose.position': np.zeros((TICKS, 3))},
        'tf': {'transforms.1.transform.rotation': states.q_ib},
    }


def stamps():
    """Return the ticks' stamps, rounded half to even in exact arithmetic."""
    return [flights.EPOCH_NS + round(Fraction(k * 10**9, 30)) for k in range(TICKS)]


def field(message, path):
    """Return a field of a decoded message, objects or dictionaries, as a list of numbers."""
    for part in path.split('.'):
        if part.isdigit():
            message = message[int(part)]
        else:
            message = message[part] if isinstance(message, dict) else getattr(message, part)
    try:
        return [float(number) for number in message]
    except (TypeError, ValueError):
        components = ('x', 'y', 'z', 'w')
        return [
            float(message[c] if isinstance(message, dict) else getattr(message, c))
            for c in components
            if (c in message if isinstance(message, dict) else hasattr(message, c))
        ]


def assert_complete(found, truth):
    """
    Assert that all messages were found: (topic, type, log time, publish time, decoded).

    Values have the bits of the motion, but for those computed here in another order: velocity in
    body axes and torque, which round otherwise.
    """
    assert len(found) == TICKS * len(truth)
    by_topic: dict[str, list[tuple]] = {}
    for topic, kind, log_time, publish_time, message in found:
        by_topic.setdefault(topic.removeprefix('/'), []).append((log_time, publish_time, message))
        assert kind == TOPICS[topic.removeprefix('/')].type
    assert set(by_topic) == set(truth)
    for topic, messages in by_topic.items():
        assert [log_time for log_time, _, _ in messages] == stamps()
        assert [publish_time for _, publish_time, _ in messages] == stamps()
        for path, values in truth[topic].items():
            decoded = np.array([field(message, path) for _, _, message in messages])
            size = np.max(np.abs(values)) or 1.0
            rounding = (
                8.0 * math.ulp(1.0) if path in ('twist.twist.linear', 'wrench.torque') else 0
            )
            np.testing.assert_allclose(decoded, values, rtol=0.0, atol=rounding * size)


def test_rosbags_reads_the_directory(bag, truth):
    """Its own parser of definitions, its own deserialiser, and metadata.yaml as it reads it."""
    with AnyReader([bag]) as reader:
        found = []
        for connection, log_time, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            found.append((connection.topic, connection.msgtype, log_time, log_time, message))
    assert_complete(found, truth)
    with Reader(bag) as reader:
        assert reader.message_count == len(found)
        assert reader.start_time == stamps()[0]
        assert reader.end_time - 1 == stamps()[-1]
        counts = {connection.topic: connection.msgcount for connection in reader.connections}
        hashes = {connection.topic: connection.digest for connection in reader.connections}
        extensions = [connection.ext for connection in reader.connections]
    assert counts == {f'/{name}': TICKS for name in truth} | {f'/{name}': 0 for name in INPUT}
    assert {digest[:7] for digest in hashes.values()} == {'RIHS01_'}
    for extension in extensions:
        assert isinstance(extension, ConnectionExtRosbag2)
        assert extension.offered_qos_profiles[0].reliability.name == 'RELIABLE'


def test_mcap_ros2_support_decodes_every_message(bag, truth):
    """The decoder of the MCAP project on its reader, checksums validated, file by file."""
    found = []
    for path in sorted(bag.glob('*.mcap')):
        with open(path, 'rb') as file:
            reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
            for schema, channel, message, decoded in reader.iter_decoded_messages():
                assert schema is not None
                times = message.log_time, message.publish_time
                found.append((channel.topic, schema.name, *times, decoded))
    assert_complete(found, truth)


@pytest.fixture(scope='module')
def foxglove(request):
    """Return a folder with Foxglove's reader, installed once into pytest's cache."""
    if not (shutil.which('npm') and shutil.which('node')):
        pytest.skip('Node.js and npm are not installed')
    folder = Path(request.config.cache.mkdir('foxglove'))
    for name in ('package.json', 'read.cjs'):
        shutil.copy(FOXGLOVE / name, folder)
    if not (folder / 'node_modules').exists():
        command = ['npm', 'install', '--ignore-scripts', '--no-audit', '--no-fund']
        result = subprocess.run(command, cwd=folder, capture_output=True, text=True)
        if result.returncode:
            pytest.skip(f'npm cannot install the reader: {result.stderr.strip()[-200:]}')
    return folder


def test_foxglove_reads_it_in_javascript(bag, truth, foxglove):
    """The reader and the decoder that Foxglove shows bags with, on Node.js."""
    found = []
    for path in sorted(bag.glob('*.mcap')):
        result = subprocess.run(
            ['node', foxglove / 'read.cjs', path], capture_output=True, text=True, check=True
        )
        for line in map(json.loads, result.stdout.splitlines()):
            times = int(line['log_time']), int(line['publish_time'])
            found.append((line['topic'], line['type'], *times, line['message']))
    assert_complete(found, truth)
