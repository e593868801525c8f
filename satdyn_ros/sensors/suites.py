"""The sensors of many runs, alike but for their noise, each run at a tick of its own."""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np

from ..dynamics.motion import States
from .noise import normals
from .sensor import Sensor

# Samples of noise that are drawn at once for a run.
_DRAWN = 64


class Suites:
    """
    The suites of M runs, each with the bits that it has alone.

    Parameters
    ----------
    sensors : sequence of dict
        of each run, by name, such as need not be alone

    Attributes
    ----------
    are_any : bool
        whether there are any

    Raises
    ------
    ValueError
        they differ by more than their seeds
    """

    def __init__(self, sensors: Sequence[Mapping[str, Sensor]]):
        self._alike = without_seeds(sensors[0])
        self._kinds = {name: _Kind(sensor, len(sensors)) for name, sensor in sensors[0].items()}
        self.are_any = bool(self._kinds)
        for m, each in enumerate(sensors):
            self.refuse_others(each)
            self.begin(m, each)

    def refuse_others(self, sensors: Mapping[str, Sensor]) -> None:
        """Raise ValueError for sensors that differ by more than their seed."""
        if without_seeds(sensors) != self._alike:
            raise ValueError(
                'the sensors of runs side by side must be the same but for sensors.seed'
            )

    def begin(self, m: int, sensors: Mapping[str, Sensor]) -> None:
        """Let run m begin anew with these sensors, which are alike."""
        for name, sensor in sensors.items():
            self._kinds[name].begin(m, sensor)

    def measure(
        self, rows: np.ndarray, ticks: np.ndarray, states: States
    ) -> dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """
        Return by sensor what runs publish: runs, exposed ticks and values.

        Parameters
        ----------
        rows : (K,) int
            the runs
        ticks : (M,) int
            where each of all runs stands
        states : States
            of all runs
        """
        return {name: kind.measure(rows, ticks, states) for name, kind in self._kinds.items()}


class _Kind:
    """One sensor in M runs."""

    def __init__(self, sensor: Sensor, count: int):
        self._sensor, self._seeds = sensor, [0] * count
        self._biases = np.full((count, 3), np.nan)
        self._drawn = np.zeros((count, _DRAWN, sensor.deviates))
        # Which sample the first that is drawn is, -_DRAWN: none is.
        self._first = np.full(count, -_DRAWN)
        # Runs, exposed ticks and values of what is not yet published, of a sensor with a latency.
        self._waiting: tuple[np.ndarray, ...] | None = None

    def begin(self, m, sensor):
        self._seeds[m], self._biases[m], self._first[m] = sensor.seed, np.nan, -_DRAWN
        if self._waiting is not None:
            stay = self._waiting[0] != m
            self._waiting = tuple(part[stay] for part in self._waiting)

    def measure(self, rows, ticks, states):
        runs = rows[ticks[rows] % self._sensor.divisor == 0]
        deviates, before = self._deviates(runs, ticks[runs]), self._biases[runs]
        values, sees, self._biases[runs] = self._sensor.read(states, runs, deviates, before)
        if sees is not None:
            runs, values = runs[sees], values[sees]
        if not self._sensor.latency:
            return runs, ticks[runs], values
        found: tuple[np.ndarray, ...] = runs, ticks[runs], values
        if self._waiting is not None:
            found = tuple(map(np.concatenate, zip(self._waiting, found, strict=True)))
        runs, exposed, _ = found
        is_due = (exposed + self._sensor.latency == ticks[runs]) & np.isin(runs, rows)
        self._waiting = tuple(part[~is_due] for part in found)
        return tuple(part[is_due] for part in found)

    def _deviates(self, runs, ticks):
        """Return the deviates of the samples at ticks of runs (K,), drawn ahead."""
        sensor, samples = self._sensor, ticks // self._sensor.divisor
        after = samples - self._first[runs]
        for m in runs[(after < 0) | (after >= _DRAWN)].tolist():
            first = self._first[m] = samples[runs == m][0]
            ahead = range(
                first * sensor.divisor, (first + _DRAWN) * sensor.divisor, sensor.divisor
            )
            self._drawn[m] = normals(self._seeds[m], sensor.stream, ahead, sensor.deviates)
        return self._drawn[runs, samples - self._first[runs]]


def why_alone(sensors: Mapping[str, Sensor]) -> str:
    """Return why sensors measure in a run alone, in one sentence; '': they need not."""
    for sensor in sensors.values():
        if sensor.counts_turns:
            return (
                'a gyro of runs side by side must not be integrating; leave out '
                'sensors.NAME.integrating'
            )
        for leaf in ('bias_instability', 'torquer_coupling'):
            if np.any(getattr(sensor, leaf, 0.0)):
                return (
                    f'a {sensor.kind} of runs side by side must have no {leaf}; leave out '
                    f'sensors.NAME.{leaf}'
                )
    return ''


def without_seeds(sensors: Mapping[str, Any]) -> dict[str, Any]:
    """Return what sensors are beside their seeds, as can be compared."""
    return {
        name: {f.name: np.array(getattr(sensor, f.name)).tolist() for f in fields(sensor)}
        | {'seed': type(sensor)}
        for name, sensor in sensors.items()
    }
