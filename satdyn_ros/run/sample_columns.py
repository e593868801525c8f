"""What many runs give at a tick of each, by attribute: columns, a row of each run."""

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from ..dynamics.motion import States
from .sample import Along, Measurement
from .samples import Samples
from .scenario import Scenario
from .ticks import Ticks


class SampleColumns(Along):
    """
    As a Sample, of M runs.

    tick, t_s [s] and stamp_ns (M,); q_ib (M, 4), omega_bi_b [rad/s] (M, 3), rotor_speed [rad/s]
    and rotor_angle [rad] (M, R); all else likewise with one more axis in front.  What a run has
    none of is nan there.
    """

    def __init__(
        self,
        scenario: Scenario,
        ticks: Ticks,
        tick: np.ndarray,
        states: States,
        measured: Mapping[str, tuple[np.ndarray, np.ndarray]],
        alone: Callable[[int], Samples],
    ):
        self._scenario, self._ticks, self._measured, self._alone = scenario, ticks, measured, alone
        self.tick, self.q_ib, self.omega_bi_b = tick, states.q_ib, states.omega_bi_b
        self.rotor_speed, self.rotor_angle = states.rotor_speed, states.rotor_angle
        self._states = states

    def __len__(self) -> int:
        return len(self.tick)

    @property
    def t_s(self) -> np.ndarray:
        """The times from tick 0 [s] (M,)."""
        return self._states.orbit_s

    @cached_property
    def stamp_ns(self) -> np.ndarray:
        """The stamps of the ticks (M,)."""
        return self._ticks.stamps_of(self.tick)

    @cached_property
    def _samples(self) -> Samples:
        return Samples(0, self.stamp_ns, self._states, self._scenario.system)

    @cached_property
    def measured(self) -> dict[str, Measurement]:
        """What each sensor publishes at these ticks, by its name; that none does are absent."""
        return {
            name: Measurement.of(values, self._ticks.stamps_of(exposed))
            for name, (values, exposed) in self._measured.items()
            if not np.isnan(values).all()
        }

    @cached_property
    def torques_b(self) -> dict[str, np.ndarray]:
        """The torques on the bodies [N m] (M, 3), body axes, by their topics."""
        table = self._scenario.topic_table
        each = [self._alone(m) for m in range(len(self))]
        return {
            name: np.concatenate([table[name].shows[0].of(samples) for samples in each])
            for name in self._torques()
        }

    def _rows(self, table):
        return table


class Apart:
    """States of M runs, a row of each, that do not share orbit and environment, by attribute."""

    def __init__(self, parts: Sequence[tuple[np.ndarray, States]]):
        self._parts = parts

    def __getattr__(self, name: str) -> Any:
        """Return what each of the parts has, in its rows."""
        if name.startswith('_'):
            raise AttributeError(name)
        found = [(rows, getattr(states, name)) for rows, states in self._parts]
        count = sum(len(rows) for rows, _ in found)
        whole = np.empty((count, *found[0][1].shape[1:]))
        for rows, values in found:
            whole[rows] = values
        setattr(self, name, whole)
        return whole
