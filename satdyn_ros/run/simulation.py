"""Scenario and events to samples at ticks: no ROS and no clock of its own."""

import copy
from bisect import insort
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ..dynamics.motion import Motion
from ..dynamics.propagator import Propagation
from ..dynamics.system import State, System
from ..sensors import Measurements, Suite
from .arc import MOST_STEPS_A_TICK, Arc
from .events import (
    Event,
    Halt,
    Request,
    Reset,
    RotorCommand,
    RotorLimited,
    Timeout,
    Topics,
    Torque,
    TorquesDropped,
    body_torque,
    rotor_torques,
)
from .key import listed
from .limits import has_max_speed, is_too_fast, within_max_torque
from .requests import requested
from .samples import Measured, Samples
from .scenario import Scenario
from .ticks import Ticks


class RunHalted(RuntimeError):  # noqa: N818
    """The end of a run whose motion cannot go on; its text is one sentence."""


class Simulation:
    """
    A run, tick by tick: the engine of the node, of offline runs and of learning loops.

    events: what happens at ticks to come, in their order.  ValueError: as Scenario.motion.

    Where the next tick cannot be reached (too many steps, or a stamp that ROS cannot hold), the
    torques are dropped; if none acts, the run halts until a request or reset.  Both are events
    too, decided by the motion alone: given ones that do not follow from it are ignored.

    >>> simulation = Simulation(Scenario.from_yaml('config/default.yaml'))  # doctest: +SKIP
    >>> state = simulation.step(torque_b=(0, 0, 0.01))  # doctest: +SKIP
    """

    def __init__(self, scenario: Scenario, events: Iterable[Event] = ()):
        self.scenario = self.conditions = scenario.with_seed()
        self.topics = scenario.topics
        self.ticks = Ticks(scenario.rate, scenario.epoch_ns)
        self.next_tick = 0
        # The limits of rotors follow from the run itself.
        given: list[Event] = [e for e in events if not isinstance(e, RotorLimited)]
        self._pending = deque(sorted(given, key=_tick_of))
        self._system = scenario.system
        self._until: dict[str, int] = {}
        self._torque_of_step = False
        self._rotors_of_step: frozenset[str] = frozenset()
        self._block: Samples | None = None
        self.halted: str | None = None
        # The sensors before the next tick, and before the first tick of the block.
        self._suite = self._suite_of_block = Suite.of(self.scenario.sensors)
        self._restart(0, scenario.initial_state)

    # -- forward ---------------------------------------------------------------------------------

    def advance(self, count: int) -> tuple[list[Event], Samples]:
        """
        Return the events of the next tick, now applied, and the samples from it on.

        At most count ticks, none beyond the next event or where a rotor reaches its limit, and
        none at all of a halted run.
        """
        first = self.next_tick
        applied = self._apply_events(first) + self._limit_speeds(first)
        event_ticks = self._event_ticks(first)
        last = min([first + count, *event_ticks])
        states = self._arc.states(first, last, last in event_ticks)
        if not len(states):
            applied += self._make_way(first)
            states = self._arc.states(first, last)
        if has_max_speed(self._system):
            too_fast = np.any(is_too_fast(self._system, states.rotor_speed), axis=-1)
            if np.any(too_fast):
                states = states.rows(slice(int(np.argmax(too_fast))))
        last = first + len(states)
        measured = {}
        if len(states):
            self._suite_of_block = self._suite
            found, self._suite = self._suite.measure(range(first, last), states)
            measured = {name: self._stamped(some, first) for name, some in found.items()}
        stamps_ns = self.ticks.stamps_ns(first, last)
        self._block = Samples(first, stamps_ns, states, self._system, measured)
        self.next_tick = last
        return applied, self._block

    def rewind(self, tick: int) -> None:
        """Go back to a tick of the last samples: what comes from it on has not happened."""
        self._suite = self._suite_at(tick)
        self.next_tick = tick

    def begin_from(self, state: State) -> None:
        """Let the motion in force begin from another state: the last samples come anew."""
        begin_tick = self._arc.begin_tick
        if self._block is not None:
            self.rewind(self._block.first_tick)
        self._restart(begin_tick, state)
        self._arc.catch_up(self.next_tick)

    def schedule(self, event: Event) -> None:
        """Add an event at its tick, the next one or later."""
        insort(self._pending, event, key=_tick_of)

    def accept(self, values: Mapping[str, Any]) -> None:
        """Put new initial conditions in force; ValueError: they are not allowed."""
        self.conditions = requested(self.conditions, values)

    def timeout_tick(self, tick: int, timeout_s: float) -> int | None:
        """Return the tick at which a torque of this tick drops to zero, None: never."""
        return tick + self.ticks.ceil(timeout_s) if timeout_s > 0.0 else None

    # -- step by step ----------------------------------------------------------------------------

    @property
    def tick(self) -> int:
        """The last tick that has happened, -1 before the first."""
        return self.next_tick - 1

    @property
    def state(self) -> State:
        """The state at the last tick; before the first, the initial one."""
        return self._arc.state_at(max(self.tick, 0))

    @property
    def system(self) -> System:
        """What moves, with the torques that act."""
        return self._system

    @property
    def sensors(self) -> Suite:
        """The sensors before the next tick."""
        return self._suite

    @property
    def motion(self) -> Motion:
        """The motion since the last event."""
        return self._arc.motion

    def step(
        self,
        torque_b: Sequence[float] | np.ndarray | None = None,
        rotor_torque: Mapping[str, float] | None = None,
    ) -> State:
        """
        Advance by one tick and return the state there.

        torque_b [N m] (3,), body axes, and rotor_torque [N m], by rotor, hold during this step
        alone; without them, and for rotors not named, what is in force continues.  The first step
        is from tick 0 to tick 1.  ValueError: there is no such motor, or a torque is not finite.
        RunHalted: the run goes no further.
        """
        torques = rotor_torques(rotor_torque or {}, self.scenario)
        torque = (0.0, 0.0, 0.0) if torque_b is None else body_torque(torque_b)
        if self.next_tick == 0:
            self.advance(1)
        ended = {name: 0.0 for name in self._rotors_of_step - torques.keys()}
        self._rotors_of_step = frozenset(torques)
        if ended or torques:
            self.rewind(self.tick)
            self.schedule(RotorCommand(self.next_tick, ended | torques))
            self.advance(1)
        if torque_b is not None or self._torque_of_step:
            self._torque_of_step = torque_b is not None
            if torque != tuple(self._system.torque_b):
                self.rewind(self.tick)
                self.schedule(Torque(self.next_tick, torque))
                self.advance(1)
        self.advance(1)
        if self.halted:
            raise RunHalted(self.halted)
        return self.state

    def request(self, values: Mapping[str, Any]) -> None:
        """Restart at the next tick from new initial conditions; ValueError: not allowed."""
        self.accept(values)
        self.schedule(Request(self.next_tick, dict(values)))

    def reset(self) -> None:
        """Restart at the next tick from the initial conditions in force."""
        self.schedule(Reset(self.next_tick))

    # -- events ----------------------------------------------------------------------------------

    def _event_ticks(self, tick):
        """Return the ticks after this one at which events may follow, the first among them."""
        pending = [self._pending[0].tick] if self._pending else []
        return [later for later in (*pending, *self._until.values()) if later > tick]

    def _apply_events(self, tick):
        """Apply the events due at a tick; return those that happened."""
        due: list[Event] = [
            Timeout(tick, topic) for topic, until in self._until.items() if until <= tick
        ]
        while self._pending and self._pending[0].tick <= tick:
            due.append(self._pending.popleft())
        return [happened for event in due for happened in self._apply(event, tick)]

    def _apply(self, event, tick):
        """Apply an event; return what happened, its consequences first."""
        match event:
            case Request():
                self.conditions = self.conditions.with_values(event.values)
                self._restart_from_conditions(tick)
            case Reset():
                self._restart_from_conditions(tick)
            case Torque():
                self._hold('torque', event.until_tick)
                return [*self._drive(tick, torque_b=np.array(event.torque_b, float)), event]
            case RotorCommand():
                for name in event.torques:
                    self._hold(f'rotor_command.{name}', event.until_tick)
                acting, cut = within_max_torque(self._system, event.torques)
                happened = [*self._drive(tick, rotor_torque=acting), event]
                return happened + [RotorLimited(tick, name, 'max_torque') for name in cut]
            case Timeout(topic='torque'):
                self._hold('torque', None)
                return [*self._drive(tick, torque_b=np.zeros(3)), event]
            case Timeout():
                name = _rotor_of(event.topic)
                self._hold(f'rotor_command.{name}', None)
                acting, _ = within_max_torque(self._system, {name: 0.0})
                return [*self._drive(tick, rotor_torque=acting), event]
            case Topics():
                self.topics = event.names
            case TorquesDropped() | Halt():
                # Nothing else shows that they are true: of the events that follow at this tick, a
                # request would continue the run without this motion.
                return self._make_way(tick, type(event))
        return [event]

    def _make_way(self, tick, *kinds):
        """
        Drop the torques, or else halt, where the motion does not reach a tick.

        kinds: which of both may happen, each if none is given.  Return the events that happened.
        """
        happened = []
        while self.halted is None and not len(self._arc.states(tick, tick + 1)):
            event = TorquesDropped(tick) if self._has_torque else Halt(tick)
            if kinds and not isinstance(event, kinds):
                break
            if self._has_torque:
                state = self._arc.state_at(tick - 1)
                self._until = {}
                none = np.zeros(len(self._system.rotors))
                self._system = self._system.driven(np.zeros(3), none)
                self._restart(tick - 1, state)
            else:
                self.halted = self._arc.why_no_further
            happened.append(event)
        return happened

    @property
    def _has_torque(self):
        return bool(np.any(self._system.torque_b) or np.any(self._system.rotor_torque))

    def _limit_speeds(self, tick):
        """Drop torques that make a rotor at its limit faster; return what happened."""
        if not has_max_speed(self._system) or self.halted:
            return []
        if not len(self._arc.states(tick, tick + 1)):
            return []
        too_fast = is_too_fast(self._system, self._arc.state_at(tick).rotor_speed)
        dropped = [self._system.rotors[i].label for i in np.flatnonzero(too_fast)]
        for name in dropped:
            self._hold(f'rotor_command.{name}', None)
        acting, _ = within_max_torque(self._system, dict.fromkeys(dropped, 0.0))
        happened = self._drive(tick, rotor_torque=acting)
        return [*happened, *(RotorLimited(tick, name, 'max_speed') for name in dropped)]

    def _hold(self, topic, until_tick):
        # A new dictionary each time: as_it_is() keeps the one that it has.
        held = {name: until for name, until in self._until.items() if name != topic}
        self._until = held if until_tick is None else held | {topic: until_tick}

    def _drive(self, tick, **torques):
        """
        Let torques act from a tick on; a torque that already acts changes nothing.

        Return what happened before that, where the motion so far does not reach the tick.
        """
        acting = vars(self._system)
        if all(np.array_equal(acting[name], torque) for name, torque in torques.items()):
            return []
        happened = self._make_way(tick)
        driven = self._system.driven(**torques)
        if self.halted:
            self._system = driven
            return happened
        state = self._arc.state_at(tick)
        self._system = driven
        self._restart(tick, state)
        return happened

    def _restart_from_conditions(self, tick):
        acting = self._system
        self._system = self.conditions.system.driven(acting.torque_b, acting.rotor_torque)
        self._suite = self._suite.restarted()
        start_s = self.ticks.seconds(tick)
        state = self.conditions.state_at(start_s)
        try:
            self._restart(tick, state)
        except ValueError as error:
            # At the earlier tick of its check, rounding had not yet cost it its closed form.
            self._begin(tick, Propagation(self._system, state, start_s))
            self._arc.halt(tick, str(error))

    def _restart(self, tick, state):
        start_s = self.ticks.seconds(tick)
        self._begin(
            tick, self.scenario.motion_from(self._system, state, start_s, MOST_STEPS_A_TICK)
        )

    def _begin(self, tick, motion):
        self._arc, self._block, self.halted = Arc(self.ticks, tick, motion), None, None

    def _stamped(self, measurements: Measurements, first: int) -> Measured:
        stamps_ns = self.ticks.stamps_of(measurements.exposed)
        return Measured(measurements.ticks - first, stamps_ns, measurements.values)

    def _suite_at(self, tick):
        """Return the sensors before a tick of the last samples."""
        block = self._block
        if block is None or tick == block.first_tick:
            return self._suite_of_block
        before = block.states.rows(slice(tick - block.first_tick))
        return self._suite_of_block.measure(range(block.first_tick, tick), before)[1]

    # -- snapshots -------------------------------------------------------------------------------

    def as_it_is(self) -> 'Simulation':
        """Return a copy, of which another thread may ask for snapshots while the run goes on."""
        kept = copy.copy(self)
        # With states of its own it need not ask the motion, which walks on.
        kept._arc = copy.copy(self._arc)
        return kept

    def snapshot(self, tick: int) -> dict[str, Any]:
        """
        Return, as plain data, all that the run depends on from a tick of the last samples on.

        The start of the motion and the state there (so that the same bits come again), the state
        at the tick, the torques that act with the ticks where they end, the conditions in force,
        the topics and the sensors' memories.
        """
        return {
            'tick': tick,
            'state': _state_record(self._arc.state_at(tick)),
            'begin_tick': self._arc.begin_tick,
            'begin_state': _state_record(self._arc.motion.state),
            'torque_b': [float(x) for x in self._system.torque_b],
            'rotor_torque': self._system.rotor_torque.tolist(),
            'until': dict(self._until),
            'conditions': {
                name: listed(value)
                for name, value in self.conditions.values.items()
                if name in self.conditions.initial_conditions
            },
            'topics': list(self.topics),
            'sensors': self._suite_at(tick).to_plain(),
        }

    @classmethod
    def from_snapshot(
        cls, scenario: Scenario, snapshot: Mapping[str, Any], events: Iterable[Event] = ()
    ) -> 'Simulation':
        """Return the run that continues at a snapshot's tick."""
        simulation = cls(scenario, events)
        simulation.conditions = scenario.with_values(snapshot['conditions'])
        simulation.topics = tuple(snapshot['topics'])
        simulation._until = {
            topic if topic == 'torque' else f'rotor_command.{_rotor_of(topic)}': until
            for topic, until in snapshot['until'].items()
        }
        simulation._system = simulation.conditions.system.driven(
            np.array(snapshot['torque_b']), np.array(snapshot['rotor_torque'])
        )
        begin = snapshot['begin_state']
        state = State(
            np.array(begin['q_ib']),
            np.array(begin['omega_bi_b']),
            begin['rotor_speed'],
            begin['rotor_angle'],
        )
        simulation._restart(snapshot['begin_tick'], state)
        # Version 0.1 had no sensors.
        suite = simulation._suite.with_memories(snapshot.get('sensors', {}))
        simulation._suite = simulation._suite_of_block = suite
        simulation.next_tick = snapshot['tick']
        simulation._arc.catch_up(simulation.next_tick)
        return simulation


def _tick_of(event):
    return event.tick


def _rotor_of(topic):
    """Return the rotor of a held torque; version 0.1 had one, whose topic was rotor_torque."""
    return topic.removeprefix('rotor_command.') if topic != 'rotor_torque' else 'rotor'


def _state_record(state):
    return {
        'q_ib': [float(x) for x in state.q_ib],
        'omega_bi_b': [float(x) for x in state.omega_bi_b],
        'rotor_speed': state.rotor_speed.tolist(),
        'rotor_angle': state.rotor_angle.tolist(),
    }
