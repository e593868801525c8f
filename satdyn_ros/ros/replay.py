"""A bag's topics published again, at their times and with their quality of service."""

import math
import sys
import time
from pathlib import Path

import rclpy
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.time import Time
from rosgraph_msgs.msg import Clock

from ..bag.playback import Playback
from ..base.nanoseconds import SECOND_NS
from ..messages import qos
from .context import init
from .other_users import unreached
from .publishing import message_class, qos_profile

_LOOK_S = 0.05
# Subscribers of one process are found one after the other.
_SETTLE_S = 0.5
# The system sleeps for some centuries at most.
_LONGEST_SLEEP_S = 3600.0
_ACKNOWLEDGED = Duration(seconds=2)


def replay(
    path: str | Path,
    rate: float = 1.0,
    loop: bool = False,
    publish_clock: bool = False,
    start_offset_s: float = 0.0,
    wait: bool = False,
) -> int:
    """
    Publish a bag's messages at their log times and return how many they were.

    Topics whose type is not installed are left out with one sentence each.

    Parameters
    ----------
    path : str or Path
        the bag
    rate : s/s
        bag seconds per second
    loop : bool
        whether it is repeated until it is interrupted
    publish_clock : bool
        whether /clock comes just before the messages of each log time
    start_offset_s : s
        where it begins, from the begin of the bag
    wait : bool
        whether it waits until a topic has a subscriber

    Raises
    ------
    ValueError
        the bag or a number is not allowed
    """
    if not (math.isfinite(rate) and rate > 0.0):
        raise ValueError(f'--rate is {rate:g}; it must be a number above 0')
    bag = Playback(path)
    duration_s = (bag.end_ns - bag.begin_ns) / SECOND_NS
    if not 0.0 <= start_offset_s <= duration_s:
        raise ValueError(f'--start-offset is {start_offset_s:g}; it must be 0 to {duration_s:g} s')
    context = Context()
    init(context=context)
    node = rclpy.create_node('satdyn_replay', context=context, start_parameter_services=False)
    try:
        publishers = _publishers(node, bag)
        clock = None
        if publish_clock:
            publishers.pop('/clock', None)
            clock = node.create_publisher(Clock, '/clock', qos_profile(qos.CLOCK))
        if wait:
            _wait_for_subscriber(publishers)
        from_ns = bag.begin_ns + round(start_offset_s * SECOND_NS)
        count = _play(bag, from_ns, rate, publishers, clock)
        while loop:
            count += _play(bag, from_ns, rate, publishers, clock)
        _wait_until_taken(publishers)
        return count
    finally:
        node.destroy_node()
        context.try_shutdown()


def _wait_until_taken(publishers):
    for name, publisher in publishers.items():
        if not publisher.wait_for_all_acked(_ACKNOWLEDGED) and (why := unreached()):
            print(f'{name}: a subscriber did not take all{why}', file=sys.stderr)


def _publishers(node: Node, bag: Playback) -> dict[str, Publisher]:
    publishers = {}
    for name, type_name in bag.types.items():
        try:
            message = message_class(type_name)
        except (ImportError, AttributeError, ValueError):
            print(f'{name} is left out: {type_name} is not installed', file=sys.stderr)
            continue
        publishers[name] = node.create_publisher(message, name, qos_profile(bag.qos[name]))
    if not publishers:
        raise ValueError('none of the message types in the bag is installed')
    return publishers


def _wait_for_subscriber(publishers):
    """Return when there are subscribers and no new one has come for a moment."""
    before, since_s = None, time.monotonic()
    while not (any(before or ()) and time.monotonic() - since_s > _SETTLE_S):
        counts = [publisher.get_subscription_count() for publisher in publishers.values()]
        if counts != before:
            before, since_s = counts, time.monotonic()
        time.sleep(_LOOK_S)


def _play(bag, from_ns, rate, publishers, clock):
    """Publish once from a log time on, each message at its deadline; return how many."""
    count, now_ns = 0, None
    begin_s = time.monotonic()
    for log_time_ns, topic, data in bag.messages(list(publishers), from_ns):
        if log_time_ns != now_ns:
            now_ns = log_time_ns
            deadline_s = begin_s + (log_time_ns - from_ns) / SECOND_NS / rate
            while (left_s := deadline_s - time.monotonic()) > 0.0:
                time.sleep(min(left_s, _LONGEST_SLEEP_S))
            if clock is not None:
                clock.publish(Clock(clock=Time(nanoseconds=log_time_ns).to_msg()))
        publishers[topic].publish(data)
        count += 1
    return count
