"""
A satellite live for 20 s: the node in one process, a subscriber and a request in this one.

    make demo
    make demo WATCH=1

The node flies config/default.yaml, publishes at 100 Hz and records a bag.  This process listens,
computes from the messages alone how well the motion conserves its first integrals, requests new
initial conditions after ten seconds, and finally has the bag run again and compared byte for byte.
"""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

# No other nodes are heard, and none hear these.
os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')

import numpy as np
import rclpy
import rclpy.node
from geometry_msgs.msg import QuaternionStamped
from nav_msgs.msg import Odometry
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions

from satdyn_ros import Scenario
from satdyn_ros.bag.verify import verify
from satdyn_ros.dynamics.integrals import relative_drift
from satdyn_ros.dynamics.motion import States, joined
from satdyn_ros.kernel import rotation
from satdyn_ros.run.requests import requested
from satdyn_ros.run.ticks import Ticks

ROOT = Path(__file__).parent.parent
SCENARIO = ROOT / 'config/default.yaml'
BAGS = ROOT / 'bags'
SATDYN = [sys.executable, '-m', 'satdyn_ros.cli.main']
# WATCH=1: a page shows the satellite, long enough to look around.
WATCH = bool(os.environ.get('WATCH'))
SECONDS = 600 if WATCH else 20
REQUEST_AT_S = 10
REQUEST = {'initial.angular_velocity': [0.0, 0.0, 0.002]}
# Compiling the equations for the first time takes some of it.
START_TIMEOUT_S = 120.0


def main() -> int:
    """Run the demo and return the exit code: 0 if everything is as expected."""
    scenario = Scenario.from_yaml(SCENARIO).with_values({'time.epoch_ns': now_ns()})
    print(f'The node flies {SCENARIO.relative_to(ROOT)}; this process listens to it.')
    if not WATCH:
        print('To see it fly, in another terminal: .venv/bin/satdyn watch  (or make demo WATCH=1)')
    node = start_node(scenario.epoch_ns)
    page = subprocess.Popen([*SATDYN, 'watch'], cwd=ROOT) if WATCH else None
    # Either signal raises KeyboardInterrupt, and the other processes end with this one.
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    listener = Listener(scenario)
    try:
        listener.wait_for_message(node)
        for second in range(1, SECONDS + 1):
            listener.listen(1.0)
            print(listener.line(), flush=True)
            if second == REQUEST_AT_S:
                asking = start_request(listener)
        accepted = asking.wait() == 0
    except KeyboardInterrupt:
        return 130
    finally:
        if page is not None:
            page.send_signal(signal.SIGINT)
            page.wait(timeout=30.0)
        node.send_signal(signal.SIGINT)
        node_exit_code = node.wait(timeout=30.0)
        listener.destroy_node()
        rclpy.try_shutdown()
    is_well = summarise(listener)
    return 0 if is_well and accepted and node_exit_code == 0 else 1


def now_ns() -> int:
    """Return the wall clock, rounded to a second."""
    return round(time.time()) * 10**9


def start_node(epoch_ns: int) -> subprocess.Popen:
    """Start the node in a process of its own, recording from its first tick."""
    command = [*SATDYN, 'node', '--params-file', str(SCENARIO)]
    command += ['--ros-args', '-p', 'record.enabled:=true', '-p', f'record.directory:={BAGS}']
    command += ['-p', f'time.epoch_ns:={epoch_ns}']
    return subprocess.Popen(command, cwd=ROOT)


def start_request(listener: 'Listener') -> subprocess.Popen:
    """Ask for new initial conditions with `satdyn request`, which prints the answer."""
    asked = [f'{name}={value}'.replace(' ', '') for name, value in REQUEST.items()]
    print(f'\n$ satdyn request {" ".join(asked)}', flush=True)
    listener.conditions = requested(listener.scenario, REQUEST)
    return subprocess.Popen([*SATDYN, 'request', *asked], cwd=ROOT)


class Listener(rclpy.node.Node):
    """What a subscriber sees of the satellite: tick, attitude and rate of every message."""

    def __init__(self, scenario: Scenario):
        super().__init__('demo_listener')
        self.scenario = scenario
        self.conditions: Scenario | None = None
        self.restart_tick: int | None = None
        self.drift: dict[str, float] = {}
        self.largest_gap_s = 0.0
        self.ticks: dict[str, list[int]] = {'odometry': [], 'attitude_lvlh': []}
        self._stamps = Ticks(scenario.rate, scenario.epoch_ns)
        self._rows: list[tuple] = []
        self._rate_hz = 0.0
        self._begin: States | None = None
        self._now_drift: dict[str, float] = {}
        self._received_s: float | None = None
        self._q_lb = np.array([0.0, 0.0, 0.0, 1.0])
        one_second = QoSProfile(depth=int(scenario.rate))
        self.create_subscription(Odometry, 'odometry', self._take_odometry, one_second)
        self.create_subscription(QuaternionStamped, 'attitude_lvlh', self._take_lvlh, one_second)

    def listen(self, duration_s: float) -> None:
        """Receive messages for a time, then evaluate them."""
        begin_s = time.monotonic()
        end_s = begin_s + duration_s
        while (left_s := end_s - time.monotonic()) > 0.0:
            rclpy.spin_once(self, timeout_sec=left_s)
        rows, self._rows = self._rows, []
        self._rate_hz = len(rows) / (time.monotonic() - begin_s)
        if rows:
            self._judge(rows)

    def wait_for_message(self, node: subprocess.Popen) -> None:
        """Return at the first message; RuntimeError: the node ended or publishes nothing."""
        end_s = time.monotonic() + START_TIMEOUT_S
        while not self._rows:
            if node.poll() is not None or time.monotonic() > end_s:
                raise RuntimeError('the node publishes nothing')
            rclpy.spin_once(self, timeout_sec=0.1)

    def line(self) -> str:
        """Return a line of the present state: rate, time, attitude to LVLH, drift."""
        roll, pitch, yaw = np.degrees(rotation.roll_pitch_yaw(self._q_lb))
        t_s = self._stamps.seconds(self.ticks['odometry'][-1])
        drifts = ', '.join(f'{name} {value:+.1e}' for name, value in self._now_drift.items())
        return (
            f'{self._rate_hz:5.0f} Hz  t {t_s:7.2f} s  roll {roll:+8.3f}  pitch {pitch:+8.3f}  '
            f'yaw {yaw:+8.3f} deg  drift of {drifts}'
        )

    def _judge(self, rows):
        """Follow the first integrals through the rows, starting anew where a request acted."""
        ticks = np.array([row[0] for row in rows])
        if self.conditions is not None and self.restart_tick is None:
            for i, (tick, q_ib, omega_bi_b) in enumerate(rows):
                asked = self.conditions.state_at(self._stamps.seconds(tick))
                if np.allclose([*q_ib, *omega_bi_b], [*asked.q_ib, *asked.omega_bi_b], 0, 1e-14):
                    self.restart_tick = tick
                    self._follow(ticks[:i], rows[:i])
                    self._begin, ticks, rows = None, ticks[i:], rows[i:]
                    break
        self._follow(ticks, rows)

    def _follow(self, ticks, rows):
        if not rows:
            return
        nothing = np.full((len(rows), 1), np.nan)
        t_s = ticks / float(self.scenario.rate)
        states = States(
            t_s=t_s,
            q_ib=np.array([row[1] for row in rows]),
            omega_bi_b=np.array([row[2] for row in rows]),
            rotor_speed=nothing,
            rotor_angle=nothing,
            work=np.zeros(len(rows)),
            orbit=self.scenario.system.orbit,
            orbit_s=t_s,
        )
        if self._begin is None:
            self._begin = states.rows(slice(1))
        states = joined([self._begin, states])
        for name, values in relative_drift(self.scenario.system, states).items():
            self._now_drift[name] = float(values[-1])
            self.drift[name] = max(self.drift.get(name, 0.0), float(np.max(np.abs(values))))

    def _take_odometry(self, message):
        now_s = time.monotonic()
        if self._received_s is not None:
            self.largest_gap_s = max(self.largest_gap_s, now_s - self._received_s)
        self._received_s = now_s
        q, omega = message.pose.pose.orientation, message.twist.twist.angular
        tick = self._tick(message)
        self.ticks['odometry'].append(tick)
        self._rows.append((tick, (q.x, q.y, q.z, q.w), (omega.x, omega.y, omega.z)))

    def _take_lvlh(self, message):
        q = message.quaternion
        self._q_lb = np.array([q.x, q.y, q.z, q.w])
        self.ticks['attitude_lvlh'].append(self._tick(message))

    def _tick(self, message):
        stamp = message.header.stamp
        return self._stamps.tick_of(stamp.sec * 10**9 + stamp.nanosec)


def summarise(listener: Listener) -> bool:
    """Print a summary and return whether all of it is as expected."""
    received = sum(len(ticks) for ticks in listener.ticks.values())
    expected = sum(ticks[-1] - ticks[0] + 1 for ticks in listener.ticks.values())
    bag = max(BAGS.iterdir(), key=lambda path: path.stat().st_mtime)
    size = sum(path.stat().st_size for path in bag.iterdir())
    verdict = verify(bag)
    print(f'\nmessages    {received} received of {expected} expected, on odometry, attitude_lvlh')
    print(f'largest gap {1e3 * listener.largest_gap_s:.1f} ms between two of 10 ms')
    print(f'request     acted at tick {listener.restart_tick}, the stamps ran on')
    for name, drift in listener.drift.items():
        print(f'drift       of {name}: {drift:.1e} at most, relative')
    print(f'bag         {bag.relative_to(ROOT)}, {size / 1e6:.1f} MB')
    print(f'verify      {verdict}')
    return received == expected and listener.restart_tick is not None and verdict.is_true


if __name__ == '__main__':
    sys.exit(main())
