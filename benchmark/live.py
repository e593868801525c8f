"""The node live at 1000 Hz beside a bare loop and an rclpy timer, in CPU time a tick."""

import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from common import Claim, show

RATE_HZ, SECONDS = 1000, 8.0
ENVIRONMENT = os.environ | {'ROS_DOMAIN_ID': '88', 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}

PARAMETERS = """
/**:
  ros__parameters:
    publish: {{rate: {rate}, topics: [attitude, imu]}}
    record: {{enabled: {record}, directory: {directory}}}
"""

SUBSCRIBER = """
import rclpy
from geometry_msgs.msg import QuaternionStamped
from sensor_msgs.msg import Imu
from rclpy.executors import ExternalShutdownException
rclpy.init()
node = rclpy.create_node('subscriber')
for type_, topic in ((QuaternionStamped, 'attitude'), (Imu, 'imu')):
    node.create_subscription(type_, topic, lambda data: None, 1000, raw=True)
try:
    rclpy.spin(node)
except (KeyboardInterrupt, ExternalShutdownException):
    pass
"""

BARE = f"""
import time
import rclpy
from geometry_msgs.msg import QuaternionStamped
from sensor_msgs.msg import Imu
from rclpy.serialization import serialize_message
rclpy.init()
node = rclpy.create_node('bare')
attitude = node.create_publisher(QuaternionStamped, 'attitude', {RATE_HZ})
imu = node.create_publisher(Imu, 'imu', {RATE_HZ})
attitude_bytes = serialize_message(QuaternionStamped())
imu_bytes = serialize_message(Imu())
begin, k = time.monotonic(), 0
while True:
    wait = begin + k / {RATE_HZ} - time.monotonic()
    if wait > 0.0:
        time.sleep(wait)
    attitude.publish(attitude_bytes)
    imu.publish(imu_bytes)
    k += 1
"""

TIMER = f"""
import rclpy
from geometry_msgs.msg import QuaternionStamped
from sensor_msgs.msg import Imu
rclpy.init()
node = rclpy.create_node('timer')
attitude = node.create_publisher(QuaternionStamped, 'attitude', {RATE_HZ})
imu = node.create_publisher(Imu, 'imu', {RATE_HZ})
def tick():
    attitude.publish(QuaternionStamped())
    imu.publish(Imu())
node.create_timer(1.0 / {RATE_HZ}, tick)
rclpy.spin(node)
"""


def cpu_s(pid: int) -> float:
    """Return the CPU seconds that a process has used."""
    fields = Path(f'/proc/{pid}/stat').read_text().rsplit(')', 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


def start(arguments):
    """Start a Python process."""
    return subprocess.Popen(
        [sys.executable, *arguments],
        env=ENVIRONMENT,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def stop(process):
    """End a process as Ctrl-C does."""
    process.send_signal(signal.SIGINT)
    try:
        process.wait(5.0)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def node(directory, rate=RATE_HZ, record=True):
    """Start our node."""
    file = Path(directory) / 'parameters.yaml'
    file.write_text(
        PARAMETERS.format(rate=float(rate), record=str(record).lower(), directory=directory)
    )
    return start(['-m', 'satdyn_ros.cli', 'node', '--params-file', str(file)])


def cpu_of_a_tick(begin) -> float:
    """Return the CPU microseconds a tick of the process that begin starts."""
    process = begin()
    time.sleep(4.0)
    before, wall = cpu_s(process.pid), time.monotonic()
    time.sleep(SECONDS)
    used, passed = cpu_s(process.pid) - before, time.monotonic() - wall
    stop(process)
    return used / (passed * RATE_HZ) * 1e6


def pacing(directory, rate, record, seconds):
    """Return what our node's diagnostics say of its pacing over some seconds."""
    probe = f"""
import sys, time, rclpy
from diagnostic_msgs.msg import DiagnosticArray
rclpy.init()
node = rclpy.create_node('probe')
found = []
node.create_subscription(DiagnosticArray, '/diagnostics', found.append, 10)
end = time.monotonic() + {seconds}
while time.monotonic() < end:
    rclpy.spin_once(node, timeout_sec=0.5)
for array in (found[1], found[-1]):
    for status in array.status:
        if status.name.endswith('pacing'):
            print({{v.key: v.value for v in status.values}})
"""
    process = node(directory, rate, record)
    output = subprocess.run(
        [sys.executable, '-c', probe],
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    ).stdout
    stop(process)
    return output


def main(rounds=7):
    """Run all; return title, claims and text."""
    with tempfile.TemporaryDirectory() as directory:
        subscriber = start(['-c', SUBSCRIBER])
        contenders = {
            'ours': lambda: node(directory),
            'bare': lambda: start(['-c', BARE]),
            'timer': lambda: start(['-c', TIMER]),
        }
        cpu: dict[str, list[float]] = {name: [] for name in contenders}
        for _ in range(rounds):
            for name, begin in contenders.items():
                cpu[name].append(cpu_of_a_tick(begin))
        ours, bare, timer = (statistics.median(cpu[name]) for name in contenders)
        minute = pacing(directory, 1000, True, 63.0)
        stop(subscriber)
        fast = pacing(directory, 10000, False, 15.0)
    claims = [
        Claim(
            'CPU of a tick at 1000 Hz, recording, over a bare loop with ready bytes',
            f'{ours:.0f} us',
            f'{bare:.0f} us',
            ours / bare,
            1.3,
            at_most=True,
        ),
        Claim(
            'the same against an rclpy timer node that does not record',
            f'{ours:.0f} us',
            f'{timer:.0f} us',
            timer / ours,
            1.0,
        ),
    ]
    text = (
        f'Pacing at 1000 Hz, recording, one subscriber, first second and after a minute:\n\n'
        f'```\n{minute}```\n\nPacing at 10 000 Hz without recorder:\n\n```\n{fast}```'
    )
    print(text)
    return 'Live', show(claims), text


if __name__ == '__main__':
    main()
