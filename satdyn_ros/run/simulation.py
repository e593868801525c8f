"""Scenario and events to samples at ticks: no ROS and no clock of its own."""

import copy
from bisect import insort
from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import Any, TypeVar

import numpy as np

from ..actuators import Command
from ..base.key import listed
from ..dynamics.motion import Motion, States
from ..dynamics.system import State, System
from ..sensors import Suite
from .events import Derived, Event, Request, Reset, RotorLimited
from .in_place import OF_ATTITUDE
from .requests import requested
from .rules import EVENTS_FOLLOW, LIMITS_AT_THEIR_INSTANT, RULES
from .run_state import RunState, met_limit
from .sample import Sample
from .samples import Measured, Samples
from .scenario import Scenario
from .segment import MOST_STEPS_A_TICK, Segment
from .sensors import by_rules
from .stepper import Stepper
from .ticks import Ticks

_Same = TypeVar('_Same', bound='Simulation')


class RunHalted(RuntimeError):  # noqa: N818
    """The end of a run whose motion cannot continue; its text is one sentence."""


class Simulation:
    """
    A run, tick by tick: the engine of the node, of offline runs and of learning loops.

    Parameters
    ----------
    scenario : Scenario
        the scenario
    events : events
        what happens at later ticks, in order; derived ones are left out, since they follow from
        the run
    rules : int
        of the bag that is run again; by rules 0 the bag's timeouts, drops and halts act as
        recorded

    Raises
    ------
    ValueError
        as for Scenario.motion

    Examples
    --------
    >>> simulation = Simulation(Scenario.from_yaml('config/default.yaml'))  # doctest: +SKIP
    >>> state = simulation.step(torque_b=(0, 0, 0.01))  # doctest: +SKIP
    """

    def __init__(self, scenario: Scenario, events: Iterable[Event] = (), rules: int = RULES):
        if rules < LIMITS_AT_THEIR_INSTANT:
            scenario = without_limits_of_speed(scenario)
        self.scenario = scenario.with_seed()
        self.ticks = Ticks(scenario.rate, scenario.epoch_ns)
        self.next_tick = 0
        given = (event for event in events if not follows(event, rules))
        # By rules that have it act, a limit does so after all else at its tick.
        order = sorted(given, key=lambda event: (event.tick, isinstance(event, RotorLimited)))
        self._pending = deque(order)
        self._rules, self._is_whole = rules, True
        state = scenario.initial_state
        motion = scenario.motion_from(scenario.system, state, 0.0, MOST_STEPS_A_TICK)
        suite = Suite.of(by_rules(self.scenario.sensors, rules))
        # What goes on from the last tick by steps, while nothing else is asked for.
        self._stepper: Stepper | None = None
        self._run = RunState(
            ticks=self.ticks,
            segment=Segment(self.ticks, 0, motion, suite.counts_turns),
            system=scenario.system,
            conditions=self.scenario,
            topics=scenario.topics,
            suite=suite,
            acting=scenario.equipment.none,
        )
        self._begin_block()
        # What the last step held, by the names under which it did.
        self._of_step: frozenset[str] = frozenset()

    def __repr__(self) -> str:
        at_s = self.ticks.seconds(self.next_tick)
        return f'<Simulation: next tick {self.next_tick} at {at_s:g} s, {self.scenario}>'

    def _begin_block(self) -> None:
        """Let no samples have been returned: the run comes before its next tick."""
        # The run before the first tick of the block, what acts there, and the run after that.
        self._before, self._acting, self._begun = self._run, list[Event](), self._run
        self._block: Samples | None = None

    # -- forward ---------------------------------------------------------------------------------

    def advance(self, count: int) -> tuple[list[Event], Samples]:
        """
        Return the events of the next tick, now applied, and the samples from it on.

        At most count ticks, none beyond the next event or the tick that reports a rotor at its
        limit, and none at all of a halted run.
        """
        self._settle()
        first, before, acting = self.next_tick, self._run, self._due(self.next_tick)
        try:
            happened, run = self._happening(first, acting, count)
            end = self._end(run, first, count if not run.halted else 0)
            states = run.segment.states(first, *end)
            if np.any(met := met_limit(states)[1:]):
                states = states.rows(slice(int(np.argmax(met)) + 1))
            block, suite = self._samples(run, first, states)
        except BaseException:
            # As by Ctrl-C, or where a controller fails: nothing has happened.
            self._pending.extendleft(reversed(acting))
            raise
        self._before, self._acting, self._begun, self._block = before, acting, run, block
        self._run, self.next_tick = replace(run, suite=suite), first + len(states)
        return happened, block

    def _happening(
        self, tick: int, acting: list[Event], count: int
    ) -> tuple[list[Event], RunState]:
        """Return what happens at the next tick, where these events act, and the run after it."""
        if not acting:
            # All at once: the tick alone would be asked for whether the motion reaches it.
            self._run.segment.states(tick, *self._end(self._run, tick, count))
        happened, run = self._run.after(tick, acting, self._rules)
        if own := self._own_commands(run, tick, happened):
            happened, run = self._run.after(tick, [*acting, *own], self._rules)
        return happened, run

    def _samples(self, run: RunState, first: int, states: States) -> tuple[Samples, Suite]:
        """Return the samples of a run's states from a tick on, and the sensors after them."""
        last, suite, measured = first + len(states), run.suite, dict[str, Measured]()
        if len(states):
            found, suite = suite.measure(range(first, last), states)
            measured = {name: Measured.of(some, first, self.ticks) for name, some in found.items()}
        stamps_ns = self.ticks.stamps_ns(first, last)
        return Samples(first, stamps_ns, states, run.system, measured, run.acting), suite

    def _own_commands(self, run: RunState, tick: int, happened: list[Event]) -> list[Command]:
        """Return what the run itself commands where all this has happened: nothing."""
        return []

    def _own_tick(self, tick: int) -> int | None:
        """Return the next tick after this one at which the run itself commands, None: none."""
        return None

    def rewind(self, tick: int) -> None:
        """
        Go back to a tick of the last samples: what comes from it on has not happened.

        What acted at the first of them is to act again.
        """
        self._settle()
        block = self._block
        if block is None or tick == self.next_tick:
            return
        if tick == block.first_tick:
            self._pending.extendleft(reversed(self._acting))
            self._run = self._before
            self._begin_block()
        else:
            self._run = replace(self._begun, suite=self._suite_at(tick))
        self.next_tick = tick

    def begin_from(self, state: State) -> None:
        """Let the motion in force begin from another state: the last samples come anew."""
        self._settle()
        run, tick = self._begun, self.next_tick if self._block is None else self._block.first_tick
        self._run = run.restarted(run.segment.begin_tick, state, run.system)
        self._run.segment.catch_up(tick)
        self._begin_block()
        self.next_tick = tick

    def measure_truth(self) -> None:
        """Let the sensors have no errors, from the next tick on and without earlier exposures."""
        self._settle()
        self._run = replace(self._run, suite=self._run.suite.perfect())
        self._begin_block()

    def command(self, **commands: Any) -> None:
        """
        Let commands act from the next tick on, until the next ones for the same actuators.

        Parameters
        ----------
        commands : see step
            by the keywords of step

        Raises
        ------
        ValueError, TypeError
            as for step
        """
        for topic, value in self._commanded(self._held(commands)):
            self.schedule(Command(self.next_tick, topic, value))

    def schedule(self, event: Event) -> None:
        """Add an event at its tick, the next one or later."""
        insort(self._pending, event, key=_tick_of)

    # -- step by step ----------------------------------------------------------------------------

    @property
    def tick(self) -> int:
        """The last tick that has happened, -1 before the first."""
        return self.next_tick - 1

    @property
    def sample(self) -> Sample:
        """What the run gives at the last tick; ValueError: before the first there is none."""
        self._settle()
        block = self._block
        if block is None:
            raise ValueError('the run has no sample yet; advance it, or step')
        return self._sample_of(self.conditions, block, self.tick - block.first_tick)

    def _sample_of(self, conditions: Scenario, samples: Samples, row: int) -> Sample:
        """Return what samples have in a row."""
        make = partial(samples.rows, row, row + 1)
        tick = samples.first_tick + row
        return Sample(conditions, self.ticks, tick, samples.states[row], make)

    @property
    def _here(self) -> RunState:
        """The run before the next tick."""
        self._settle()
        return self._run

    @property
    def state(self) -> State:
        """The state at the last tick; before the first, the initial one."""
        return self._here.segment.state_at(max(self.tick, 0))

    @property
    def system(self) -> System:
        """What moves, with the torques that act."""
        return self._here.system

    @property
    def rotor_torque(self) -> np.ndarray:
        """The torques of the motors at the last tick [N m] (R,); before the first, none."""
        self._settle()
        block = self._block
        if block is None or self.tick < block.first_tick:
            return self.system.rotor_torque
        return block.rotor_torque[self.tick - block.first_tick]

    @property
    def acting(self) -> Mapping[str, Any]:
        """What acts of all that actuators are commanded, by the names under which it is held."""
        return self._here.acting

    @property
    def topics(self) -> tuple[str, ...]:
        """The published topics."""
        return self._here.topics

    @property
    def halted(self) -> str | None:
        """Why no tick follows, in one sentence; None: one can."""
        return self._here.halted

    @property
    def sensors(self) -> Suite:
        """The sensors before the next tick."""
        return self._here.suite

    @property
    def sensors_of_a_new_motion(self) -> Suite:
        """The sensors ahead of the last tick's sample, if a new motion is to begin there."""
        self._settle()
        run = replace(self._begun, suite=self._suite_at(self.tick))
        return run.turned_to(self.tick).suite

    @property
    def motion(self) -> Motion:
        """The motion since the last event."""
        return self._here.segment.motion

    @property
    def conditions(self) -> Scenario:
        """The scenario, with the initial conditions in force when all requests have acted."""
        conditions = self._here.conditions
        for event in self._pending:
            if isinstance(event, Request):
                at_s = self.ticks.seconds(event.tick)
                conditions = conditions.with_values(event.values, at_s)
        return conditions

    def step(self, **commands: Any) -> Sample:
        """
        Advance by one tick and return the sample there.

        A command holds during this step; an actuator without one continues as before.  The first
        step is from tick 0 to tick 1.

        Parameters
        ----------
        torque_b : (3,), N m, body axes
            torque on the body; with torque.names by name
        rotor_torque : N m
            motor torques by rotor
        rotor_speed : rad/s
            commanded speeds by rotor
        dipole_b : (3,), A m^2, body axes
            of the magnetorquers
        thrusters : s
            on-times by thruster, which begin with the step and may outlast it

        Raises
        ------
        ValueError
            there is no such torque, motor or magnetorquer, or a number is not finite
        TypeError
            there is no such command
        RunHalted
            the run cannot continue
        """
        held = now = self._held(commands)
        if self.next_tick == 0:
            self.advance(1)
        if self._pending and self._pending[0].tick <= self.next_tick:
            self._settle()
            stepper = None
        else:
            stepper = self._stepper or self._new_stepper()
        acting = stepper.acting if stepper else self.acting
        none = self.scenario.equipment.none
        held = {name: none[name] for name in self._of_step - held.keys()} | held
        changes = {name: x for name, x in held.items() if acting[name] != x}
        self._of_step = frozenset(filter(self.scenario.equipment.is_held, now))
        new = [*self._commanded(changes)]
        if stepper and (sample := stepper.step(new)) is not None:
            self.next_tick += 1
            return sample
        self._settle()
        if new:
            self.rewind(self.tick)
            for topic, value in new:
                self.schedule(Command(self.next_tick, topic, value))
        end = self.next_tick + (2 if new else 1)
        while self.next_tick < end and not self.halted:
            self.advance(end - self.next_tick)
        if self.halted:
            raise RunHalted(self.halted)
        return self.sample

    def _new_stepper(self):
        """Return what steps from the last tick on; None: what happens is more than commands."""
        if self._block is None or not Stepper.takes(self._run):
            return None
        self._stepper = Stepper(self._run, self.tick, self._suite_at(self.tick))
        return self._stepper

    def _settle(self):
        """Let the run stand where steps have brought it, with its last sample."""
        if self._stepper is None:
            return
        stepper, self._stepper = self._stepper, None
        self._run, self.next_tick = stepper.settled(), stepper.tick
        self._begin_block()
        self.advance(1)

    def _held(self, commands: Mapping[str, Any]) -> dict[str, Any]:
        """Return what commands of a step hold, by name; ValueError, TypeError: as of step."""
        held: dict[str, Any] = {}
        words = self.scenario.equipment.of_keyword
        for keyword, given in commands.items():
            if keyword not in words:
                raise TypeError(f'there is no command {keyword}; there are {", ".join(words)}')
            if given is None:
                continue
            actuator, word = words[keyword]
            for topic, value in actuator.given(word, given).items():
                now = actuator.held(topic, value)
                if both := held.keys() & now.keys():
                    raise ValueError(f'{min(both)} is commanded twice; give one command')
                held |= now
        return held

    def _commanded(self, held: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
        """Yield topics and values of the commands that hold this and nothing else."""
        for actuator in self.scenario.equipment.actuators:
            own = {name: x for name, x in held.items() if name in actuator.none}
            yield from actuator.commanding(own)

    def request(self, values: Mapping[str, Any]) -> None:
        """Restart at the next tick from new initial conditions; ValueError: not allowed."""
        requested(self.conditions, values)
        self.schedule(Request(self.next_tick, dict(values)))

    def reset(self) -> None:
        """Restart at the next tick from the initial conditions in force."""
        self.schedule(Reset(self.next_tick))

    def _due(self, tick):
        """Take the events that act at a tick from those that are pending."""
        due = []
        while self._pending and self._pending[0].tick <= tick:
            due.append(self._pending.popleft())
        return due

    def _end(self, run, first, count):
        """
        Return the tick before which the next samples of a run end, and whether an event is there.

        They end at the latest where an event may follow.
        """
        known = [self._pending[0].tick] if self._pending else []
        own = [] if (own_tick := self._own_tick(first)) is None else [own_tick]
        event_ticks = [tick for tick in (*known, *own, *run.until.values()) if tick > first]
        last = min([first + count, *event_ticks])
        return last, last in event_ticks

    def _suite_at(self, tick):
        """Return the sensors before a tick of the last samples."""
        block = self._block
        if block is None or tick == block.first_tick:
            return self._begun.suite
        before = block.states.rows(slice(tick - block.first_tick))
        return self._begun.suite.measure(range(block.first_tick, tick), before)[1]

    # -- snapshots -------------------------------------------------------------------------------

    def __getstate__(self) -> dict[str, Any]:
        """Return what a copy begins with: where the run stands."""
        self._settle()
        return vars(self)

    def snapshot_copy(self) -> 'Simulation':
        """Return a copy for snapshots by another thread while the run continues."""
        self._settle()
        kept = copy.copy(self)
        # With states of its own it need not ask the motion, which walks on.
        kept._begun = replace(self._begun, segment=copy.copy(self._begun.segment))
        return kept

    def snapshot(self, tick: int) -> dict[str, Any]:
        """
        Return, as plain data, all that the run depends on from a tick of the last samples on.

        The start of the motion and the state there (so that the same bits come again), the state
        at the tick, the torques that act with the ticks where they end, the conditions in force,
        the topics and the sensors' memories.  is_start: whether scenario and events say all this.
        """
        self._settle()
        run = self._begun
        return {
            'tick': tick,
            'is_start': tick == 0 and self._is_whole,
            'state': state_record(run.segment.state_at(tick)),
            'begin_tick': run.segment.begin_tick,
            'begin_state': state_record(run.segment.motion.state),
            **run.equipment.to_plain(run.acting),
            'until': dict(run.until),
            'conditions': {
                name: listed(value)
                for name, value in run.conditions.values.items()
                if name in run.conditions.initial_conditions and name not in OF_ATTITUDE
            },
            'topics': list(run.topics),
            'sensors': self._suite_at(tick).to_plain(),
        }

    @classmethod
    def from_snapshot(
        cls: type[_Same],
        scenario: Scenario,
        snapshot: Mapping[str, Any],
        events: Iterable[Event] = (),
        rules: int = RULES,
    ) -> _Same:
        """Return the run that continues at a snapshot's tick."""
        simulation = cls(scenario, events, rules)
        run = simulation._run
        conditions = simulation.scenario.with_values(snapshot['conditions'])
        equipment = conditions.equipment
        acting = equipment.from_plain(snapshot)
        system = equipment.driven(conditions.system, acting)
        begin = snapshot['begin_state']
        state = State(
            np.array(begin['q_ib']),
            np.array(begin['omega_bi_b']),
            begin['rotor_speed'],
            begin['rotor_angle'],
            begin.get('inner', {}),
        )
        run = replace(
            run,
            conditions=conditions,
            topics=tuple(snapshot['topics']),
            # Version 0.1 had no sensors.
            suite=run.suite.with_memories(snapshot.get('sensors', {})),
            acting=acting,
            reported=snapshot['tick'],
            until={equipment.held_as(name): until for name, until in snapshot['until'].items()},
        )
        simulation._run = run.restarted(snapshot['begin_tick'], state, system)
        simulation._begin_block()
        simulation.next_tick, simulation._is_whole = snapshot['tick'], False
        simulation._run.segment.catch_up(simulation.next_tick)
        return simulation


def follows(event: Event, rules: int) -> bool:
    """Whether an event follows from the run, so that its record is only compared."""
    if isinstance(event, RotorLimited):
        return event.limit == 'max_torque' or rules >= LIMITS_AT_THEIR_INSTANT
    return isinstance(event, Derived) and rules >= EVENTS_FOLLOW


def without_limits_of_speed(scenario: Scenario) -> Scenario:
    """Return a scenario whose rotors may be as fast as they get."""
    limits = [key for key in scenario.values if key.rpartition('.')[2] == 'max_speed']
    return scenario.with_values(dict.fromkeys(limits, 0.0))


def _tick_of(event):
    return event.tick


def state_record(state: State) -> dict[str, list[float]]:
    """Return a state as plain data."""
    return {
        'q_ib': [float(x) for x in state.q_ib],
        'omega_bi_b': [float(x) for x in state.omega_bi_b],
        'rotor_speed': state.rotor_speed.tolist(),
        'rotor_angle': state.rotor_angle.tolist(),
        **({'inner': dict(state.inner)} if state.inner else {}),
    }
