"""What a run depends on, and what a tick makes of it."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import reduce
from operator import add
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from ..dynamics.drives import AT_LIMIT
from ..dynamics.motion import States
from ..dynamics.system import State, System
from ..integrate.propagation import Propagation
from ..sensors import Suite
from .events import (
    DipoleCommand,
    Event,
    Halt,
    Request,
    Reset,
    RotorCommand,
    RotorLimited,
    Timeout,
    Topics,
    Torque,
    TorqueB,
    TorquesDropped,
)
from .requests import resolved
from .rules import EVENTS_FOLLOW, RULES
from .scenario import Scenario
from .segment import MOST_STEPS_A_TICK, Segment
from .ticks import Ticks
from .topics import MAGNETORQUERS, is_torque

_NONE: Mapping[str, float] = MappingProxyType({})
NO_TORQUE: TorqueB = (0.0, 0.0, 0.0)
NO_DIPOLE = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class RunState:
    """
    All that a run depends on from a tick on; it never changes.

    segment: the motion in force.  system: what moves, with the torques that act.  conditions: the
    scenario, with the initial conditions in force.  topics: those published.  suite: the sensors
    before the tick's samples.  torques_b: by topic the applied torques, whose sum acts.  until: by
    held torque (its topic, 'rotor_command.NAME') the tick where it ends.  halted: why no tick
    follows, in one sentence, None: one can.  told: the last tick of a snapshot from which the run
    goes on, whose limits have been told.
    """

    ticks: Ticks
    segment: Segment
    system: System
    conditions: Scenario
    topics: tuple[str, ...]
    suite: Suite
    torques_b: Mapping[str, TorqueB]
    until: Mapping[str, int] = field(default_factory=dict)
    halted: str | None = None
    told: int = -1

    def restarted(self, tick: int, state: State, system: System) -> 'RunState':
        """
        Return the run whose motion begins at a tick, from a state and with the torques of system.

        ValueError: motion.method is exact and there is no closed form.
        """
        start_s = self.ticks.seconds(tick)
        motion = self.conditions.motion_from(system, state, start_s, MOST_STEPS_A_TICK)
        segment = Segment(self.ticks, tick, motion, self.suite.counts_turns)
        return replace(self, segment=segment, system=system, halted=None)

    def turned_to(self, tick: int) -> 'RunState':
        """Return the run whose sensors have counted the turn to a tick, where its motion ends."""
        turn_b = self.segment.states(tick, tick + 1).turn_b
        return self if turn_b is None else replace(self, suite=self.suite.turned(turn_b[0]))

    def after(
        self, tick: int, acting: Sequence[Event], rules: int = RULES
    ) -> tuple[list[Event], 'RunState']:
        """
        Return what happens at the tick that comes next, and the run after it.

        First it is decided whether the motion reaches the tick: if it does not, the torques are
        dropped, and if it still does not, the run halts.  Then torques time out, what acts does so
        in its order, and it is told which rotors have come to their limits of speed.  acting:
        requests, resets, torques, commands and topics; by rules below 3 also where these limits
        drop torques, and by rules 0 drops, halts and timeouts, as a bag tells them, and whether
        the tick is reached is decided where something needs it.
        """
        happening = _Happening(self, tick)
        if rules >= EVENTS_FOLLOW:
            happening.drop_torques_or_halt()
        happening.time_out()
        for event in acting:
            happening.act(event)
        happening.tell_limits(self)
        happening.drop_torques_or_halt()
        return happening.events, happening.run


class _Happening:
    """What happens at one tick: events, those so far; run, as they leave it."""

    def __init__(self, run: RunState, tick: int):
        self.events: list[Event] = []
        self.run, self.tick = run, tick

    def drop_torques_or_halt(self, kinds: tuple[type, ...] = (TorquesDropped, Halt)) -> None:
        """Drop the torques, or else halt, where the motion does not reach the tick."""
        while self.run.halted is None and not self.run.segment.reaches(self.tick):
            run, before = self.run, self.tick - 1
            drops = run.system.is_commanded and run.segment.begin_tick <= before
            event = TorquesDropped(self.tick) if drops else Halt(self.tick)
            if not isinstance(event, kinds):
                return
            if drops:
                none = np.zeros(len(run.system.rotors))
                free = run.system.driven(np.zeros(3), none, np.zeros(3), none + np.nan)
                run = replace(run, torques_b=dict.fromkeys(run.torques_b, NO_TORQUE), until={})
                self.run = run.restarted(before, run.segment.state_at(before), free)
            else:
                self.run = replace(run, halted=run.segment.why_no_further)
            self.events.append(event)

    def time_out(self) -> None:
        """End the held torques whose time is over."""
        for topic in [topic for topic, until in self.run.until.items() if until <= self.tick]:
            self.act(Timeout(self.tick, topic))

    def act(self, event: Event) -> None:
        """Let an event act."""
        cut: list[str] = []
        match event:
            case TorquesDropped() | Halt():
                # Of a bag of rules 0: nothing else shows that they are true there, since the
                # events that follow at the tick may begin another motion.
                return self.drop_torques_or_halt((type(event),))
            case Request():
                at_s = self.run.ticks.seconds(self.tick)
                conditions = self.run.conditions.with_values(event.values, at_s)
                event = replace(event, values=resolved(event.values, conditions))
                self.run = replace(self.run, conditions=conditions)
                self._restart_from_conditions()
            case Reset():
                self._restart_from_conditions()
            case Torque():
                self._apply(event.topic, event.torque_b, event.until_tick)
            case Timeout() if is_torque(event.topic):
                self._apply(event.topic, NO_TORQUE, None)
            case DipoleCommand():
                self._magnetise(event.dipole_b, event.until_tick)
            case Timeout(topic=topic) if topic == MAGNETORQUERS:
                self._magnetise(NO_DIPOLE, None)
            case RotorCommand():
                cut = self._command(event.torques, event.until_tick, event.speeds)
            case Timeout():
                self._command({rotor_of(event.topic): 0.0}, None)
            case Topics():
                self.run = replace(self.run, topics=event.names)
            case RotorLimited():
                # Of a bag of rules below 3.
                self._command({event.rotor: 0.0}, None)
        self.events.append(event)
        self.events += [RotorLimited(self.tick, name, 'max_torque') for name in cut]

    def tell_limits(self, before: RunState) -> None:
        """Tell of rotors at their limits of speed, of the run before or of the motion of now."""
        rotors = self.run.system.rotors
        if not self.run.system.switching_rotors or self.tick <= self.run.told:
            return
        met = np.zeros(len(rotors), bool)
        if before.segment.reaches(self.tick):
            found = before.segment.states(self.tick, self.tick + 1).met_limit
            # A closed form has none.
            met |= found[0] if found is not None else False
        if self.run.segment is not before.segment:
            met |= self._is_at_limit(self.run) & ~self._is_at_limit(before)
        labels = [rotors[i].label for i in np.flatnonzero(met)]
        self.events += [RotorLimited(self.tick, name, 'max_speed') for name in labels]

    def _is_at_limit(self, run):
        if run.halted or not run.segment.reaches(self.tick):
            return np.zeros(len(run.system.rotors), bool)
        return is_at_limit(run.system, run.segment.state_at(self.tick).rotor_speed)

    def _apply(self, topic: str, torque_b: TorqueB, until_tick: int | None) -> None:
        """Let a body torque act, beside those of other topics."""
        self._hold([topic], until_tick)
        if self.run.torques_b.get(topic) != torque_b:
            torques_b = {**self.run.torques_b, topic: torque_b}
            self._drive(torque_b=total(torques_b))
            self.run = replace(self.run, torques_b=torques_b)

    def _command(
        self,
        torques: Mapping[str, float],
        until_tick: int | None,
        speeds: Mapping[str, float] = _NONE,
    ) -> list[str]:
        """Let motor torques act, or speeds, by rotor; return the rotors where torques are cut."""
        self._hold([f'rotor_command.{name}' for name in (*torques, *speeds)], until_tick)
        system = self.run.system
        acting, cut = within_max_torque(system, {**torques, **dict.fromkeys(speeds, 0.0)})
        targets = with_speeds(system, {**dict.fromkeys(torques, np.nan), **speeds})
        self._drive(rotor_torque=acting, rotor_target=targets)
        return cut

    def _magnetise(self, dipole_b: Sequence[float], until_tick: int | None) -> None:
        """Let the magnetorquers have a dipole, as far as they can."""
        self._hold([MAGNETORQUERS], until_tick)
        self._drive(dipole_b=within_max_dipole(self.run.conditions, dipole_b))

    def _hold(self, topics: Iterable[str], until_tick: int | None) -> None:
        new = dict.fromkeys(topics, until_tick)
        held = {name: until for name, until in self.run.until.items() if name not in new}
        held |= {name: until for name, until in new.items() if until is not None}
        self.run = replace(self.run, until=held)

    def _drive(self, **torques: np.ndarray) -> None:
        """Let torques act from the tick on; torques that already act change nothing."""
        acting = vars(self.run.system)
        if all(np.array_equal(acting[name], x, equal_nan=True) for name, x in torques.items()):
            return
        self.drop_torques_or_halt()
        system = self.run.system.driven(**torques)
        if self.run.halted:
            self.run = replace(self.run, system=system)
        else:
            run = self.run.turned_to(self.tick)
            self.run = run.restarted(self.tick, run.segment.state_at(self.tick), system)

    def _restart_from_conditions(self) -> None:
        run, acting = self.run, self.run.system
        system = run.conditions.system.driven(
            acting.torque_b, acting.rotor_torque, acting.dipole_b, acting.rotor_target
        )
        run = replace(run, suite=run.suite.restarted())
        start_s = run.ticks.seconds(self.tick)
        try:
            state = run.conditions.state_at(start_s)
            self.run = run.restarted(self.tick, state, system)
        except ValueError as error:
            try:
                motion = Propagation(system, run.conditions.state_at(start_s), start_s)
            except ValueError:
                # The table whose end halted the run does not know the tick.
                self.run = replace(run, halted=str(error))
                return
            # At the earlier tick of its check, rounding had not yet cost it its closed form.
            segment = Segment(run.ticks, self.tick, motion)
            segment.halt(self.tick, str(error))
            self.run = replace(run, segment=segment, system=system, halted=None)


def met_limit(states: States) -> np.ndarray:
    """Return at which rows of states a rotor came to its limit since the row before, (N,)."""
    if states.met_limit is None:
        return np.zeros(len(states), bool)
    return np.any(states.met_limit, axis=1)


def total(torques_b: Mapping[str, TorqueB]) -> np.ndarray:
    """Return the sum (3,) of body torques by topic, added in their order."""
    # Not by NumPy, which would warn of a sum beyond its range: such torques are dropped.
    return np.array([reduce(add, parts) for parts in zip(*torques_b.values(), strict=True)])


def rotor_of(topic: str) -> str:
    """Return the rotor of a held torque; version 0.1 had one, whose topic was rotor_torque."""
    return topic.removeprefix('rotor_command.') if topic != 'rotor_torque' else 'rotor'


def within_max_torque(
    system: System, torques: Mapping[str, float]
) -> tuple[np.ndarray, list[str]]:
    """
    Return the motor torques [N m] (R,) with some new, by rotor, and the rotors where it was cut.

    A rotor without a new torque keeps the one that acts.
    """
    acting, cut = system.rotor_torque.copy(), []
    for i, rotor in enumerate(system.rotors):
        torque = torques.get(rotor.label)
        if torque is None:
            continue
        if 0.0 < rotor.max_torque < abs(torque):
            torque = rotor.max_torque if torque > 0.0 else -rotor.max_torque
            cut.append(rotor.label)
        acting[i] = torque
    return acting, cut


def within_max_dipole(scenario: Scenario, dipole_b: ArrayLike) -> np.ndarray:
    """Return the dipole (3,) [A m^2] that the magnetorquers have when one is asked for."""
    most = np.array(scenario['magnetorquer.max_dipole'])
    # A zero has no sign: -0.0 would be another command.
    return np.clip(np.asarray(dipole_b), -most, most) + 0.0


def with_speeds(system: System, speeds: Mapping[str, float]) -> np.ndarray:
    """Return the commanded speeds [rad/s] (R,) with some new, by rotor; nan: a torque is."""
    targets = system.rotor_target.copy()
    for i, rotor in enumerate(system.rotors):
        targets[i] = speeds.get(rotor.label, targets[i])
    return targets


def is_at_limit(system: System, speeds: np.ndarray) -> np.ndarray:
    """Return of speeds (R,) [rad/s] which are at their limit while the command adds to it."""
    most = np.array([rotor.max_speed or np.inf for rotor in system.rotors])
    targets = system.rotor_target
    with np.errstate(invalid='ignore'):
        is_fast = np.abs(speeds) >= most * (1.0 - AT_LIMIT)
        commanded = np.where(np.isnan(targets), system.rotor_torque, targets - speeds)
        # The limit in its last digits is no faster than itself.
        is_faster = np.isnan(targets) | (np.abs(targets) > most)
    return is_fast & is_faster & (np.sign(speeds) * np.sign(commanded) > 0.0)
