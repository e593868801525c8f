"""What a run depends on, and what a tick makes of it."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby
from typing import Any

import numpy as np

from ..actuators import Actuator, Command, Equipment, kind_of
from ..dynamics.drives import AT_LIMIT
from ..dynamics.motion import Motion, States
from ..dynamics.system import State, System
from ..integrate.propagation import Propagation
from ..sensors import Suite
from .events import (
    Event,
    Halt,
    Request,
    Reset,
    RotorLimited,
    Timeout,
    Topics,
    TorquesDropped,
)
from .requests import requested, resolved
from .rules import EVENTS_FOLLOW, RULES
from .scenario import Scenario
from .segment import MOST_STEPS_A_TICK, Segment
from .ticks import Ticks


@dataclass(frozen=True, eq=False)
class RunState:
    """
    All that a run depends on from a tick on; it never changes.

    segment: the motion in force.  system: what moves, with the torques that act.  conditions: the
    scenario, with the initial conditions in force.  topics: those published.  suite: the sensors
    before the tick's samples.  acting: what acts of all that actuators are commanded, by the names
    under which it is held.  until: by these names the tick where it ends.  halted: why no tick
    follows, in one sentence, None: one can.  reported: the last tick of a snapshot from which the
    run goes on, whose limits have been reported.
    """

    ticks: Ticks
    segment: Segment
    system: System
    conditions: Scenario
    topics: tuple[str, ...]
    suite: Suite
    acting: Mapping[str, Any]
    until: Mapping[str, int] = field(default_factory=dict)
    halted: str | None = None
    reported: int = -1

    @property
    def equipment(self) -> Equipment:
        """The actuators."""
        return self.conditions.equipment

    def restarted(
        self, tick: int, state: State, system: System, after: Motion | None = None
    ) -> 'RunState':
        """
        Return the run whose motion begins at a tick, from a state and with the torques of system.

        after: the one that it goes on from, if it does.
        ValueError: motion.method is exact and there is no closed form.
        """
        start_s = self.ticks.seconds(tick)
        motion = self.conditions.motion_from(system, state, start_s, MOST_STEPS_A_TICK, after)
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
        in its order, and rotors that have come to their limits of speed are reported.  acting:
        requests, resets, torques, commands and topics; by rules below 3 also where these limits
        drop torques, and by rules 0 drops, halts and timeouts, as a bag has them, and whether
        the tick is reached is decided where something needs it.
        """
        of_tick = _EventsOfTick(self, tick)
        if rules >= EVENTS_FOLLOW:
            of_tick.drop_torques_or_halt()
        of_tick.time_out()
        for is_together, events in groupby(acting, _ends_by_itself):
            if is_together:
                of_tick.command_together(events)
            else:
                for event in events:
                    of_tick.act(event)
        of_tick.report_limits(self)
        of_tick.drop_torques_or_halt()
        return of_tick.events, of_tick.run


class _EventsOfTick:
    """What happens at one tick: events, those so far; run, as they leave it."""

    def __init__(self, run: RunState, tick: int):
        self.events: list[Event] = []
        self.run, self.tick, self._at_s = run, tick, run.ticks.seconds(tick)

    def drop_torques_or_halt(self, kinds: tuple[type, ...] = (TorquesDropped, Halt)) -> None:
        """Drop the torques, or else halt, where the motion does not reach the tick."""
        while self.run.halted is None and not self.run.segment.reaches(self.tick):
            run, before = self.run, self.tick - 1
            ended = run.equipment.ended(run.acting, run.ticks.seconds(before))
            drops = run.acting != ended and run.segment.begin_tick <= before
            event = TorquesDropped(self.tick) if drops else Halt(self.tick)
            if not isinstance(event, kinds):
                return
            if drops:
                run = replace(run, acting=ended, until={})
                free = run.equipment.driven(run.system, run.acting)
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
        cut: list[RotorLimited] = []
        match event:
            case TorquesDropped() | Halt():
                # Of a bag of rules 0: nothing else shows that they are true there, since the
                # events that follow at the tick may begin another motion.
                return self.drop_torques_or_halt((type(event),))
            case Request():
                conditions = requested(self.run.conditions, event.values, self._at_s)
                event = replace(event, values=resolved(event.values, conditions))
                self.run = replace(self.run, conditions=conditions)
                self._restart_from_conditions()
            case Reset():
                self._restart_from_conditions()
            case Command():
                actuator = self.run.equipment.of_topic[event.topic]
                cut = self._command(actuator.held(event.topic, event.value), event.until_tick)
            case Timeout():
                self._drop(self.run.equipment.held_as(event.topic))
            case Topics():
                self.run = replace(self.run, topics=event.names)
            case RotorLimited():
                # Of a bag of rules below 3.
                actuators = self.run.equipment.actuators
                names = {rotor: name for each in actuators for name, rotor in each.rotors.items()}
                self._drop(names[event.rotor])
        self.events.append(event)
        self.events += cut

    def command_together(self, commands: Iterable[Event]) -> None:
        """Let commands that end by themselves act as one: by each name the last one holds."""
        held: dict[str, Any] = {}
        for command in commands:
            assert isinstance(command, Command)
            actuator = self.run.equipment.of_topic[command.topic]
            held |= actuator.held(command.topic, command.value)
            self.events.append(command)
        self._command(held, None)

    def report_limits(self, before: RunState) -> None:
        """Report rotors at their limits of speed, of the run before or of the motion of now."""
        rotors = self.run.system.rotors
        if not self.run.system.switching_rotors or self.tick <= self.run.reported:
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
        segment = run.segment
        if run.halted or not segment.reaches(self.tick):
            return np.zeros(len(run.system.rotors), bool)
        # Where a motion begins it need not be asked.
        begins = self.tick == segment.begin_tick
        state = segment.motion.state if begins else segment.state_at(self.tick)
        return is_at_limit(run.system, state.rotor_speed)

    def _drop(self, name: str) -> None:
        """Let nothing be held under a name."""
        equipment = self.run.equipment
        is_held = name in equipment.none and equipment.is_held(name)
        self._command({name: equipment.none[name]} if is_held else {}, None)

    def _command(self, held: Mapping[str, Any], until_tick: int | None) -> list[RotorLimited]:
        """
        Let what is held act from the tick on, as far as it can; return which rotors are cut.

        What already acts changes nothing.
        """
        cut = []
        self._hold(held, until_tick)
        for actuator in dict.fromkeys(self.run.equipment.of_name[name] for name in held):
            new = {name: x for name, x in held.items() if name in actuator.none}
            acting = {
                name: actuator.from_instant(name, x, self.run.acting[name], self._at_s)
                for name, x in new.items()
            }
            cut += [
                RotorLimited(self.tick, actuator.rotors[name], actuator.limit)
                for name in new
                if name in actuator.rotors and acting[name] != new[name]
            ]
            self._drive(actuator, {name: self.run.acting[name] for name in actuator.none} | acting)
        return cut

    def _hold(self, names: Iterable[str], until_tick: int | None) -> None:
        new = dict.fromkeys(names, until_tick)
        held = {name: until for name, until in self.run.until.items() if name not in new}
        held |= {name: until for name, until in new.items() if until is not None}
        self.run = replace(self.run, until=held)

    def _drive(self, actuator: Actuator, acting: Mapping[str, Any]) -> None:
        """Let an actuator act from the tick on."""
        if actuator.effect(acting) == actuator.effect(self.run.acting):
            self.run = replace(self.run, acting={**self.run.acting, **acting})
            return
        self.drop_torques_or_halt()
        run = replace(self.run, acting={**self.run.acting, **acting})
        system = run.equipment.driven(run.system, acting, [actuator])
        if run.halted:
            self.run = replace(run, system=system)
        else:
            run = run.turned_to(self.tick)
            segment = run.segment
            state, after = segment.state_at(self.tick), segment.motion
            self.run = run.restarted(self.tick, state, system, after)

    def _restart_from_conditions(self) -> None:
        run, start_s = self.run, self._at_s
        acting = run.equipment.restarted(run.acting, start_s)
        system = run.equipment.driven(run.conditions.system, acting)
        run = replace(run, suite=run.suite.restarted(), acting=acting)
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


def _ends_by_itself(event: Event) -> bool:
    return isinstance(event, Command) and not kind_of(event.topic).is_held


def met_limit(states: States) -> np.ndarray:
    """Return at which rows of states a rotor came to its limit since the row before, (N,)."""
    if states.met_limit is None:
        return np.zeros(len(states), bool)
    return np.any(states.met_limit, axis=1)


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
