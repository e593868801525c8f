"""The messages and requests of msg_examples/, sent to a node that flies."""

import shutil
import subprocess

import pytest
from messages import examples
from rclpy.serialization import deserialize_message, serialize_message
from ros.live import EPOCH_NS, PATIENCE_S, stamp_ns

from satdyn_ros.run.topics import TOPICS

MOTOR = {'rotor.mode': 'motor', 'rotor.inertia': 2.0, 'rotor.axis': [0.0, 0.0, 1.0]}


def send(participant, name):
    """Call the service that an example is made for and return its answer."""
    example = examples.load(examples.ROOT / 'services' / f'{name}.yaml')
    kind = examples.interface(example.type)
    request = examples.filled(kind.Request(), example.values)
    return participant.call(kind, example.name.lstrip('/'), request)


def test_the_requests_are_answered_and_done(live, tmp_path):
    """Each service does with its example what the example says."""
    _, participant = live({'publish.topics': ['attitude', 'attitude_lvlh']})
    heard = participant.listen('attitude_lvlh')
    participant.hear(heard, 5)
    assert send(participant, 'record').message.startswith('recording ')
    assert len(list(tmp_path.glob('satdyn_*_*/*_0.mcap'))) == 1

    asked = participant.get('initial.attitude')
    assert send(participant, 'set_initial_conditions').result.successful
    assert participant.get('initial.attitude') != asked
    asked = participant.get('initial.attitude')

    assert send(participant, 'pause').message.startswith('paused')
    assert send(participant, 'reset').success
    before = len(heard)
    answer = send(participant, 'step')
    assert answer.success
    tick = int(answer.message.removeprefix('now after tick '))
    participant.wait_until(lambda: stamp_ns(heard[-1]) == EPOCH_NS + tick * 10**7)
    assert len(heard) > before
    q = heard[-1].quaternion
    # Into the inertial frame and back, to rounding.
    assert [q.x, q.y, q.z, q.w] == pytest.approx(asked, abs=1e-15)


def test_the_inputs_act(live):
    """The example torques turn the body and the rotor from a tick on; the dipole is reported."""
    _, participant = live(
        MOTOR
        | {'publish.topics': ['angular_velocity', 'rotor', 'thruster'], 'torque.timeout': 0.0}
        | {'orbit.type': 'fixed', 'magnetorquer.max_dipole': [0.2, 0.2, 0.2]}
        | {'thruster.names': ['pp', 'mm'], 'thruster.pp.thrust': 1.0}
        | {'thruster.pp.specific_impulse': 60.0}
    )
    rates, rotors = participant.listen('angular_velocity'), participant.listen('rotor')
    reports, thrusters = participant.listen('diagnostics'), participant.listen('thruster')
    participant.hear(rates, 5)
    given = examples.load(examples.ROOT / 'topics' / 'rotor_command.yaml').values['effort'][0]
    acts = {
        'torque': lambda: rates[-1].velocity.angular.z != rates[0].velocity.angular.z,
        'rotor_command': lambda: rotors[-1].effort[0] == given,
        'thruster_command': lambda: thrusters[-1].position[0] > 0.0,
        'magnetorquer_command': lambda: any(
            (pair.key, pair.value) == ('dipole that acts [A m^2]', '(0.0, 0.0, 0.1)')
            for report in reports
            for status in report.status
            for pair in status.values
        ),
    }
    for name, acts_now in acts.items():
        example = examples.load(examples.ROOT / 'topics' / f'{name}.yaml')
        kind = examples.interface(example.type)
        publisher = participant.node.create_publisher(kind, example.name.lstrip('/'), 10)
        assert not acts_now()

        def published_acts(publisher=publisher, kind=kind, example=example, acts_now=acts_now):
            # The node may not have found the publisher that has found it: the first may be lost.
            publisher.publish(examples.filled(kind(), example.values))
            participant.hear(rates, 5)
            return acts_now()

        participant.wait_until(published_acts, f'what {name} does')
    assert rotors[0].effort[0] == 0.0


@pytest.mark.parametrize(
    'name',
    # tf2_msgs is not where these tests run.
    [n for n, t in TOPICS.items() if t.role != 'input' and t.type != 'tf2_msgs/msg/TFMessage'],
)
def test_the_outputs_are_messages_that_arrive(name, live_pair):
    """What is published from an example is received field by field."""
    sender, receiver = live_pair
    example = examples.load(examples.ROOT / 'topics' / f'{name}.yaml')
    kind = examples.interface(example.type)
    sent = examples.filled(kind(), example.values)
    received: list = []
    receiver.node.create_subscription(kind, f'example_{name}', received.append, 10)
    publisher = sender.node.create_publisher(kind, f'example_{name}', 10)
    sender.wait_until(lambda: publisher.get_subscription_count() == 1)
    publisher.publish(sent)
    receiver.wait_until(lambda: received)
    # What is declared float32 is rounded on its way.
    assert received == [deserialize_message(serialize_message(sent), kind)]


@pytest.mark.long
@pytest.mark.skipif(shutil.which('ros2') is None, reason='no wheel of ROS 2 has its command')
@pytest.mark.parametrize('path', examples.TOPICS, ids=lambda path: path.stem)
def test_the_command_of_an_example_is_heard_and_ends(path, live_pair):
    """As it stands in the file, by a subscriber of the topic that it names."""
    example, (receiver, _) = examples.load(path), live_pair
    try:
        kind = examples.interface(example.type)
    except ModuleNotFoundError as error:
        pytest.skip(f'{error.name} is not installed')
    received: list = []
    subscription = receiver.node.create_subscription(kind, example.name, received.append, 10)
    (line,) = (text for text in path.read_text().splitlines() if text.startswith('# ros2 '))
    process = subprocess.Popen(['bash', '-c', line[2:]], cwd=examples.ROOT.parent)
    try:
        receiver.wait_until(lambda: received, 'the message')
        assert process.wait(PATIENCE_S) == 0
    finally:
        process.kill()
        receiver.node.destroy_subscription(subscription)
    assert len(received) == 1
