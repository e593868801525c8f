import math
from dataclasses import replace

import numpy as np
import pytest
from messages import examples
from messages.drawn_samples import SYSTEMS, samples
from messages.readers import TYPESTORE, message_class, plain

from satdyn_ros.messages.contents import message
from satdyn_ros.run.scenario import Frames, Scenario
from satdyn_ros.run.simulation import Simulation
from satdyn_ros.run.topics import TOPICS, topics_with

SERVICES = {
    'set_initial_conditions': 'rcl_interfaces/srv/SetParametersAtomically',
    'reset': 'std_srvs/srv/Trigger',
    'pause': 'std_srvs/srv/SetBool',
    'step': 'std_srvs/srv/Trigger',
    'record': 'std_srvs/srv/SetBool',
}


def test_every_topic_and_every_service_has_an_example():
    """One file for each, named after it, and no others."""
    assert {path.stem for path in examples.TOPICS} == set(TOPICS)
    assert {path.stem for path in examples.SERVICES} == set(SERVICES)


@pytest.mark.parametrize('path', examples.TOPICS, ids=lambda path: path.stem)
def test_a_topic_example_is_a_message_of_its_type(path):
    """
    The command names topic, type and file as they are, and the message class takes all.

    It ends where nobody listens, and no output is published among those of the node.
    """
    example, topic = examples.load(path), TOPICS[path.stem]
    is_input, name = topic.role == 'input', f'/{topic.name.lstrip("/")}'
    assert example.first_line.startswith(f'# An {"in" if is_input else "out"}put of the node.')
    assert example.command == [
        *('ros2', 'topic', 'pub', '--once', '--max-wait-time-secs', '5'),
        *(name if is_input else f'/example{name}', topic.type),
        f'$(cat msg_examples/topics/{path.name})',
    ]
    if message_class(topic.type) is None:
        assert list(example.values) == ['transforms']
        for transform in example.values['transforms']:
            examples.filled(examples.interface('geometry_msgs/msg/TransformStamped')(), transform)
    else:
        examples.filled(message_class(topic.type)(), example.values)


@pytest.mark.parametrize(
    'name', [name for name, topic in TOPICS.items() if topic.role in ('state', 'clock')]
)
def test_an_example_says_what_the_node_says(name):
    """Frames, names, lengths and which fields are not zero are those of a real message."""
    names = {'flexible.names': ('bending', 'fuel'), 'hysteresis.names': ('rods_x', 'rods_y')}
    topic = topics_with((), {}, names=names)[name]
    name_of_flight = 'ellipse, motor'
    if topic.lacking(SYSTEMS[name_of_flight]):
        name_of_flight = 'above the Earth'
    system = replace(SYSTEMS[name_of_flight], inertia=np.diag([800.0, 900.0, 600.0]))
    data = message(topic, Frames(), system).pack(samples(name_of_flight))[1].tobytes()
    packed = plain(TYPESTORE.deserialize_cdr(data, topic.type))
    assert_alike(examples.load(examples.ROOT / 'topics' / f'{name}.yaml').values, packed)


def assert_alike(example, packed, path=''):
    """Compare the shape of nested values and their strings; absent fields hold defaults."""
    if isinstance(example, dict):
        assert example.keys() <= packed.keys(), path
        for key, value in packed.items():
            if key in example:
                assert_alike(example[key], value, f'{path}.{key}')
            else:
                assert not contains_data(value), f'{path}.{key}'
    elif isinstance(example, list):
        assert len(example) == len(packed), path
        for i, value in enumerate(packed):
            assert_alike(example[i], value, f'{path}[{i}]')
    elif isinstance(packed, str):
        assert example == packed, path
    else:
        assert type(example) is type(packed), path


def contains_data(value):
    """Whether a nested value differs from zeros, empty strings and quaternions of no rotation."""
    if value == {'x': 0.0, 'y': 0.0, 'z': 0.0, 'w': 1.0}:
        return False
    if isinstance(value, dict):
        return any(map(contains_data, value.values()))
    if isinstance(value, list):
        return any(map(contains_data, value))
    return bool(value)


@pytest.mark.parametrize('path', examples.SERVICES, ids=lambda path: path.stem)
def test_a_service_example_is_a_request_of_its_type(path):
    """The command names service, type and file as they are, and the request class takes all."""
    example = examples.load(path)
    assert example.first_line.startswith('# A request to the node.')
    assert example.command == [
        *('ros2', 'service', 'call', f'/satdyn/{path.stem}', SERVICES[path.stem]),
        f'$(cat msg_examples/services/{path.name})',
    ]
    examples.filled(examples.interface(example.type).Request(), example.values)


def test_the_requested_initial_conditions_are_allowed():
    """The engine of the node takes them and starts from them."""
    path = examples.ROOT / 'services' / 'set_initial_conditions.yaml'
    request = examples.filled(
        examples.interface(SERVICES[path.stem]).Request(), examples.load(path).values
    )
    assert {parameter.value.type for parameter in request.parameters} == {9}
    values = {p.name: list(p.value.string_array_value) for p in request.parameters}
    simulation = Simulation(Scenario.from_yaml('config/default.yaml'))
    simulation.request(values)
    _, begun = simulation.advance(1)
    half = math.radians(30.0) / 2.0
    pitched = [0.0, math.sin(half), 0.0, math.cos(half)]
    assert begun.states.q_lb[0] == pytest.approx(pitched, abs=1e-15)
