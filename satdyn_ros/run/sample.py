"""What a run gives at one tick, by attribute: what Simulation.step returns."""

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np

from ..dynamics.system import State
from .samples import Samples
from .scenario import Scenario
from .ticks import Ticks


class Measurement(np.ndarray):
    """What a sensor gives, (3,), (4,) or a number (), with the stamp_ns of its exposure."""

    stamp_ns: Any

    @classmethod
    def of(cls, values: np.ndarray, stamp_ns: Any) -> 'Measurement':
        """Return the values of one exposure."""
        found = np.asarray(values).view(cls)
        found.stamp_ns = stamp_ns
        return found

    def __array_finalize__(self, other: Any) -> None:
        """Give a copy the stamp of what it is a copy of."""
        self.stamp_ns = getattr(other, 'stamp_ns', 0)

    def __deepcopy__(self, memo: Any) -> 'Measurement':
        """Return a copy."""
        return self.copy()

    def __reduce__(self) -> Any:
        """Return how another process makes it again."""
        return Measurement.of, (np.array(self), self.stamp_ns)


class Along:
    """What there is at a tick beside the state, by attribute; it follows when it is asked for."""

    _scenario: Scenario

    @property
    def _samples(self) -> Samples:
        raise NotImplementedError

    @property
    def r_i(self) -> np.ndarray:
        """The position [m] (3,), inertial; zero for a fixed direction."""
        return self._rows(self._samples.states.r_i)

    @property
    def v_i(self) -> np.ndarray:
        """The velocity [m/s] (3,), inertial; zero for a fixed direction."""
        return self._rows(self._samples.states.v_i)

    @property
    def magnetic_field_b(self) -> np.ndarray:
        """The Earth's magnetic field [T] (3,), body axes; AttributeError: it does not exist."""
        return self._of('magnetic_field')

    @property
    def sun_b(self) -> np.ndarray:
        """The unit vector to the Sun (3,), body axes; AttributeError: it does not exist."""
        return self._of('sun_direction')

    @property
    def sunlight(self) -> Any:
        """The illuminance of a plate facing the Sun [lx]; AttributeError: it does not exist."""
        return self._of('sunlight')[..., 0]

    @cached_property
    def torques_b(self) -> dict[str, np.ndarray]:
        """The torques on the body [N m] (3,), body axes, by their topics, as magnetic_torque."""
        return {name: self._of(name) for name in self._torques()}

    def _torques(self):
        """Return the topics of the torques on the body."""
        system, topics = self._samples.system, self._scenario.topic_table
        return [
            name
            for name, topic in topics.items()
            if (topic.role, topic.type) == ('state', 'geometry_msgs/msg/WrenchStamped')
            and not topic.lacking(system)
        ]

    def _of(self, name):
        """Return what a topic shows; AttributeError: the scenario has no such topic."""
        topic = self._scenario.topic_table[name]
        if why := topic.lacking(self._samples.system):
            raise AttributeError(why)
        return self._rows(topic.shows[0].of(self._samples))

    def _rows(self, table):
        """Return what is wanted of a table of the samples."""
        raise NotImplementedError


class Sample(Along, State):
    """
    The state at one tick of a run, and what else there is, which follows when it is asked for.

    tick: counted from 0.

    >>> sample = simulation.step(rotor_torque={'rw_x': 1e-3})  # doctest: +SKIP
    >>> sample.measured['gyro'], sample.magnetic_field_b  # doctest: +SKIP
    """

    tick: int
    _ticks: Ticks
    _make: Callable[[], Samples]

    def __init__(
        self,
        scenario: Scenario,
        ticks: Ticks,
        tick: int,
        state: State,
        samples: Callable[[], Samples],
    ):
        # A state does not change.
        own = vars(self)
        own.update(vars(state), tick=tick)
        own['_scenario'], own['_ticks'], own['_make'] = scenario, ticks, samples

    def __repr__(self) -> str:
        return f'<Sample: tick {self.tick} at {self.t_s:g} s>'

    @property
    def t_s(self) -> float:
        """The time from tick 0 [s]."""
        return self._ticks.seconds(self.tick)

    @property
    def stamp_ns(self) -> int:
        """The stamp of the tick."""
        return self._ticks.stamp_ns(self.tick)

    @cached_property
    def _samples(self) -> Samples:
        return self._make()

    @cached_property
    def measured(self) -> dict[str, Measurement]:
        """What each sensor publishes at this tick, by its name; others are absent."""
        found = {}
        for name, measured in self._samples.measured.items():
            if len(measured):
                stamp_ns = int(measured.stamps_ns[0])
                found[name] = Measurement.of(measured.values[0], stamp_ns)
        return found

    def _rows(self, table):
        return table[0]
