"""What is published: counts, stamps, bytes and fields."""

from fractions import Fraction

import numpy as np
import pytest
from ros.live import EPOCH_NS, expected, raw_stamp_ns, stamp_ns

from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import Simulation

ALL_TOPICS = [
    'attitude',
    'angular_velocity',
    'imu',
    'odometry',
    'attitude_lvlh',
    'gravity_gradient',
    'rotor',
    'markers',
]
MOTOR = {
    'rotor.mode': 'motor',
    'rotor.inertia': 2.0,
    'rotor.speed': 30.0,
    'orbit.type': 'kepler',
    'orbit.eccentricity': 0.1,
    'frames.inertial': 'gcrf',
    'frames.orbital': 'sat1/lvlh',
    'frames.body': 'sat1/base_link',
}


@pytest.mark.parametrize(
    ('rate', 'exact_rate', 'count'),
    [
        pytest.param(100.0, Fraction(100), 1000, marks=pytest.mark.long),
        (1000.0, Fraction(1000), 3000),
        pytest.param(3.0, Fraction(3), 6, marks=pytest.mark.long),
    ],
)
def test_every_tick_comes_once_with_its_stamp_and_the_bytes_of_the_engine(
    live, rate, exact_rate, count
):
    """
    From the first message heard on, no tick is missing and none is doubled.

    Each stamp is the exact rational one, and Simulation in this process packs the same bytes.
    """
    node, participant = live({'publish.rate': rate, 'rotor.mode': 'constant_momentum'})
    attitudes, imus = participant.listen('attitude', raw=True), participant.listen('imu', raw=True)
    participant.wait_until(lambda: attitudes and imus)
    participant.hear(attitudes, count)
    participant.wait_until(lambda: raw_stamp_ns(imus[-1]) >= raw_stamp_ns(attitudes[-1]))

    first = round((raw_stamp_ns(attitudes[0]) - EPOCH_NS) * exact_rate / 10**9)
    stamps = [raw_stamp_ns(data) for data in attitudes]
    assert stamps == [
        EPOCH_NS + round(tick * 10**9 / exact_rate) for tick in range(first, first + len(stamps))
    ]
    total = first + len(attitudes) + len(imus)
    for topic, heard in (('attitude', attitudes), ('imu', imus)):
        packed = expected(node.scenario, topic, total)
        assert [packed[raw_stamp_ns(data)] for data in heard] == heard


def test_a_typed_subscriber_sees_what_was_computed(live):
    """Every field of every topic that varies, and every frame, is what the engine says."""
    values = MOTOR | {'publish.topics': ALL_TOPICS, 'publish.rate': 20.0}
    node, participant = live(values)
    heard = {name: participant.listen(name) for name in ALL_TOPICS}
    participant.wait_until(lambda: all(heard.values()), 'every topic')
    # The last heard of each topic at a tick that all have.
    participant.hear(heard['attitude'], 10)
    stamped = {
        name: {(stamp_ns(m) if name != 'markers' else stamp_ns(m.markers[0])): m for m in messages}
        for name, messages in heard.items()
    }
    stamp = max(set.intersection(*(set(messages) for messages in stamped.values())))
    seen = {name: messages[stamp] for name, messages in stamped.items()}

    scenario = Scenario(node.values)
    tick = (stamp - EPOCH_NS) * 20 // 10**9
    _, samples = Simulation(scenario).advance(tick + 1)
    states = samples.states
    q_ib, omega = states.q_ib[-1], states.omega_bi_b[-1]

    def numbers(vector):
        return [getattr(vector, part) for part in ('x', 'y', 'z', 'w') if hasattr(vector, part)]

    attitude = seen['attitude']
    assert attitude.header.frame_id == 'gcrf'
    assert numbers(attitude.quaternion) == list(q_ib)

    velocity = seen['angular_velocity']
    assert (velocity.header.frame_id, velocity.body_frame_id, velocity.reference_frame_id) == (
        'sat1/base_link',
        'sat1/base_link',
        'gcrf',
    )
    assert numbers(velocity.velocity.angular) == list(omega)
    assert numbers(velocity.velocity.linear) == [0.0, 0.0, 0.0]

    imu = seen['imu']
    assert imu.header.frame_id == 'sat1/base_link'
    assert numbers(imu.orientation) == list(q_ib)
    assert numbers(imu.angular_velocity) == list(omega)
    assert imu.linear_acceleration_covariance[0] == -1.0

    odometry = seen['odometry']
    assert (odometry.header.frame_id, odometry.child_frame_id) == ('gcrf', 'sat1/base_link')
    assert numbers(odometry.pose.pose.position) == list(states.r_i[-1])
    assert numbers(odometry.pose.pose.orientation) == list(q_ib)
    assert numbers(odometry.twist.twist.angular) == list(omega)
    # A rotation keeps lengths to rounding.
    speed = np.linalg.norm(numbers(odometry.twist.twist.linear))
    assert speed == pytest.approx(np.linalg.norm(states.v_i[-1]), rel=1e-14)

    assert seen['attitude_lvlh'].header.frame_id == 'sat1/lvlh'
    assert numbers(seen['attitude_lvlh'].quaternion) == list(states.q_lb[-1])
    assert seen['gravity_gradient'].header.frame_id == 'sat1/base_link'
    assert np.any(numbers(seen['gravity_gradient'].wrench.torque))

    rotor = seen['rotor']
    assert list(rotor.name) == ['rotor']
    assert list(rotor.position) == list(states.rotor_angle[-1])
    assert list(rotor.velocity) == list(states.rotor_speed[-1])
    assert list(rotor.effort) == [0.0]
    assert [marker.ns for marker in seen['markers'].markers] == [
        'body',
        'axes',
        'nadir',
        'rate',
        'momentum',
    ]
