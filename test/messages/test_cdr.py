from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from messages.readers import TYPESTORE, canonical, default, read

from satdyn_ros.messages import cdr

TEXT = st.text(st.characters(exclude_categories=['Cs'], exclude_characters='\0'), max_size=12)
NUMBER = st.floats(allow_nan=False)


@given(frame=TEXT, names=st.lists(TEXT, max_size=3), values=st.lists(NUMBER, max_size=3))
@settings(max_examples=50)
def test_strings_and_arrays_of_any_length_stand_where_ros_puts_them(frame, names, values):
    """Whatever the lengths before it, each value is where every reader and ROS's writer look."""
    content = {'header': {'frame_id': frame}, 'name': names, 'position': values, 'effort': values}
    data = cdr.Message('sensor_msgs/msg/JointState', content).rows(1).tobytes()
    expected = default('sensor_msgs/msg/JointState', **content)
    assert all(
        message == expected for message in read('sensor_msgs/msg/JointState', data).values()
    )
    assert data == canonical('sensor_msgs/msg/JointState', data)


@pytest.mark.parametrize(
    'type_name',
    [
        'geometry_msgs/msg/TransformStamped',
        'nav_msgs/msg/Odometry',
        'sensor_msgs/msg/Imu',
        'sensor_msgs/msg/JointState',
        'visualization_msgs/msg/Marker',
    ],
)
def test_what_is_not_given_holds_the_defaults_of_ros(type_name):
    """An empty content is the message that ROS makes, quaternions of no rotation included."""
    data = cdr.Message(type_name, {}).rows(1).tobytes()
    assert all(message == default(type_name) for message in read(type_name, data).values())
    assert data == canonical(type_name, data)


def test_columns_and_constants_mix_in_one_array():
    """Points of a marker: the first stays, the second follows the source; booleans and colours."""
    marker = cdr.Message(
        'visualization_msgs/msg/Marker',
        {
            'points': [[1.0, 2.0, 3.0], lambda source: source],
            'colors': [(0.5, 0.25, 0.0, 1.0)],
            'frame_locked': True,
            'text': 'ab',
        },
    )
    rows = marker.pack(np.array([[4.0, 5.0, 6.0], [7.0, 8.0, 9.0]]))
    expected = default(
        'visualization_msgs/msg/Marker',
        points=[{'x': 1.0, 'y': 2.0, 'z': 3.0}, {'x': 7.0, 'y': 8.0, 'z': 9.0}],
        colors=[{'r': 0.5, 'g': 0.25, 'b': 0.0, 'a': 1.0}],
        frame_locked=True,
        text='ab',
    )
    for message in read('visualization_msgs/msg/Marker', rows[1].tobytes()).values():
        assert message == expected


def test_rows_read_messages_of_others():
    """The layout reads what another program wrote: a table without a loop."""
    layout = cdr.Message('geometry_msgs/msg/QuaternionStamped', {'header': {'frame_id': 'abc'}})
    type_name = 'geometry_msgs/msg/QuaternionStamped'
    # Of a class that the type store makes.
    messages: list[Any] = [
        TYPESTORE.deserialize_cdr(layout.rows(1).tobytes(), type_name) for _ in range(3)
    ]
    for k, message in enumerate(messages):
        message.quaternion.y = float(k)
    data = b''.join(bytes(TYPESTORE.serialize_cdr(m, type_name)) for m in messages)
    table = np.frombuffer(data, layout.dtype)
    assert np.array_equal(table['quaternion'], [[0, 0, 0, 1], [0, 1, 0, 1], [0, 2, 0, 1]])


@pytest.mark.parametrize(
    ('content', 'why'),
    [
        ({'headers': {}}, 'sensor_msgs/msg/Imu has no field headers'),
        ({'orientation_covariance': [0.0] * 8}, 'orientation_covariance has 8 elements; it'),
    ],
)
def test_a_content_that_does_not_fit_is_refused(content, why):
    """A misspelt field and a wrong length show when the layout is made, not in a bag."""
    with pytest.raises(ValueError, match=why):
        cdr.Message('sensor_msgs/msg/Imu', content)
