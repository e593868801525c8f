"""The node live at 1000 Hz compared with a bare loop and an rclpy timer, in CPU time per tick."""

import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import yaml
from common import QUICK, Claim, medians, show
from copies import SENSORS

RATE_HZ = 1000
# Seconds until a process is measured, and for how long.
START_S, SECONDS = (0.0, 1.5) if QUICK else (4.0, 8.0)
WATCHED_S, FAST_S = (1, 1.0) if QUICK else (60, 23.0)
COPIES = str(Path(__file__).with_name('copies.py'))
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


def start(arguments, **kwargs):
    """Start a Python process, silent unless kwargs say otherwise."""
    silent = {'stdout': subprocess.DEVNULL, 'stderr': subprocess.DEVNULL}
    return subprocess.Popen([sys.executable, *arguments], env=ENVIRONMENT, **(silent | kwargs))


def stop(process):
    """End a process as Ctrl-C does; RuntimeError: it has ended by itself."""
    if process.poll() is not None:
        raise RuntimeError(f'{process.args} ended with {process.returncode}')
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
    return start(['-m', 'satdyn_ros.cli.main', 'node', '--params-file', str(file)])


def sensing_node(directory, *program):
    """Start our node with gyro and star tracker, run by a Python program."""
    file = Path(directory) / 'sensors.yaml'
    text = PARAMETERS.format(rate=float(RATE_HZ), record='true', directory=directory)
    file.write_text(text + f'    sensors: {yaml.safe_dump(SENSORS, default_flow_style=True)}')
    return start([*program, 'node', '--params-file', str(file)])


def cpu_of_a_tick(begin) -> float:
    """Return the CPU microseconds a tick of the process that begin starts."""
    process = begin()
    time.sleep(START_S)
    before, wall = cpu_s(process.pid), time.monotonic()
    time.sleep(SECONDS)
    used, passed = cpu_s(process.pid) - before, time.monotonic() - wall
    stop(process)
    return used / (passed * RATE_HZ) * 1e6


WATCH = """
import struct, sys, time
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import QuaternionStamped
rclpy.init()
node = rclpy.create_node('watch')
stamps, reports = [], []
if sys.argv[2] == 'stamps':
    def take(data):
        seconds, nanoseconds = struct.unpack_from('<iI', data, 4)
        stamps.append(seconds * 10**9 + nanoseconds)
    node.create_subscription(QuaternionStamped, 'attitude', take, 1000, raw=True)
node.create_subscription(DiagnosticArray, '/diagnostics', reports.append, 10)
end = time.monotonic() + float(sys.argv[1])
while time.monotonic() < end or len(reports) < 3:
    rclpy.spin_once(node, timeout_sec=0.5)
def pacing(report):
    status, = (s for s in report.status if s.name.endswith('pacing'))
    return {v.key: v.value for v in status.values}
first, last = pacing(reports[1]), pacing(reports[-1])
missing = (stamps[-1] - stamps[0]) // 10**6 + 1 - len(stamps) if stamps else 0
for value in (
    len(stamps),
    missing,
    int(last['tick']) - int(first['tick']),
    len(reports) - 2,
    last['late ticks since start'],
    max(float(pacing(r)['largest lag [s]']) for r in reports[1:]),
):
    print(value)
"""

LATE = BARE.replace(
    '    attitude.publish(',
    f"""    lag = time.monotonic() - begin - k / {RATE_HZ}
    late, largest = late + (lag > 1.0 / {RATE_HZ}), max(largest, lag)
    if k == {WATCHED_S} * {RATE_HZ}:
        print(late, largest)
        break
    attitude.publish(""",
).replace('begin, k =', 'late, largest, begin, k = 0, 0.0,')


def watched(directory, rate, record, seconds, what):
    """Return what a subscriber sees of our node in some seconds, and of its reports of pacing."""
    process = node(directory, rate, record)
    output = subprocess.run(
        [sys.executable, '-c', WATCH, str(seconds), what],
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
        timeout=seconds + 60.0,
    ).stdout
    stop(process)
    return [float(value) for value in output.split()]


BUSY, LOADED_S = (1, 0.5) if QUICK else (4, 30.0)
REALTIME = '    realtime: {priority: 50, cpu: 1, lock_memory: true}\n'

LATENESS = BARE.replace(
    '    attitude.publish(',
    f"""    lags_ns.append((time.monotonic() - begin - k / {RATE_HZ}) * 1e9)
    if k == {LOADED_S} * {RATE_HZ}:
        lateness.add(lags_ns)
        print(lateness)
        break
    attitude.publish(""",
).replace(
    'begin, k =',
    'from satdyn_ros.ros.lateness import Lateness\nlateness, lags_ns = Lateness(), []\nbegin, k =',
)


def loaded(process) -> str:
    """Return what a process reports of its lateness at its end."""
    output = process.communicate()[0]
    return next(line[line.index('lateness') :] for line in output.splitlines() if 'late' in line)


def node_under_load(directory, realtime: str) -> str:
    """Return the lateness of our node, with some lines of parameters more."""
    file = Path(directory) / 'loaded.yaml'
    text = PARAMETERS.format(rate=float(RATE_HZ), record='true', directory=directory)
    file.write_text(text + realtime)
    arguments = ['-m', 'satdyn_ros.cli.main', 'node', '--params-file', str(file)]
    process = start(arguments, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if QUICK:
        next(line for line in process.stdout if 'publishing' in line)
        time.sleep(LOADED_S)
    else:
        time.sleep(LOADED_S + 5.0)
    process.send_signal(signal.SIGINT)
    return loaded(process)


def under_load(directory) -> dict[str, str]:
    """Return the lateness of a bare loop and our node, with and without real time, beside load."""
    busy = [start(['-c', 'while True: pass']) for _ in range(BUSY)]
    try:
        bare = start(['-c', LATENESS], stdout=subprocess.PIPE, text=True)
        return {
            'bare loop': loaded(bare),
            'node': node_under_load(directory, ''),
            'node with realtime.*': node_under_load(directory, REALTIME),
        }
    finally:
        for process in busy:
            process.kill()
            process.wait()


def bare_minute():
    """Return the late ticks and the largest lag [s] of a bare loop in a minute."""
    output = subprocess.run(
        [sys.executable, '-c', LATE],
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    ).stdout
    return [float(value) for value in output.split()]


def main(rounds=7):
    """Run all; return title, claims and text."""
    with tempfile.TemporaryDirectory() as directory:
        subscriber = start(['-c', SUBSCRIBER])
        contenders = {
            'ours': lambda: cpu_of_a_tick(lambda: node(directory)),
            'bare': lambda: cpu_of_a_tick(lambda: start(['-c', BARE])),
            'timer': lambda: cpu_of_a_tick(lambda: start(['-c', TIMER])),
            'sensed': lambda: cpu_of_a_tick(
                lambda: sensing_node(directory, '-m', 'satdyn_ros.cli.main')
            ),
            'copied': lambda: cpu_of_a_tick(lambda: sensing_node(directory, COPIES)),
        }
        ours, bare, timer, sensed, copied = medians(contenders, rounds).values()
        bare_late, bare_lag = bare_minute()
        stop(subscriber)
        beside_load = under_load(directory)
        seen, missing, _, _, late, lag = watched(
            directory, RATE_HZ, True, WATCHED_S + 3.0, 'stamps'
        )
        _, _, ticks, seconds, fast_late, fast_lag = watched(
            directory, 10 * RATE_HZ, False, FAST_S, 'diagnostics'
        )
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
        ),
        Claim(
            'the same with gyro and star tracker over two further topics of this size',
            f'{sensed:.0f} us',
            f'{copied:.0f} us',
            sensed / copied,
            1.15,
            at_most=True,
        ),
        Claim(
            'ticks missing among those a subscriber receives in a minute at 1000 Hz, recording',
            f'{missing:.0f}',
            f'of {seen:.0f}',
            missing,
            0.0,
            at_most=True,
        ),
        Claim(
            'ticks late by more than 1 ms in that minute, beside a bare loop',
            f'{late:.0f}, at most {lag * 1e3:.1f} ms',
            f'{bare_late:.0f}, at most {bare_lag * 1e3:.1f} ms',
            late / max(bare_late, 1.0),
        ),
        Claim(
            'ticks a second at 10 000 Hz without recorder, over those asked for',
            f'{ticks / seconds:.0f}',
            f'{10 * RATE_HZ}',
            ticks / seconds / (10 * RATE_HZ),
            0.999,
        ),
    ]
    text = (
        f'At 10 000 Hz {fast_late:.0f} ticks were late by more than 0.1 ms, at most '
        f'{fast_lag * 1e3:.1f} ms.\nNo tick is ever left out: one that is late is published late.'
        f'\n\nAt {RATE_HZ} Hz, recording, on {os.cpu_count()} processors beside {BUSY} busy '
        'processes:\n\n'
    ) + '\n'.join(f'- {name}: {lateness}' for name, lateness in beside_load.items())
    print(text)
    return 'Live', show(claims), text


if __name__ == '__main__':
    main()
