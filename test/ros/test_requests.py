"""New initial conditions during a run."""

import math
import struct

import pytest
from geometry_msgs.msg import WrenchStamped
from ros.live import EPOCH_NS, expected, raw_stamp_ns

from satdyn_ros.run.events import Request, Reset

HALF = math.sqrt(0.5)


def tick_of(stamp):
    return (stamp - EPOCH_NS) // 10**7


def test_a_request_restarts_the_motion_at_a_tick(live):
    """
    The stamps run on without a gap, and one tick carries exactly the requested state.

    It comes after the request, and all after it is the engine's motion from there.
    """
    node, participant = live({'publish.topics': ['attitude', 'angular_velocity']})
    attitudes = participant.listen('attitude', raw=True)
    rates = participant.listen('angular_velocity', raw=True)
    participant.wait_until(lambda: attitudes and rates)
    participant.hear(attitudes, 20)
    asked = {
        'initial.frame': 'inertial',
        'initial.attitude': [HALF, 0.0, 0.0, HALF],
        'initial.angular_velocity': [0.01, -0.02, 0.03],
    }
    before_request = len(attitudes)
    assert participant.request(asked) == (True, '')
    participant.hear(attitudes, 50)
    assert participant.trigger('reset')[0]
    participant.hear(attitudes, 50)

    stamps = [raw_stamp_ns(data) for data in attitudes]
    first = tick_of(stamps[0])
    assert [tick_of(stamp) for stamp in stamps] == list(range(first, first + len(stamps)))

    restarts = [tick_of(raw_stamp_ns(d)) for d in attitudes if quaternion(d) == [HALF, 0, 0, HALF]]
    assert len(restarts) == 2
    request_tick, reset_tick = restarts
    assert request_tick > tick_of(stamps[before_request - 1])
    events = [Request(request_tick, asked), Reset(reset_tick)]
    for topic, heard in (('attitude', attitudes), ('angular_velocity', rates)):
        packed = expected(node.scenario, topic, first + len(stamps) + 10, events)
        assert [packed[raw_stamp_ns(data)] for data in heard] == heard


def quaternion(data):
    """Return the last four doubles of a serialised QuaternionStamped."""
    return list(struct.unpack('<4d', data[-32:]))


@pytest.mark.long
def test_keys_not_given_stay_in_force_and_show_as_parameters(live):
    """A second request without attitude restarts from the attitude of the first one."""
    _, participant = live({'publish.topics': ['attitude_lvlh']})
    attitude = [0.0, 0.6, 0.0, 0.8]
    assert participant.request({'initial.attitude': attitude})[0]
    assert participant.get('initial.attitude') == attitude
    heard = participant.listen('attitude_lvlh')
    participant.hear(heard, 5)
    assert participant.request({'initial.angular_velocity': [0.0, 0.001, 0.0]})[0]
    assert participant.get('initial.angular_velocity') == [0.0, 0.001, 0.0]
    assert participant.get('initial.attitude') == attitude
    participant.hear(heard, 20)
    # Relative to LVLH, taken into the inertial frame and back, to rounding.
    close = [m for m in heard if m.quaternion.y == pytest.approx(0.6, abs=1e-14)]
    assert close


REFUSED = [
    (
        {'initial.attitude': [1.0, 1.0, 0.0, 0.0]},
        'initial.attitude is [1.0, 1.0, 0.0, 0.0], of norm 1.41421; it must be a unit quaternion '
        'x, y, z, w, to within 0.0001',
    ),
    (
        {'initial.attitude': [0.0, 0.0, 0.0, 0.0]},
        'initial.attitude is [0.0, 0.0, 0.0, 0.0]; it must not be zero',
    ),
    (
        {'initial.angular_velocity': [math.nan, 0.0, 0.0]},
        'initial.angular_velocity is [nan, 0.0, 0.0]; it must be a list of 3 numbers rad/s',
    ),
    (
        {'initial.angular_velocity': [0.1, 0.2]},
        'initial.angular_velocity is [0.1, 0.2]; it must be a list of 3 numbers rad/s',
    ),
    ({'initial.frame': 'ecef'}, "initial.frame is 'ecef'; it must be one of inertial, lvlh"),
    (
        {'body.inertia': [1.0, 1.0, 1.0]},
        'body.inertia cannot be requested; allowed: rotor.momentum, rotor.speed, '
        'initial.attitude, initial.roll_pitch_yaw, initial.pointing, initial.pointing_axis, '
        'initial.second_axis, initial.direction, initial.frame, initial.angular_velocity',
    ),
    (
        {'initial.height': 5.0},
        'initial.height cannot be requested; the nearest that can is initial.pointing; allowed: '
        'rotor.momentum, rotor.speed, initial.attitude, initial.roll_pitch_yaw, '
        'initial.pointing, initial.pointing_axis, initial.second_axis, initial.direction, '
        'initial.frame, initial.angular_velocity',
    ),
    (
        {'rotor.speed': 5.0},
        'rotor.speed is 5.0; with rotor.mode none only its default is allowed: it belongs to free '
        'and motor',
    ),
    (
        {'initial.angular_velocity': [0.0, 0.0, 0.1], 'initial.attitude': 'upright'},
        "initial.attitude is 'upright'; it must be a list of 4 numbers",
    ),
]


def test_a_bad_request_changes_nothing_and_says_why(live):
    """Each kind is refused by its sentence, and the stream continues as before."""
    node, participant = live({'publish.topics': ['attitude']})
    heard = participant.listen('attitude', raw=True)
    participant.hear(heard, 1)
    for values, sentence in REFUSED:
        assert participant.request(values) == (False, sentence)
    assert participant.get('initial.angular_velocity') == [0.0, 0.0, 0.0]
    participant.hear(heard, 20)
    stamps = [raw_stamp_ns(data) for data in heard]
    assert stamps == list(range(stamps[0], stamps[-1] + 1, 10**7))
    packed = expected(node.scenario, 'attitude', tick_of(stamps[-1]) + 1)
    assert [packed[stamp] for stamp in stamps] == heard


@pytest.mark.long
def test_integers_are_taken_as_floats(live):
    """What a YAML without decimals gives, [0, 0, 0, 1], is an attitude."""
    _, participant = live({'publish.topics': ['attitude_lvlh']})
    assert participant.request({'initial.attitude': [0, 0, 0, 1]}) == (True, '')
    assert participant.get('initial.attitude') == [0.0, 0.0, 0.0, 1.0]


@pytest.mark.long
def test_what_has_no_closed_form_is_refused_where_only_those_fly(live):
    """A torque and a tilted start are refused with the reason; the exact motion goes on."""
    node, participant = live(
        {'motion.method': 'exact', 'initial.attitude': [0.0, 0.0, 0.0, 1.0]}
        | {'publish.topics': ['attitude']}
    )
    heard = participant.listen('attitude', raw=True)
    publisher = participant.node.create_publisher(WrenchStamped, 'torque', 10)
    participant.wait_until(lambda: publisher.get_subscription_count() == 1)
    participant.hear(heard, 5)
    done, reason = participant.request({'initial.attitude': [0.1, 0.1, 0.1, math.sqrt(0.97)]})
    assert not done
    assert reason.startswith('motion.method is exact, but there is no closed form: ')
    driven = WrenchStamped()
    driven.wrench.torque.x = 1.0
    publisher.publish(driven)
    assert participant.trigger('reset')[0]
    participant.hear(heard, 20)
    stamps = [raw_stamp_ns(data) for data in heard]
    packed = expected(node.scenario, 'attitude', tick_of(stamps[-1]) + 1)
    # In relative equilibrium the reset changes nothing but rounding.
    for stamp, data in zip(stamps, heard, strict=True):
        assert quaternion(data) == pytest.approx(quaternion(packed[stamp]), abs=1e-13)
    _, errors = node.end()
    assert errors.count('torque is refused: motion.method is exact') == 1
