"""Many runs in step: commands and samples are columns, a row of each run."""

from collections import defaultdict
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..actuators import ACTUATORS, Actuator
from ..dynamics.motion import States
from ..dynamics.system import State, System
from ..integrate.propagation import Propagation
from ..integrate.relays import Driven, Relays, kind_of_motion
from ..sensors.suites import Suites, why_alone, without_seeds
from .sample_columns import Apart, SampleColumns
from .samples import Samples
from .scenario import Scenario
from .segment import MOST_STEPS_A_TICK, NO_STAMP
from .ticks import Ticks

_MUST = (
    'runs side by side must have the same publish.rate, time.epoch and limits of their actuators, '
    'and motion.method numeric'
)


class SideBySide:
    """
    M runs in step, each with the bits of a Simulation of its scenario.

    A command acts from the last tick on, until the next one for the same actuator.  There are no
    requests and no timeouts.  A torque under which a body cannot go on ends its run; a run alone
    would drop the torque.

    Parameters
    ----------
    scenarios : M scenarios
        alike in publish.rate, in time.epoch, in the limits of their actuators and in their sensors
        but for the seed, and of one kind (Relays)

    Attributes
    ----------
    tick : (M,)
        the last tick of each run that has happened
    halted : dict
        for runs that have stopped, by number: why, in one sentence

    Raises
    ------
    ValueError
        the scenarios are not alike, or motion.method is not numeric

    Examples
    --------
    >>> runs = SideBySide([scenario] * 8)  # doctest: +SKIP
    >>> runs.act(torque_b=np.zeros((8, 3)))  # doctest: +SKIP
    >>> runs.step().q_ib.shape  # doctest: +SKIP
    (8, 4)
    """

    def __init__(self, scenarios: Sequence[Scenario]):
        self.scenarios = [scenario.with_seed() for scenario in scenarios]
        first, count = self.scenarios[0], len(scenarios)
        self.equipment, self._alike = first.equipment, _alike(first)
        self.ticks = Ticks(first.rate, first.epoch_ns)
        for scenario in self.scenarios:
            self._refuse_other(scenario)
        self.tick, self._begun = np.zeros((2, count), np.int64)
        self.halted: dict[int, str] = {}
        none = self.equipment.none
        self._acting = {name: _repeated(held, count) for name, held in none.items()}
        self._relays = Relays([*map(_motion, self.scenarios)], self._system_of)
        self._suites = Suites([each.sensors for each in self.scenarios])
        self._measured: dict[str, tuple[np.ndarray, np.ndarray]] = {}
        self._know()
        self._reach(np.ones(count, bool))
        self._look(np.arange(count))

    def __len__(self) -> int:
        return len(self.scenarios)

    def _refuse_other(self, scenario):
        why = _why_alone(scenario)
        if why or _alike(scenario) != self._alike:
            raise ValueError(why or _MUST)

    # -- forward ---------------------------------------------------------------------------------

    def begin(self, runs: Mapping[int, Scenario]) -> None:
        """
        Restart some runs at their tick 0.

        Parameters
        ----------
        runs : dict
            the new scenario of each, by number

        Raises
        ------
        ValueError
            as for the class; then none restarts
        """
        scenarios = {m: given.with_seed() for m, given in runs.items()}
        motions = {}
        for m, scenario in scenarios.items():
            self._refuse_other(scenario)
            self._suites.refuse_others(scenario.sensors)
            motions[m] = _motion(scenario)
            self._relays.refuse_other(motions[m])
        is_known = all(self.scenarios[m].system is x.system for m, x in scenarios.items())
        for m, scenario in scenarios.items():
            self._relays.begin(m, motions[m])
            self._suites.begin(m, scenario.sensors)
            self.scenarios[m], self._begun[m] = scenario, 0
            self.halted.pop(m, None)
        is_new = np.isin(np.arange(len(self)), [*runs])
        self.tick = np.where(is_new, 0, self.tick)
        for name, none in self.equipment.none.items():
            held = self._acting[name]
            self._acting[name] = _chosen(is_new, _repeated(none, len(self)), held)
        if not is_known:
            self._know()
        self._reach(is_new)
        self._look(np.flatnonzero(is_new))

    def act(self, **commands: Any) -> None:
        """
        Let commands act from the last tick on.

        Parameters
        ----------
        commands : arrays
            by the keywords of Simulation.step, each with a row for each run, such as torque_b (M,
            3), or one for all

        Raises
        ------
        ValueError, TypeError
            as for Simulation.step
        """
        words, held = self.equipment.of_keyword, dict[str, Any]()
        for keyword, given in commands.items():
            if keyword not in words:
                raise TypeError(f'there is no command {keyword}; there are {", ".join(words)}')
            if given is not None:
                actuator, word = words[keyword]
                held |= actuator.columns(word, given, len(self))
        for actuator in self.equipment.actuators:
            changes = {
                name: x
                for name, x in held.items()
                if name in actuator.none and _differ(x, self._acting[name]).any()
            }
            for topic, value in actuator.commanding(changes):
                self._command(actuator, actuator.held(topic, value))

    def _command(self, actuator: Actuator, held: Mapping[str, Any]) -> None:
        acting = dict(self._acting)
        for name, x in held.items():
            is_new = _differ(x, acting[name])
            is_new[[*self.halted]] = False
            acting[name] = _chosen(is_new, actuator.within(name, x), acting[name])
        is_other = _differ(actuator.effect(acting), actuator.effect(self._acting))
        self._acting, rows = acting, np.flatnonzero(is_other)
        if not len(rows):
            return
        # Another command at the same tick, or the first: the state is that of a row.
        self._reach((self._begun == self.tick) & is_other)
        begin_s = self.ticks.seconds_of(self.tick[rows])
        left = self._relays.take_over(rows, begin_s, self._driven())
        tables = self._relays.states() if len(left) else ()
        for m in left.tolist():
            at_s = self.ticks.seconds(int(self.tick[m]))
            q_ib, omega_bi_b, speed, angle, inner = tables
            of_one = {name: float(values[m]) for name, values in inner.items()}
            state = State(q_ib[m], omega_bi_b[m], speed[m], angle[m], of_one)
            motion = _motion(self.scenarios[m], self._system_of(m), state, at_s)
            self._relays.begin(m, motion)
        self._begun[rows] = self.tick[rows]

    def step(self, chosen: np.ndarray | None = None) -> SampleColumns:
        """
        Advance runs by one tick, and return the sample there.

        Parameters
        ----------
        chosen : (M,), bool
            the runs that advance, by default all; a run that has halted never does
        """
        goes = np.ones(len(self), bool) if chosen is None else np.array(chosen, bool)
        goes[[*self.halted]] = False
        following = self.tick + goes
        for m, why in self._ended(following, goes):
            self.halted[m], goes[m] = why, False
        self.tick = np.where(goes, following, self.tick)
        self._reach(goes)
        for m in self._relays.why.keys() - self.halted.keys():
            self.halted[m], goes[m] = self._relays.why[m], False
            self.tick[m] -= 1
        self._measured = {}
        self._look(np.flatnonzero(goes))
        return self.sample

    def _reach(self, goes):
        """Let the motions of those that go (M,) go on to their ticks."""
        if goes.any():
            self._relays.reach(self.ticks.seconds_of(self.tick - self._begun), goes)

    def _ended(self, ticks, goes):
        """Return the runs of which something is not known at ticks (M,) any more, and why."""
        ended = [(m, NO_STAMP) for m in np.flatnonzero(goes & (ticks > self.ticks.last)).tolist()]
        for rows, tables in self._tables:
            some = rows[goes[rows]]
            some = some[np.argsort(ticks[some], kind='stable')]
            for table in tables:
                known, why = table.known_rows(self.ticks.seconds_of(ticks[some]))
                ended += [(m, why) for m in some[known:].tolist()]
        return ended

    def _look(self, rows):
        """Make the sample of now, for which the sensors of some runs measure."""
        standing = self._relays.states()
        states, measured = self._states(*standing), self._measured
        for name, found in self._suites.measure(rows, self.tick, states).items():
            runs, exposed, values = found
            whole, since = measured.get(name) or (
                np.full((len(self), *values.shape[1:]), np.nan),
                np.zeros(len(self), np.int64),
            )
            whole[rows] = np.nan
            whole[runs], since[runs] = values, exposed
            measured[name] = whole, since
        # A sample shows its own ticks, whatever acts when it is looked at.
        scenarios, acting, inner = [*self.scenarios], dict(self._acting), standing[-1]

        def alone(m):
            system = self._driven_by(scenarios[m].system, acting, m)
            return _samples_of_one(sample, system, inner, m)

        sample = self.sample = SampleColumns(
            self.scenarios[0], self.ticks, self.tick, states, measured, alone
        )

    def _states(self, q_ib, omega_bi_b, speed, angle, inner):
        """Return the states where the runs stand, a row of each."""
        at_s = self.ticks.seconds_of(self.tick)
        none = np.full(len(self), np.nan)

        def of(rows, orbit, environment):
            return States(
                at_s[rows],
                q_ib[rows],
                omega_bi_b[rows],
                speed[rows],
                angle[rows],
                none[rows],
                orbit,
                at_s[rows],
                environment=environment,
                inner={name: values[rows] for name, values in inner.items()},
            )

        groups = self._groups
        if len(groups) == 1:
            return of(slice(None), *next(iter(groups)))
        return Apart([(rows, of(rows, *surroundings)) for surroundings, rows in groups.items()])

    # -- what is known of the runs ---------------------------------------------------------------

    def _know(self):
        """Sort the runs by where they are, and by what is known of there."""
        groups = defaultdict(list)
        for m, scenario in enumerate(self.scenarios):
            groups[scenario.system.orbit, scenario.system.environment].append(m)
        self._groups = {each: np.array(runs) for each, runs in groups.items()}
        self._tables = []
        for (_, environment), runs in self._groups.items():
            asked = () if environment is None else environment.asked
            system = self.scenarios[runs[0]].system
            self._tables.append((runs, tuple(dict.fromkeys((*system.pieces, *asked)))))
        self._many = _of_many([scenario.system for scenario in self.scenarios])

    def _system_of(self, m: int) -> System:
        """Return the system of run m under what acts."""
        return self._driven_by(self.scenarios[m].system, self._acting, m)

    def _driven_by(self, system, acting, m):
        """Return the system of a run under its row of what acts."""
        of_one = {name: _of_one(held, m) for name, held in acting.items()}
        return self.equipment.driven(system, of_one)

    def _driven(self) -> Driven:
        """Return what acts on all runs."""
        system, count = self._many, len(self)
        own: dict[int, Any] = {}
        torques = {'torque_b': np.zeros(3), 'rotor_torque': system.rotor_torque}
        for actuator in self.equipment.actuators:
            changes = actuator.driven(system, self._acting)
            for i, torque in enumerate(changes.pop('torques', ())):
                if torque is not system.torques[i]:
                    own[i] = torque.constants
            torques |= changes
        torque_b, rotor_torque = (
            np.broadcast_to(x.T, (count, len(x))).T
            for x in (torques['torque_b'], torques['rotor_torque'])
        )
        return Driven(torque_b, rotor_torque, own)


def kind_of_run(scenario: Scenario) -> Hashable:
    """Return what runs must have in common to fly side by side; None: it flies alone."""
    if _why_alone(scenario):
        return None
    return repr(
        (_alike(scenario), kind_of_motion(_motion(scenario)), without_seeds(scenario.sensors))
    )


def _why_alone(scenario):
    """Return why a scenario flies alone, in one sentence; '': it need not."""
    if scenario['motion.method'] != 'numeric':
        return _MUST
    if scenario.equipment.has_pulses:
        return (
            'runs with thruster.names fly one by one: their valves open and close at times of '
            'their own'
        )
    return why_alone(scenario.sensors)


def _motion(scenario, system=None, state=None, start_s=0.0):
    """Return the motion of a scenario, by default at its start."""
    system, state = system or scenario.system, state or scenario.initial_state
    motion = scenario.motion_from(system, state, start_s, MOST_STEPS_A_TICK)
    assert isinstance(motion, Propagation)
    return motion


def _samples_of_one(sample, system, inner, m):
    """Return the row of run m of a sample as the samples of a run alone."""
    row = slice(m, m + 1)
    states = States(
        sample.t_s[row],
        sample.q_ib[row],
        sample.omega_bi_b[row],
        sample.rotor_speed[row],
        sample.rotor_angle[row],
        np.full(1, np.nan),
        system.orbit,
        sample.t_s[row],
        environment=system.environment,
        inner={name: x[row] for name, x in inner.items()},
    )
    return Samples(int(sample.tick[m]), sample.stamp_ns[row], states, system)


def _alike(scenario):
    """Return what runs side by side must have in common, beside their kind."""
    limits = {kind.limit for kind in ACTUATORS.values() if kind.limit}
    same = ('publish.rate', 'time.epoch_ns', 'torque.names', 'rotor.names')
    return {
        name: value
        for name, value in scenario.values.items()
        if name in same or name.rpartition('.')[2] in limits
    }


def _of_many(systems):
    """Return the first of systems, with torques that are commanded as those of all of them."""
    torques = zip(*(system.torques for system in systems), strict=True)
    return replace(systems[0], torques=tuple(type(some[0]).of_many(some) for some in torques))


# -- what is held, in columns -----------------------------------------------------------------


def _each(function, held, *others):
    """Return what is held, in tuples, with a function of each of its numbers."""
    if not isinstance(held, tuple):
        return function(held, *others)
    parts = [_each(function, *some) for some in zip(held, *others, strict=True)]
    return type(held)(*parts) if hasattr(held, '_fields') else tuple(parts)


def _repeated(held, count):
    """Return columns of what is held in count runs; nan: nothing is."""
    return _each(lambda x: np.full(count, np.nan if x is None else x, float), held)


def _of_one(held, m):
    """Return what is held in run m."""
    return _each(lambda x: None if np.isnan(x[m]) else float(x[m]), held)


def _chosen(rows, new, held):
    """Return columns of what is held with new ones in some rows (M,)."""
    return _each(lambda x, y: np.where(rows, np.nan if x is None else x, y), new, held)


def _differ(one, other):
    """Return the runs (M,) in which two held things differ."""
    if isinstance(one, Mapping):
        one, other = tuple(one.values()), tuple(other.values())
    if not isinstance(one, tuple):
        one, other = (np.nan if x is None else x for x in (one, other))
        return (one != other) & ~(np.isnan(one) & np.isnan(other))
    return np.logical_or.reduce([_differ(a, b) for a, b in zip(one, other, strict=True)])
