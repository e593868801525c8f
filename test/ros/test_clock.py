"""/clock as ROS defines it: the simulated time of every node that follows it."""

import time

import pytest
from rcl_interfaces.msg import Log
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, ReliabilityPolicy
from ros.live import EPOCH_NS, Participant, stamp_ns
from rosgraph_msgs.msg import Clock


def test_a_node_on_simulated_time_follows(live):
    """
    The clock has the stamps of the samples, and a node with use_sim_time has that time.

    Its timer goes by it, here at 20 times the wall clock.
    """
    node, _ = live(
        {'time.publish_clock': True, 'time.factor': 20.0, 'publish.rate': 10.0}
        | {'publish.topics': ['attitude']}
    )
    follower = Participant(
        node.namespace, parameter_overrides=[Parameter('use_sim_time', value=True)]
    )
    try:
        clocks: list[Clock] = []
        fired_ns: list[int] = []
        qos = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
        follower.node.create_subscription(Clock, '/clock', clocks.append, qos)
        follower.node.create_timer(
            1.0, lambda: fired_ns.append(follower.node.get_clock().now().nanoseconds)
        )
        heard = follower.listen('attitude')
        follower.wait_until(lambda: len(fired_ns) > 8 and len(heard) > 100)
        stamps = {clock.clock.sec * 10**9 + clock.clock.nanosec for clock in clocks}
        common = [stamp_ns(m) for m in heard if min(stamps) <= stamp_ns(m) <= max(stamps)]
        assert len(common) > 50
        # Best effort may lose some.
        assert len(set(common) & stamps) > 0.5 * len(common)
        # The node's own clock may have heard what this subscription has not, or not yet.
        assert all((stamp - EPOCH_NS) % 10**8 == 0 for stamp in [*stamps, *fired_ns[1:]])
        # At its first firing the clock had jumped from zero.
        span_s = (fired_ns[-1] - fired_ns[1]) / 1e9
        assert len(fired_ns) - 2 <= span_s + 1.0
    finally:
        follower.close()


def test_stamps_agree_with_the_wall_clock_unless_an_epoch_is_given(live):
    """
    Tick 0 has the microsecond of its start, so that no message comes before its stamp.

    Recording, which may have to be compiled first, does not put the ticks off.
    """
    before_ns = time.time_ns()
    _, participant = live({'time.epoch_ns': 0, 'record.enabled': True})
    heard = participant.listen('attitude')
    for _ in range(20):
        assert stamp_ns(participant.hear(heard, 1)[0]) < time.time_ns()
    epoch_ns = participant.get('time.epoch_ns')
    assert before_ns < epoch_ns
    # A full second is one start in a million.
    assert epoch_ns % 1000 == 0
    assert epoch_ns % 10**9 != 0


@pytest.mark.long
def test_a_second_publisher_of_the_clock_is_warned_of_once(live):
    """Two sources of time would make everybody's clock jump."""
    node, participant = live({'time.publish_clock': True})
    qos = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    participant.node.create_publisher(Clock, '/clock', qos)
    logged: list[str] = []
    participant.node.create_subscription(
        Log, '/rosout', lambda log: logged.append(log.msg), QoSProfile(depth=100)
    )
    participant.wait_until(lambda: any('/clock has another' in text for text in logged))
    # It looks each second.
    participant.hear(participant.listen('attitude'), 200)
    _, errors = node.end()
    assert errors.count('/clock has another publisher') == 1
