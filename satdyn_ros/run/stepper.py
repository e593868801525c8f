"""Steps of a run, tick by tick, while nothing but commands happens: numbers, not objects."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from ..dynamics.motion import States
from ..dynamics.system import State, System
from ..integrate.propagation import Propagation
from ..integrate.relay import Relay
from ..sensors import Measurements, Suite
from ..torques.magnetic import torquer_dipole
from .run_state import RunState
from .sample import Sample
from .samples import Measured, Samples


@dataclass(frozen=True, eq=False)
class _Begun:
    """Since when the present motion goes: tick, state there, and what acts from then on."""

    tick: int
    state: State
    system: System
    acting: Mapping[str, Any]


class Stepper:
    """
    A run that stands at a tick and continues by steps, in which only commands happen.

    It gives the bits of RunState.after, where each change of what acts begins a motion.
    tick: the last one that has happened.
    """

    @staticmethod
    def takes(run: RunState) -> bool:
        """Return whether it can continue a run: nothing ends by itself, no turn is counted."""
        if run.halted or run.until or run.suite.counts_turns:
            return False
        is_numeric = run.conditions['motion.method'] == 'numeric'
        return is_numeric and isinstance(run.segment.motion, Propagation)

    def __init__(self, run: RunState, tick: int, suite_before: Suite):
        """Begin at the last tick of a run; suite_before: its sensors before that tick."""
        segment, motion = run.segment, run.segment.motion
        assert isinstance(motion, Propagation)
        self._run, self.tick = run, tick
        self._relay = Relay(motion)
        self._relay.reaches(run.ticks.seconds(tick - segment.begin_tick))
        self._begun = _Begun(segment.begin_tick, motion.state, run.system, run.acting)
        self._first = self._begun
        self._state, self._suite, self._suite_before = self._relay.state(), run.suite, suite_before

    @property
    def acting(self) -> Mapping[str, Any]:
        """What acts, by the names under which it is held."""
        return self._begun.acting

    def step(self, commands: Iterable[tuple[str, Any]]) -> Sample | None:
        """
        Let commands, topics and values, act at the last tick; return the sample of the next one.

        None: it does not get there by numbers alone.  Then it stands where it stood, and ends.
        """
        run, relay, ticks, begun = self._run, self._relay, self._run.ticks, self._begun
        for topic, value in commands:
            begun = self._commanded(begun, topic, value)
            if begun is None:
                return None
        tick = self.tick + 1
        if not (run.segment.knows(tick) and relay.reaches(ticks.seconds(tick - begun.tick))):
            return None
        self.tick, self._begun, self._state = tick, begun, relay.state()
        self._suite_before = self._suite
        measured: Mapping[str, Measurements] = {}
        if self._suite.sensors:
            states = self._samples_of(begun, self._state, tick, {}).states
            measured, self._suite = self._suite.measure(range(tick, tick + 1), states)
        make = partial(self._samples_of, begun, self._state, tick, measured)
        return Sample(run.conditions, ticks, tick, self._state, make)

    def _commanded(self, begun, topic, value):
        """Return what goes on under a command at the last tick; None: not by numbers alone."""
        equipment = self._run.equipment
        actuator = equipment.of_topic[topic]
        acting = {**begun.acting}
        for name, x in actuator.held(topic, value).items():
            at_s = self._run.ticks.seconds(self.tick)
            acting[name] = actuator.from_instant(name, x, acting[name], at_s)
        if actuator.effect(acting) == actuator.effect(begun.acting):
            return replace(begun, acting=acting)
        if begun.tick == self.tick and not self._relay.reaches(0.0):
            return None
        system = equipment.driven(begun.system, acting, [actuator])
        if not self._relay.takes_over(system, self._run.ticks.seconds(self.tick)):
            return None
        state = self._state if begun.tick < self.tick else self._relay.state()
        return _Begun(self.tick, state, system, acting)

    def _samples_of(self, begun, state, tick, measured):
        """Return the samples of one tick."""
        ticks, system = self._run.ticks, begun.system
        states = States(
            t_s=ticks.seconds_between(begun.tick, tick, tick + 1),
            q_ib=state.q_ib[None],
            omega_bi_b=state.omega_bi_b[None],
            rotor_speed=state.rotor_speed[None],
            rotor_angle=state.rotor_angle[None],
            work=np.full(1, np.nan),
            orbit=system.orbit,
            orbit_s=ticks.seconds_between(0, tick, tick + 1),
            environment=system.environment,
            inner={name: np.array([x]) for name, x in state.inner.items()},
            torquer_dipole_b=np.array([torquer_dipole(system.torques)]),
        )
        found = {name: Measured.of(some, tick, ticks) for name, some in measured.items()}
        return Samples(tick, ticks.stamps_ns(tick, tick + 1), states, system, found, begun.acting)

    def settled(self) -> RunState:
        """Return the run before the last tick, which continues with the same bits."""
        begun = self._begun
        run = replace(self._run, suite=self._suite_before, acting=begun.acting)
        if begun is not self._first:
            run = run.restarted(begun.tick, begun.state, begun.system)
        run.segment.catch_up(self.tick)
        return run
