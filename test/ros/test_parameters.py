"""The node's parameters: what describes them, what changes, what is refused."""

import math
from array import array

import pytest
import yaml
from actuated import cases
from other_units import in_another
from rcl_interfaces.msg import ParameterType
from rcl_interfaces.srv import DescribeParameters, ListParameters, SetParametersAtomically
from rclpy.qos import ReliabilityPolicy
from ros.live import EPOCH_NS, PATIENCE_S, ROOT, parameter_messages, stamp_ns, start

from satdyn_ros.base.key import listed
from satdyn_ros.messages.qos import Qos
from satdyn_ros.rosbag2.reader import Bag
from satdyn_ros.run.keys import KEYS
from satdyn_ros.run.scenario import Scenario


def test_every_key_is_described_with_unit_and_range_and_none_is_forgotten(live):
    """What `ros2 param list` and `describe` show is the table of keys."""
    _, participant = live({'publish.rate': 10.0})
    listed = participant.call(
        ListParameters, 'satdyn/list_parameters', ListParameters.Request()
    ).result.names
    foreign = {name for name in listed if name.split('.')[0] in FOREIGN}
    assert set(listed) - foreign == set(KEYS)

    names = sorted(KEYS)
    request = DescribeParameters.Request(names=names)
    answer = participant.call(DescribeParameters, 'satdyn/describe_parameters', request)
    for name, descriptor in zip(names, answer.descriptors, strict=True):
        key = KEYS[name]
        assert descriptor.description.startswith(f'[{key.unit}] ' if key.unit else key.meaning)
        assert key.allowed in descriptor.additional_constraints
        assert descriptor.read_only == (key.changes == 'never')
    types = {d.name: d.type for d in answer.descriptors}
    for name in ('rotor.names', 'torque.names', 'sensors.names', 'publish.topics'):
        assert types[name] == ParameterType.PARAMETER_STRING_ARRAY
    ranges = {d.name: d.floating_point_range for d in answer.descriptors}
    assert (ranges['publish.rate'][0].from_value, ranges['publish.rate'][0].to_value) == (0, 1e4)
    assert ranges['time.factor'][0].from_value == 0.0
    assert ranges['rotor.momentum'] == []

    for name, value in (
        ('publish.rate', 10.0),
        ('time.epoch_ns', EPOCH_NS),
        ('publish.topics', ['attitude', 'angular_velocity', 'imu', 'odometry']),
        ('body.inertia', [800.0, 900.0, 600.0]),
    ):
        assert participant.get(name) == value


def test_altitude_and_epoch_become_what_they_stand_for(live):
    """A node shows the values that follow, and all that it shows makes the same scenario again."""
    given = {'orbit.altitude': 622000.0, 'time.epoch': '2026-03-01T00:00:00Z', 'time.epoch_ns': 0}
    _, participant = live(given)
    shown = {name: participant.get(name) for name in KEYS}
    assert shown['orbit.semi_major_axis'] == 7000137.0
    assert shown['time.epoch_ns'] == 1772323200 * 10**9
    assert (shown['orbit.altitude'], shown['time.epoch']) == (0.0, '')
    assert Scenario(shown)['orbit.semi_major_axis'] == 7000137.0
    ((is_set, reason),) = participant.set({'orbit.altitude': 5e5})
    assert not is_set
    assert 'read-only' in reason


def test_texts_with_units_are_doubles_in_si_before_they_are_declared(live, tmp_path):
    """
    By a file, rcl's own -p, a set and a request; what the node then shows is a scenario in SI.

    A dump of it, read by rcl with its empty lists, starts the same node again.
    """
    given = {
        'orbit.inclination': '90 deg',
        'body.inertia': '[0.1, 0.2, 0.15] kg m^2',
        'initial.angular_velocity': ['0 deg/s', '0 deg/s', '-90 deg/s'],
        'publish.rate': '0.01 kHz',
    }
    given['publish.topics'] = ['attitude']
    arguments = ['-p', 'orbit.altitude:=420 km', '-p', 'torque.timeout:=2 min']
    node, participant = live(given, ros_args=arguments)
    assert participant.get('orbit.inclination') == math.pi / 2
    assert list(participant.get('body.inertia')) == [0.1, 0.2, 0.15]
    assert list(participant.get('initial.angular_velocity')) == [0.0, 0.0, -math.pi / 2]
    assert participant.get('publish.rate') == 10.0
    assert participant.get('orbit.semi_major_axis') == 6378137.0 + 420e3
    assert participant.get('torque.timeout') == 120.0
    assert participant.set({'torque.timeout': '0.5 h'}) == [(True, '')]
    assert participant.get('torque.timeout') == 1800.0
    ((is_set, reason),) = participant.set({'torque.timeout': '5 m'})
    assert not is_set
    assert 'units that fit: s, min' in reason
    pitched = {'initial.roll_pitch_yaw': ['0', '90 deg', '0'], 'initial.frame': 'lvlh'}
    assert participant.request(pitched) == (True, '')
    half = math.sqrt(0.5)
    assert list(participant.get('initial.attitude')) == pytest.approx([0, half, 0, half])
    is_set, reason = participant.request({'initial.angular_velocity': ['1 Hz', '0', '0']})
    assert not is_set
    assert 'units that fit: rev/s, rpm' in reason
    assert participant.request({'initial.pointing': 'nadir'}) == (True, '')
    assert list(participant.get('initial.attitude')) == [0.0, 0.0, 0.0, 1.0]
    assert participant.get('initial.pointing') == ''

    loads_again(live, node, participant, tmp_path / 'dump.yaml')


def loads_again(live, node, participant, dump, keys=KEYS):
    """End a node, check that a dump of it, read by rcl, starts it again, and return the dump."""
    shown = {name: participant.get(name) for name in keys}
    plain = {name: list(x) if isinstance(x, array) else x for name, x in shown.items()}
    section = f'{node.namespace}/satdyn'
    dump.write_text(yaml.safe_dump({section: {'ros__parameters': plain}}))
    assert Scenario.from_yaml(dump) == Scenario(shown)
    node.end()
    again, asked = live({}, namespace=node.namespace, ros_args=['--params-file', str(dump)])
    assert {name: asked.get(name) for name in keys} == shown
    again.end()
    return shown


def test_every_key_may_be_typed_in_a_unit(live, tmp_path):
    """
    What has a unit as a text, from a file that the node reads and by rcl's own -p.

    All that a body may have: wheels, plates, thrusters, flexible parts, rods and each sensor.  A
    dump of the node starts it again.
    """
    (case,) = cases('everything.json').values()
    kinds = ('gyro', 'star_tracker', 'magnetometer', 'sun_sensor', 'coarse_sun_sensor')
    plain = Scenario.from_dict(case['scenario']).with_values(
        {
            'surface.names': ['panel'],
            'surface.panel.area': 0.02,
            'environment.sun': 'ephemeris',
            'environment.magnetic_field': 'dipole',
            'sensors.names': [f'my_{kind}' for kind in kinds],
            'sensors.seed': 7,
            **{f'sensors.my_{kind}.type': kind for kind in kinds},
            'sensors.my_gyro.noise_density': 4e-5,
            'sensors.my_gyro.bias_instability': 1e-6,
            'sensors.my_star_tracker.cross_boresight': 3e-5,
            'sensors.my_magnetometer.noise': 1.5e-8,
            'publish.rate': 10.0,
            'publish.topics': ['attitude'],
        }
    )
    typed = {
        name: in_another(plain.keys[name], value)
        for name, value in plain.values.items()
        if plain.keys[name].unit and value != ()
    }
    assert {KEYS[n].unit for n in KEYS if KEYS[n].unit} <= {plain.keys[n].unit for n in typed}
    others = {
        name: listed(value)
        for name, value in plain.values.items()
        if name not in typed and value not in ((), '')
    }
    names = sorted(typed)
    arguments = [x for name in names[1::2] for x in ('-p', f"{name}:='{typed[name]}'")]
    given = others | {name: typed[name] for name in names[::2]}
    node, participant = live(given, ros_args=arguments)
    for name in names:
        shown = participant.get(name)
        assert (tuple(shown) if plain.keys[name].lengths else shown) == plain[name], name
    loads_again(live, node, participant, tmp_path / 'dump.yaml', plain.keys)


def test_parts_are_values_before_they_are_declared(live, tmp_path):
    """A file and rcl's own -p name one each; what the node then shows loads again."""
    given = {
        'rotor.part': 'wheel_10_mNms',
        'rotor.max_torque': '0.5 mN m',
        'sensors.names': ['gyro'],
        'sensors.seed': 1,
        'thruster.names': ['t'],
        'thruster.t.part': 'cold_gas_thruster_55_mN',
    }
    arguments = ['-p', 'sensors.gyro.part:=tactical_gyro']
    node, participant = live(given, ros_args=arguments)
    ((is_set, reason),) = participant.set({'rotor.part': 'wheel_2_mNms'})
    assert not is_set
    assert 'read-only' in reason
    keys = Scenario(given).keys
    shown = loads_again(live, node, participant, tmp_path / 'dump.yaml', keys)
    assert (shown['thruster.t.thrust'], shown['thruster.t.part']) == (55e-3, '')
    assert shown['rotor.max_speed'] == pytest.approx(200 * math.pi)
    assert shown['rotor.max_torque'] == 5e-4
    assert shown['sensors.gyro.noise_density'] == pytest.approx(math.radians(0.15) / 60)
    assert (shown['rotor.part'], shown['sensors.gyro.part']) == ('', '')


FOREIGN = ('use_sim_time', 'start_type_description_service', 'qos_overrides')


def test_sets_are_taken_or_refused_by_the_rules_of_their_key(live):
    """
    Integers are taken for doubles; a set of several is all or nothing.

    What may not change says so, what changes by a service names it, and nobody can delete a
    parameter.
    """
    _, participant = live()
    assert participant.set({'torque.timeout': 5}) == [(True, '')]
    assert participant.get('torque.timeout') == 5.0
    refused = participant.set(
        {
            'body.inertia': [1.0, 1.0, 1.0],
            'initial.angular_velocity': [0.0, 0.0, 1.0],
            'step.ticks': 0,
            'torque.timeout': math.nan,
            'time.factor': None,
            'publish.topics': ['attitude', 'height'],
        }
    )
    assert [done for done, _ in refused] == [False] * 6
    for (_, reason), said in zip(
        refused,
        [
            'Trying to set a read-only parameter: body.inertia.',
            'initial.angular_velocity changes only through the service ~/set_initial_conditions',
            'step.ticks',
            'torque.timeout',
            'time.factor is None; it must be a number',
            "publish.topics is ['attitude', 'height']; it must be a list of attitude, ",
        ],
        strict=True,
    ):
        assert reason.startswith(said) or said in reason

    together = parameter_messages({'step.ticks': 7, 'time.factor': -1.0})
    request = SetParametersAtomically.Request(parameters=together)
    service = 'satdyn/set_parameters_atomically'
    assert not participant.call(SetParametersAtomically, service, request).result.successful
    assert participant.get('step.ticks') == 1
    request.parameters[1].value.double_value = 2.0
    assert participant.call(SetParametersAtomically, service, request).result.successful
    assert (participant.get('step.ticks'), participant.get('time.factor')) == (7, 2.0)


@pytest.mark.long
def test_topics_change_while_running(live):
    """A removed topic stops, an added one begins at a later tick."""
    _, participant = live({'publish.topics': ['attitude', 'imu']})
    imus, rotors = participant.listen('imu'), participant.listen('rotor')
    attitudes = participant.listen('attitude')
    participant.hear(imus, 5)
    assert participant.set({'publish.topics': ['attitude', 'rotor']}) == [(True, '')]
    participant.hear(rotors, 5)
    participant.hear(attitudes, 10)
    # The one listens from before, the other may be heard a little late.
    assert stamp_ns(imus[-1]) < stamp_ns(rotors[0])


def test_topics_that_are_off_leave_the_graph(live):
    """Their publishers go, and come again with the topic; publish.topics may be empty."""
    node, participant = live({'publish.topics': ['attitude', 'imu']})

    def publishers(name):
        return len(participant.node.get_publishers_info_by_topic(f'{node.namespace}/{name}'))

    participant.hear(participant.listen('imu'), 3)
    assert participant.set({'publish.topics': ['attitude']}) == [(True, '')]
    participant.wait_until(lambda: publishers('imu') == 0, 'the end of the publisher')
    assert publishers('attitude') == 1
    assert participant.set({'publish.topics': ['imu']}) == [(True, '')]
    participant.hear(participant.listen('imu'), 3)
    participant.wait_until(lambda: publishers('attitude') == 0, 'the end of the publisher')
    assert participant.set({'publish.topics': []}) == [(True, '')]
    participant.wait_until(lambda: publishers('imu') == 0, 'the end of the publisher')


def test_the_quality_of_service_can_be_overridden(live, tmp_path):
    """As rclpy does it, topic by topic; the bag says what was offered."""
    prefix = 'qos_overrides./slow/imu.publisher'
    node, participant = live(
        {'publish.topics': ['attitude', 'imu'], 'record.enabled': True},
        ros_args=['-p', f'{prefix}.reliability:=best_effort', '-p', f'{prefix}.depth:=7'],
        namespace='/slow',
    )
    participant.hear(participant.listen('attitude'), 3)
    offered = {
        name: participant.node.get_publishers_info_by_topic(f'/slow/{name}')[0].qos_profile
        for name in ('attitude', 'imu')
    }
    assert offered['attitude'].reliability == ReliabilityPolicy.RELIABLE
    assert offered['imu'].reliability == ReliabilityPolicy.BEST_EFFORT
    assert participant.get(f'{prefix}.history') == 'keep_last'
    assert node.end()[0] == 0
    (bag,) = (Bag(path) for path in tmp_path.glob('satdyn_2*'))
    assert bag.topics['/slow/imu'].qos == Qos(7, 'best_effort').to_yaml()
    assert bag.topics['/slow/attitude'].qos == Qos(100).to_yaml()


def test_a_topic_whose_quality_of_service_is_wrong_cannot_be_switched_on(live):
    """The set is refused with the sentence of the start, and nothing has changed."""
    prefix = 'qos_overrides./wrong/imu.publisher'
    _, participant = live(
        {'publish.topics': ['attitude']},
        ros_args=['-p', f'{prefix}.reliability:=good'],
        namespace='/wrong',
    )
    ((is_set, reason),) = participant.set({'publish.topics': ['attitude', 'odometry', 'imu']})
    assert not is_set
    assert reason.startswith(f'{prefix} is not allowed: Unexpected QoS override')
    assert participant.get('publish.topics') == ['attitude']
    participant.wait_until(
        lambda: participant.node.count_publishers('odometry') == 0, 'the end of the publisher'
    )


WRONG = [
    (['-p', 'foo:=1'], 'foo is not a parameter of a scenario'),
    (['-p', 'body.inertia:=[1.0, 1.0, 5.0]'], 'body.inertia is [1, 1, 5]; '),
    (['-p', 'publish.topics:=[1, 2]'], 'publish.topics is [1, 2]; it must be a list of attitude'),
    (['-p', 'publish.topics:=[true]'], 'publish.topics is [True]; it must be a list of attitude'),
    (['-p', 'time.factor:=1e-12'], 'time.factor is 1e-12 and publish.rate 100; '),
    (['-p', 'orbit.inclination:=51.6'], 'orbit.inclination is 51.6; it must be an angle in radi'),
    (
        ['-p', 'qos_overrides./imu.publisher.reliability:=good'],
        'qos_overrides./imu.publisher is not allowed: Unexpected QoS override for policy',
    ),
    (
        ['-p', 'publish.topics:=[imu, attitude, imu]'],
        'publish.topics has imu twice; each may be given once',
    ),
    (['-p', 'use_sim_time:=3'], "parameter 'use_sim_time' to '3' of type 'INTEGER', expecting "),
    (['-r', 'attitude:=imu'], 'attitude and imu are both the topic /imu; each must have one of'),
    (['-r', 'imu:=torque'], 'torque and imu are both the topic /torque; each must have one of'),
    (
        ['-r', 'gyro:=imu', '-p', 'sensors.names:=[gyro]'],
        'gyro and imu are both the topic /imu; each must have one of its own',
    ),
    (['--bogus'], "--ros-args does not allow ['--bogus']"),
    (['-p', 'publish.rate:=0'], 'publish.rate is 0; it must be a number above 0'),
    (
        ['-p', 'time.publish_clock:=true', '-p', 'use_sim_time:=true'],
        'time.publish_clock and use_sim_time are both true; ',
    ),
    (
        ['-p', 'record.enabled:=true', '-p', f'record.directory:={ROOT}/setup.py'],
        'cannot be created',
    ),
]


@pytest.mark.parametrize(
    ('ros_args', 'sentence'),
    # One wrong name and one wrong value start a node here; the rest start eight more.
    [*WRONG[:2], *(pytest.param(*wrong, marks=pytest.mark.long) for wrong in WRONG[2:])],
    ids=lambda x: x[-1][:20],
)
def test_wrong_input_ends_the_node_with_one_sentence(tmp_path, ros_args, sentence):
    """Exit code 2 and no traceback."""
    process = start(['--ros-args', *ros_args], tmp_path)
    _, errors = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 2
    (line,) = errors.splitlines()
    assert line.startswith('satdyn node: ')
    assert sentence in line


@pytest.mark.parametrize('name', ['use_sim_time', 'start_type_description_service'])
def test_a_parameter_of_rclpys_is_checked_in_our_own_file_too(tmp_path, name):
    """It is not dropped without a word."""
    path = tmp_path / 'wrong.yaml'
    path.write_text(f'/**:\n  ros__parameters:\n    {name}: 3\n')
    process = start(['--params-file', str(path)], tmp_path)
    _, errors = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 2
    assert errors == f'satdyn node: {name} is 3; it must be true or false\n'


@pytest.mark.long
def test_a_list_that_mixes_integers_and_floats_is_taken_from_our_own_file(live):
    """And what follows --ros-args overrides the file."""
    _, participant = live(
        {'body.inertia': [800, 900.5, 600], 'publish.rate': 50},
        ros_args=['-p', 'publish.rate:=25.0'],
    )
    assert participant.get('body.inertia') == [800.0, 900.5, 600.0]
    assert participant.get('publish.rate') == 25.0


@pytest.mark.long
def test_what_a_fixed_direction_has_not_is_left_out_with_one_warning(live):
    """There is no LVLH; the other topics come."""
    node, participant = live(
        {'orbit.type': 'fixed', 'publish.topics': ['attitude', 'attitude_lvlh', 'odometry']}
    )
    participant.hear(participant.listen('odometry'), 3)
    assert participant.get('publish.topics') == ['attitude', 'odometry']
    code, errors = node.end()
    assert code == 0
    assert errors.count('attitude_lvlh') == errors.count('attitude_lvlh is not published: ') + 1
