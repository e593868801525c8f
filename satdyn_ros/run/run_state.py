"""What a run depends on, and what a tick makes of it."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import reduce
from operator import add

import numpy as np
from numpy.typing import ArrayLike

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
from .rules import EVENTS_FOLLOW, RULES
from .scenario import Scenario
from .segment import MOST_STEPS_A_TICK, Segment
from .ticks import Ticks
from .topics import MAGNETORQUERS, is_torque

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
    follows, in one sentence, None: one can.
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

    @property
    def has_torque(self) -> bool:
        """Whether any torque acts."""
        return self.system.is_commanded

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
        in its order, and the limits of the rotors follow.  acting: requests, resets, torques,
        commands and topics; by rules 0 also drops, halts and timeouts, as a bag tells them, and
        whether the tick is reached is decided where something needs it.
        """
        happening = _Happening(self, tick)
        if rules >= EVENTS_FOLLOW:
            happening.drop_torques_or_halt()
        happening.time_out()
        for event in acting:
            happening.act(event)
        happening.limit_speeds()
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
            drops = run.has_torque and run.segment.begin_tick <= before
            event = TorquesDropped(self.tick) if drops else Halt(self.tick)
            if not isinstance(event, kinds):
                return
            if drops:
                no_motor = np.zeros(len(run.system.rotors))
                free = run.system.driven(np.zeros(3), no_motor, np.zeros(3))
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
                conditions = self.run.conditions.with_values(event.values)
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
                cut = self._command(event.torques, event.until_tick)
            case Timeout():
                self._command({rotor_of(event.topic): 0.0}, None)
            case Topics():
                self.run = replace(self.run, topics=event.names)
        self.events.append(event)
        self.events += [RotorLimited(self.tick, name, 'max_torque') for name in cut]

    def limit_speeds(self) -> None:
        """Drop torques that make a rotor at its limit faster."""
        system, segment = self.run.system, self.run.segment
        if not has_max_speed(system) or self.run.halted or not segment.reaches(self.tick):
            return
        too_fast = is_too_fast(system, segment.state_at(self.tick).rotor_speed)
        dropped = [system.rotors[i].label for i in np.flatnonzero(too_fast)]
        self._command(dict.fromkeys(dropped, 0.0), None)
        self.events += [RotorLimited(self.tick, name, 'max_speed') for name in dropped]

    def _apply(self, topic: str, torque_b: TorqueB, until_tick: int | None) -> None:
        """Let a body torque act, beside those of other topics."""
        self._hold([topic], until_tick)
        if self.run.torques_b.get(topic) != torque_b:
            torques_b = {**self.run.torques_b, topic: torque_b}
            self._drive(torque_b=total(torques_b))
            self.run = replace(self.run, torques_b=torques_b)

    def _command(self, torques: Mapping[str, float], until_tick: int | None) -> list[str]:
        """Let motor torques act, by rotor; return the rotors where they are cut."""
        self._hold([f'rotor_command.{name}' for name in torques], until_tick)
        acting, cut = within_max_torque(self.run.system, torques)
        self._drive(rotor_torque=acting)
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
        if all(np.array_equal(acting[name], torque) for name, torque in torques.items()):
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
            acting.torque_b, acting.rotor_torque, acting.dipole_b
        )
        run = replace(run, suite=run.suite.restarted())
        start_s = run.ticks.seconds(self.tick)
        state = run.conditions.state_at(start_s)
        try:
            self.run = run.restarted(self.tick, state, system)
        except ValueError as error:
            # At the earlier tick of its check, rounding had not yet cost it its closed form.
            segment = Segment(run.ticks, self.tick, Propagation(system, state, start_s))
            segment.halt(self.tick, str(error))
            self.run = replace(run, segment=segment, system=system, halted=None)


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


def has_max_speed(system: System) -> bool:
    """Whether any rotor has a limit of its speed."""
    return any(rotor.max_speed for rotor in system.rotors)


def is_too_fast(system: System, speeds: np.ndarray) -> np.ndarray:
    """Return of speeds (..., R) [rad/s] which are at their limit while a torque adds to it."""
    most = np.array([rotor.max_speed or np.inf for rotor in system.rotors])
    with np.errstate(invalid='ignore'):
        return (np.abs(speeds) >= most) & (speeds * system.rotor_torque > 0.0)
