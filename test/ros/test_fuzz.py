"""Whatever several clients send at once, the node keeps running and its bags verify."""

import random

import numpy as np
import pytest
from geometry_msgs.msg import WrenchStamped
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    GetParameterTypes,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)
from ros.live import Participant
from ros.process import descriptor_count, memory_bytes
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool, Trigger

from satdyn_ros.bag.verify import verify
from satdyn_ros.rosbag2.reader import Bag
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.topics import TOPICS

CLIENTS = 4
RATE_HZ = 200.0
VALUES = {
    'publish.rate': RATE_HZ,
    'rotor.mode': 'motor',
    'rotor.inertia': 0.5,
    'record.enabled': True,
    'record.max_size_bytes': 200_000,
}
NAMES = [*Scenario().values, 'use_sim_time', 'initial', 'x.y', '', '.', 'a' * 300, '\u00e9']
NUMBERS = (0.0, -0.0, 1.0, -1.0, 0.5, 1e-300, 1e300, np.inf, -np.inf, np.nan, 1e20, 3e-3)
INTEGERS = (0, 1, -1, 7, 2**31, 2**63 - 1, -(2**63))
WORDS = ('', 'lvlh', 'inertial', 'exact', 'attitude', 'tf', 'none', '\n' * 3, 'x' * 1000, '日本')
SERVICES = {
    'set_initial_conditions': SetParametersAtomically,
    'set_parameters': SetParameters,
    'set_parameters_atomically': SetParametersAtomically,
    'get_parameters': GetParameters,
    'get_parameter_types': GetParameterTypes,
    'describe_parameters': DescribeParameters,
    'list_parameters': ListParameters,
    'reset': Trigger,
    'step': Trigger,
    'pause': SetBool,
    'record': SetBool,
}
# A step through a torque that is dropped takes a million steps of the propagation, under a second
# of the processor; a loaded machine has taken twenty-four.
PATIENCE_S = 300.0
# The allocator's own slack.
ALLOWED_BYTES = 20_000_000


class Fuzz:
    """Random requests and messages of every kind, the same for a seed."""

    def __init__(self, seed):
        self.chance = random.Random(seed)

    def value(self):
        """Return a value of any type, those that do not exist among them."""
        pick, many = self.chance.choice, range(self.chance.choice((0, 1, 3, 4, 9)))
        return ParameterValue(
            type=pick((*range(11), 255)),
            bool_value=pick((True, False)),
            integer_value=pick(INTEGERS),
            double_value=float(pick(NUMBERS)),
            string_value=pick(WORDS),
            byte_array_value=[b'\x01' for _ in many],
            bool_array_value=[pick((True, False)) for _ in many],
            integer_array_value=[pick(INTEGERS) for _ in many],
            double_array_value=[float(pick(NUMBERS)) for _ in many],
            string_array_value=[pick(WORDS) for _ in many],
        )

    def name(self):
        initial = [name for name in NAMES if name.startswith(('initial.', 'rotor.', 'publish.'))]
        return self.chance.choice(NAMES if self.chance.random() < 0.5 else initial)

    def request(self, name):
        """Return a request of a service."""
        names = [self.name() for _ in range(self.chance.randrange(4))]
        match SERVICES[name].__name__:
            case 'Trigger':
                return Trigger.Request()
            case 'SetBool':
                return SetBool.Request(data=self.chance.random() < 0.5)
            case 'ListParameters':
                return ListParameters.Request(prefixes=names, depth=self.chance.randrange(3))
            case 'GetParameters' | 'GetParameterTypes' | 'DescribeParameters':
                return SERVICES[name].Request(names=names)
        # As fast as it can go, the node would fill the disk; ever slower, it would not step.
        free = [each for each in names if each not in ('time.factor', 'step.ticks')]
        return SERVICES[name].Request(
            parameters=[Parameter(name=each, value=self.value()) for each in free]
        )

    def wrench(self):
        message = WrenchStamped()
        message.header.frame_id = self.chance.choice(('', 'base_link', 'map', 'x' * 1000))
        torque = message.wrench.torque
        torque.x, torque.y, torque.z = (float(self.chance.choice(NUMBERS)) for _ in range(3))
        return message

    def rotor_command(self):
        """Return torques on rotors, of which the node has one."""
        pick = self.chance.choice
        return JointState(
            name=pick(
                (['rotor'], ['rotor'], [], ['rotor', 'rotor'], ['x' * 1000], ['\u00e9', ''])
            ),
            effort=[float(pick(NUMBERS)) for _ in range(pick((0, 1, 1, 1, 2)))],
            velocity=[float(pick(NUMBERS)) for _ in range(pick((0, 3)))],
        )


@pytest.mark.long
@pytest.mark.parametrize(
    ('seed', 'count'), [(1, 250), pytest.param(2, 20_000, marks=pytest.mark.torture)]
)
def test_fuzz(live, tmp_path, capsys, seed, count):
    """Every request is answered; at the end the node still runs, and every bag verifies."""
    node, participant = live(VALUES)
    clients = [Participant(node.namespace) for _ in range(CLIENTS)]
    participant.hear(participant.listen('attitude'), 1)
    fuzz, held, accepted = Fuzz(seed), [], 0
    callers = [
        {name: c.node.create_client(kind, f'satdyn/{name}') for name, kind in SERVICES.items()}
        for c in clients
    ]
    torques = [c.node.create_publisher(WrenchStamped, 'torque', 10) for c in clients]
    motors = [c.node.create_publisher(JointState, 'rotor_command', 10) for c in clients]
    for client, of_client in zip(clients, callers, strict=True):
        for name, caller in of_client.items():
            client.wait_until(caller.service_is_ready, name)
        client.wait_until_known('satdyn')
    for number in range(0, count, CLIENTS):
        futures = []
        for i in range(CLIENTS):
            name = fuzz.chance.choice(list(SERVICES))
            futures.append(callers[i][name].call_async(fuzz.request(name)))
            torques[i].publish(fuzz.wrench())
            motors[i].publish(fuzz.rotor_command())
        for client, future in zip(clients, futures, strict=True):
            client.wait_until(future.done, f'the answer to request {number}', PATIENCE_S)
            accepted += getattr(future.result(), 'success', False)
        if number >= count // 2:
            held.append((memory_bytes(node.process.pid), descriptor_count(node.process.pid)))
    for client in clients:
        client.close()

    participant.set({'publish.topics': ['attitude']})
    participant.switch('pause', False)
    participant.hear(participant.listen('attitude'), 10)
    participant.switch('record', False)
    code, errors = node.end()
    assert code == 0
    assert 'Traceback' not in errors
    growth = max(memory for memory, _ in held) - held[0][0]
    bags = sorted(tmp_path.glob('satdyn_*_*'))
    with capsys.disabled():
        print(
            f'\n{count} requests of {CLIENTS} clients, {accepted} of the simple ones accepted, '
            f'{2 * count} inputs, {len(bags)} bags, {growth / 1e6:.1f} MB more'
        )
    assert growth < ALLOWED_BYTES
    for bag in bags:
        verdict = verify(bag)
        assert verdict.is_true, f'{bag}: {verdict}'
        assert_no_gap(bag, node)


def assert_no_gap(path, node):
    """Assert that each tick of a bag that has a sample is followed by the next."""
    step_ns = round(1e9 / RATE_HZ)
    stamps_ns = [
        Bag(path).messages(topic).log_times_ns
        for topic in Bag(path).topics
        if topic.removeprefix(f'{node.namespace}/') in TOPICS
    ]
    assert all(np.all(np.mod(np.diff(each.astype(np.int64)), step_ns) == 0) for each in stamps_ns)
