"""What the node reports each second on /diagnostics, in diagnostic_updater's form."""

import time
from collections import Counter
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.subscription import Subscription

from ..actuators import Command
from ..dynamics.integrals import relative_drift
from ..dynamics.motion import Motion, States, joined
from ..messages import qos
from ..run.events import Event, RotorLimited
from ..run.samples import Samples
from ..run.simulation import Simulation
from .inputs import InputCounts
from .lateness import LATE_PART, Pace
from .pacing import Pacing
from .publishing import STEADY, qos_profile

if TYPE_CHECKING:
    from .recorder import Recorder

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
Report = tuple[bytes, str, dict[str, Any]]

_PERIOD_S = 1.0
_WALL = Clock(clock_type=ClockType.SYSTEM_TIME)
# A hundred orbits drift by some 200 tolerances; far more means that something is wrong.
_WARN_TOLERANCES, _ERROR_TOLERANCES = 1e4, 1e7
_LARGEST_WARN, _LARGEST_ERROR = 1e-3, 1e-1
# A queue so full is about to make ticks late.
_HIGH_LOAD = 0.5


class Diagnostics:
    """A report of each part of the node, by its name, once a second of the wall clock."""

    def __init__(self, node: Node, parts: dict[str, Callable[[], Report]]):
        self._node, self._parts = node, parts
        self._publisher = node.create_publisher(
            DiagnosticArray, '/diagnostics', qos_profile(qos.DIAGNOSTICS)
        )
        node.create_timer(_PERIOD_S, self._publish, clock=STEADY)

    def _publish(self):
        message = DiagnosticArray()
        message.header.stamp = self._now().to_msg()
        satellite = self._node.get_fully_qualified_name().lstrip('/')
        for part, report in self._parts.items():
            level, text, values = report()
            message.status.append(
                DiagnosticStatus(
                    level=level,
                    name=f'{satellite}: {part}',
                    message=text,
                    hardware_id=satellite,
                    values=[KeyValue(key=key, value=_text(x)) for key, x in values.items()],
                )
            )
        self._publisher.publish(message)

    def _now(self):
        """Return the time of the node's clock; while that waits for /clock, of the wall clock."""
        now = self._node.get_clock().now()
        if now.nanoseconds:
            return now
        self._node.get_logger().warning(
            'use_sim_time is true, but there is no /clock: the diagnostics use the wall clock',
            once=True,
        )
        return _WALL.now()


class PropagationReport:
    """The drift of the first integrals since the last event."""

    def __init__(self, tolerance: float):
        self._warn = min(_WARN_TOLERANCES * tolerance, _LARGEST_WARN)
        self._error = min(_ERROR_TOLERANCES * tolerance, _LARGEST_ERROR)
        self._latest: tuple[Motion, States, Samples] | None = None

    def take(self, motion: Motion, samples: Samples) -> None:
        """Process the next samples of a motion."""
        if self._latest is None or motion is not self._latest[0]:
            self._latest = motion, samples.states.rows(slice(1)), samples
        else:
            self._latest = motion, self._latest[1], samples

    def __call__(self) -> Report:
        """Return the state of the propagation."""
        if self._latest is None:
            return OK, 'no tick yet', {}
        motion, begin, samples = self._latest
        states = joined([begin, samples.states.rows(slice(-1, None))])
        drift = {k: float(x[-1]) for k, x in relative_drift(samples.system, states).items()}
        largest = max((abs(x) for x in drift.values()), default=0.0)
        level = ERROR if not largest <= self._error else WARN if largest > self._warn else OK
        values = {'motion': motion.name, 'tick': samples.first_tick + len(samples) - 1}
        values |= {
            name: getattr(motion, name) for name in ('steps', 'tolerance') if hasattr(motion, name)
        }
        values |= {f'relative drift of {name}': x for name, x in drift.items()}
        if level == OK:
            return level, f'the first integrals drift by {largest:.1e}', values
        return level, f'the first integrals drift by {largest:.1e}, above {self._warn:.0e}', values


class PacingReport:
    """
    How punctual the ticks are.

    warn(sentence): called when the factor that is asked for is not reached, see Pace.
    """

    def __init__(self, pacing: Pacing, rate_hz: float, warn: Callable[[str], object]):
        self._pacing, self._rate_hz, self._warn = pacing, rate_hz, warn
        self._pace = Pace(rate_hz)
        self._late_ticks = 0
        self._since_tick, self._since_s = pacing.tick, time.monotonic()

    def __call__(self) -> Report:
        """Return the state of the pacing since the last call."""
        pacing = self._pacing
        counted, tick, now_s = pacing.take_punctuality(), pacing.tick, time.monotonic()
        passed, duration_s = tick - self._since_tick, now_s - self._since_s
        reached = passed / self._rate_hz / duration_s
        self._since_tick, self._since_s = tick, now_s
        has_pace = pacing.is_alive and not (pacing.is_paused or pacing.halted)
        factor = pacing.factor if has_pace else 0.0
        if sentence := self._pace.take(factor, passed, counted, duration_s):
            self._warn(sentence)
        self._late_ticks += counted.late_ticks
        values = {
            'tick': tick,
            'factor asked for': pacing.factor,
            'factor reached': f'{reached:.4g}',
            'late ticks': counted.late_ticks,
            'late ticks since start': self._late_ticks,
            'largest lag [s]': f'{counted.largest_lag_ns * 1e-9:.6f}',
            'restarts of the deadlines': counted.restarts,
        }
        if len(pacing.lateness):
            values |= pacing.lateness.values()
        if not pacing.is_alive:
            return ERROR, 'the ticks have ended', values
        if pacing.halted:
            return ERROR, f'halted after tick {tick}: {pacing.halted}', values
        if pacing.is_paused:
            return OK, f'paused after tick {tick}', values
        if counted.restarts or counted.late_ticks > LATE_PART * passed:
            text = f'{counted.late_ticks} ticks came late, the factor reached is {reached:.4g}'
            return WARN, text, values
        return OK, f'the factor reached is {reached:.4g}', values


def connections_report(
    publishers: Mapping[str, Publisher], subscriptions: Mapping[str, Subscription]
) -> Report:
    """
    Return how many others each topic is connected with.

    Discovery goes both ways: before a publisher is counted here, what it publishes is lost.
    """
    listeners = {
        f'subscribers of {name}': publisher.get_subscription_count()
        for name, publisher in publishers.items()
    }
    talkers = {
        f'publishers of {name}': subscription.get_publisher_count()
        for name, subscription in subscriptions.items()
    }
    text = f'{sum(listeners.values())} subscribers, {sum(talkers.values())} publishers'
    return OK, text, listeners | talkers


def recorder_report(recorder: 'Recorder | None') -> Report:
    """Return the state of the recorder."""
    if recorder is None:
        return OK, 'not recording', {}
    values = {
        'bag': recorder.directory,
        'messages': recorder.message_count,
        'bytes': recorder.size_bytes,
        'queue': f'{recorder.load:.0%}',
    }
    if recorder.failure is not None:
        return ERROR, recorder.failure, values
    if recorder.load > _HIGH_LOAD:
        return WARN, f'the disk is slow: the queue is {recorder.load:.0%} full', values
    return OK, 'recording', values


class InputsReport:
    """
    What acts of the commands, what limits cut, and messages refused or lost.

    published(): samples and the row of the tick that was published last, None before the first.
    """

    def __init__(
        self,
        counts: InputCounts,
        simulation: Simulation,
        published: Callable[[], tuple[Samples, int] | None],
    ):
        self._counts, self._simulation, self._published = counts, simulation, published
        self._refused = self._lost = 0
        self._limited: Counter[str] = Counter()

    def take(self, applied: list[Event]) -> None:
        """Process the events of a tick."""
        equipment = self._simulation.scenario.equipment
        for event in applied:
            if isinstance(event, RotorLimited) and event.limit == 'max_speed':
                self._limited[event.limit] += 1
            elif isinstance(event, Command):
                actuator = equipment.of_topic[event.topic]
                held = actuator.held(event.topic, event.value)
                cut = sum(actuator.within(name, x) != x for name, x in held.items())
                self._limited[actuator.limit] += cut

    def __call__(self) -> Report:
        """Return the state of the inputs."""
        counts, simulation = self._counts, self._simulation
        system = simulation.system
        values: dict[str, Any] = {
            'rotor torques that act [N m]': self._rotor_torques(),
            'rotor speeds that are commanded [rad/s]': tuple(system.rotor_target.tolist()),
            'limited at max_speed': self._limited['max_speed'],
        }
        for actuator in simulation.scenario.equipment.actuators:
            values |= actuator.report(simulation.acting)
            if actuator.limit and actuator.topics:
                values[f'{actuator.limiting} {actuator.limit}'] = self._limited[actuator.limit]
        values |= {
            'accepted': counts.accepted,
            'refused': counts.refused,
            'lost on the way': counts.lost,
        }
        refused, self._refused = counts.refused - self._refused, counts.refused
        lost, self._lost = counts.lost - self._lost, counts.lost
        if refused:
            return WARN, f'{refused} refused: {counts.reason}', values
        if lost:
            return WARN, f'{lost} lost on the way', values
        return OK, f'{counts.accepted} accepted', values

    def _rotor_torques(self):
        # Not those of the simulation, which another thread takes ahead of what is published.
        if (published := self._published()) is None:
            return tuple(self._simulation.system.rotor_torque.tolist())
        samples, row = published
        return tuple(samples.rotor_torque[row].tolist())


def _text(value):
    return f'{value:.3g}' if isinstance(value, float) else str(value)
