"""A program that knows nothing of ROS: CycloneDDS prints what it hears on a topic of attitudes."""

import sys
import time
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import float64, int32, uint32
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration


@dataclass
class Time(IdlStruct, typename='builtin_interfaces::msg::dds_::Time_'):
    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct, typename='std_msgs::msg::dds_::Header_'):
    stamp: Time
    frame_id: str


@dataclass
class Quaternion(IdlStruct, typename='geometry_msgs::msg::dds_::Quaternion_'):
    x: float64
    y: float64
    z: float64
    w: float64


@dataclass
class QuaternionStamped(IdlStruct, typename='geometry_msgs::msg::dds_::QuaternionStamped_'):
    header: Header
    quaternion: Quaternion


def main(name, domain_id, count):
    participant = DomainParticipant(domain_id)
    qos = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(1000))
    reader = DataReader(participant, Topic(participant, name, QuaternionStamped, qos=qos), qos)
    end_s = time.monotonic() + 30.0
    while count > 0 and time.monotonic() < end_s:
        for sample in reader.take(N=100):
            stamp, q = sample.header.stamp, sample.quaternion
            values = (q.x.hex(), q.y.hex(), q.z.hex(), q.w.hex())
            print(stamp.sec * 10**9 + stamp.nanosec, sample.header.frame_id, *values)
            count -= 1
        time.sleep(0.01)


if __name__ == '__main__':
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
