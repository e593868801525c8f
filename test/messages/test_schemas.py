import json

import pytest
from messages.readers import TYPESTORE, message_class

from satdyn_ros.messages import schemas
from satdyn_ros.run.topics import TOPICS
from scripts import collect_definitions

TYPES = sorted({topic.type for topic in TOPICS.values() if topic.role != 'diagnostics'})

# Computed with rosbags' implementation of REP-2011, which is checked against ROS 2's own tests.
HASHES = {
    'geometry_msgs/msg/QuaternionStamped': (
        '381add86c6c3160644d228ca342182c7fd6c7fab11c7a85ad817a9cc22dbac6e'
    ),
    'geometry_msgs/msg/VelocityStamped': (
        '55e7196186c8dbe4375278d7f1ac050dd8c9bacade1cf3eef8460fa667bd2457'
    ),
    'geometry_msgs/msg/WrenchStamped': (
        '8dc3deaf06b2ab281f9f9a742a8961c328ca7cec16e3fd6586d3a5c83fa78f77'
    ),
    'sensor_msgs/msg/Imu': '7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b',
    'sensor_msgs/msg/JointState': (
        'a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e'
    ),
    'nav_msgs/msg/Odometry': '3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0',
    'rosgraph_msgs/msg/Clock': '692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564',
    'tf2_msgs/msg/TFMessage': 'e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087',
}


def test_data_is_what_ros_installs():
    """Definitions word for word and hashes are those of the installed packages."""
    kept = json.loads(collect_definitions.TARGET.read_text(encoding='utf-8'))
    assert kept == collect_definitions.collect()


@pytest.mark.parametrize('type_name', TYPES)
def test_hashes_are_those_of_the_definitions(type_name):
    """What another program computes from its own definitions of the type; and known values."""
    assert schemas.type_hash(type_name) == TYPESTORE.hash_rihs01(type_name)
    if type_name in HASHES:
        assert schemas.type_hash(type_name) == f'RIHS01_{HASHES[type_name]}'


@pytest.mark.parametrize('type_name', TYPES)
def test_fields_are_those_of_the_message_classes(type_name):
    """Names and order of the fields of every part, as rclpy has them."""
    for name in schemas.closure(type_name):
        if message_class(name):
            expected = list(message_class(name).get_fields_and_field_types())
            # A message without fields gets a hidden one.
            assert [field.name for field in schemas.fields(name)] == expected


def test_schema_text_is_laid_out_as_rosbag2_does():
    """The parts of QuaternionStamped in rosbag2's order, each under a line and its name."""
    parts = schemas.schema_text('geometry_msgs/msg/QuaternionStamped').split(
        '\n' + '=' * 80 + '\n'
    )
    assert [part.split('\n')[0] for part in parts[1:]] == [
        'MSG: geometry_msgs/Quaternion',
        'MSG: std_msgs/Header',
        'MSG: builtin_interfaces/Time',
    ]
    root = collect_definitions.installed('geometry_msgs/msg/QuaternionStamped')['definition']
    assert parts[0] == root


def test_each_part_of_a_schema_comes_once_and_after_who_needs_it_first():
    """Depth first, siblings in alphabetical order: Odometry, worked out by hand."""
    assert schemas.closure('nav_msgs/msg/Odometry') == [
        'nav_msgs/msg/Odometry',
        'geometry_msgs/msg/PoseWithCovariance',
        'geometry_msgs/msg/Pose',
        'geometry_msgs/msg/Point',
        'geometry_msgs/msg/Quaternion',
        'geometry_msgs/msg/TwistWithCovariance',
        'geometry_msgs/msg/Twist',
        'geometry_msgs/msg/Vector3',
        'std_msgs/msg/Header',
        'builtin_interfaces/msg/Time',
    ]


def test_definitions_are_read_as_ros_reads_them():
    """Comments and constants are passed over; arrays, own-package types and defaults are kept."""
    text = '# float64 a\nint32 B=1\n\nfloat64[3] c # d\nE[] e\nbuiltin_interfaces/Time t\nint8 f 2'
    assert schemas.parse('p/msg/X', text) == (
        schemas.MessageField('float64', 'c', 3),
        schemas.MessageField('p/msg/E', 'e', schemas.SEQUENCE),
        schemas.MessageField('builtin_interfaces/msg/Time', 't'),
        schemas.MessageField('int8', 'f', None, 2.0),
    )
