"""
Measurement minus truth, for each sensor of a run.

The truth is what the sensor would give without any error, with the same mounting and sampling.
Without noise it would differ from that by its systematic errors: the bias with its random walk,
the scale factor, the misalignment.  What it counts from sample to sample is taken from the
attitudes (turns.py), and what it sees of the environment from the models, not from the tables
that fly: no error of these cancels out.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np

from ..dynamics.motion import Motion, States
from ..run.events import Event, Request, Reset
from ..run.samples import Samples
from ..run.ticks import Ticks
from ..sensors import Sensor, Suite
from .turns import FlownAgain

# Intervals longer than so many usual ones are pauses: a measurement is missing; some jitter.
_PAUSE = 1.7


@dataclass(frozen=True, eq=False)
class SensorErrors:
    """
    The errors of M measurements of a sensor, about its axes, or the one, z.

    Attributes
    ----------
    sensor : Sensor
        the sensor
    t_s : (M,), s
        of the exposures, from tick 0
    error : (M, 3) or (M, 1)
        measurement minus truth, see Sensor.error
    systematic : (M, 3) or (M, 1)
        the part of it that is not noise
    sigma : (3,) or (1,)
        standard deviation of the noise, as in the messages' covariance
    """

    sensor: Sensor
    t_s: np.ndarray
    error: np.ndarray
    systematic: np.ndarray
    sigma: np.ndarray

    @property
    def largest(self) -> float:
        """The largest size of an error or of an edge of three sigma; 0.0 without measurements."""
        edges = np.abs(self.systematic) + 3.0 * self.sigma
        return float(np.max([np.abs(self.error), edges], initial=0.0))


def largest_of_kind(name: str, sensors: Mapping[str, SensorErrors]) -> float | None:
    """Return the largest of the sensors of one kind, drawn to one scale; None: it is alone."""
    kind = type(sensors[name].sensor)
    alike = [errors.largest for errors in sensors.values() if isinstance(errors.sensor, kind)]
    return max(alike) if len(alike) > 1 else None


def with_gaps(errors: SensorErrors) -> SensorErrors:
    """Return errors with a row of nan wherever the sensor paused, so that no line goes across."""
    t_s = errors.t_s
    usual_s = np.median(np.diff(t_s)) if len(t_s) > 1 else np.inf
    late = np.flatnonzero(np.diff(t_s) > _PAUSE * usual_s) + 1
    return replace(
        errors,
        t_s=np.insert(t_s, late, t_s[late - 1] + usual_s),
        error=np.insert(errors.error, late, np.nan, axis=0),
        systematic=np.insert(errors.systematic, late, np.nan, axis=0),
    )


class ErrorsOfSensors:
    """
    Collects the errors of a run's sensors during the run.

    Parameters
    ----------
    suite : Suite
        the sensors before the first samples
    ticks : Ticks
        those of the run
    window : range
        the ticks whose exposures are wanted
    rows : int
        the most measurements of each
    """

    def __init__(self, suite: Suite, ticks: Ticks, window: range, rows: int):
        self._sensors, self._ticks, self._window = suite.sensors, ticks, window
        self._true, self._noiseless = suite.perfect(), suite.without_noise()
        # Every such tick's sample is kept: rows of them in the whole window.
        self._every = {
            name: sensor.divisor * -(-len(window) // (sensor.divisor * rows))
            for name, sensor in self._sensors.items()
        }
        # The motion of the last samples, and the last one that was flown again.
        self._motion: Motion | None = None
        self._flown: FlownAgain | None = None
        self._found: dict[str, list[tuple[np.ndarray, ...]]] = {name: [] for name in self._sensors}

    def take(self, motion: Motion, events: Iterable[Event], samples: Samples) -> None:
        """Process the next samples, of a motion, and what happened at their first tick."""
        if any(isinstance(event, Request | Reset) for event in events):
            self._true, self._noiseless = self._true.restarted(), self._noiseless.restarted()
        ticks = range(samples.first_tick, samples.first_tick + len(samples))
        states = samples.states
        if states.turn_b is not None:
            states = replace(states, turn_b=self._turns(motion, samples))
        true, self._true = self._true.measure(ticks, states)
        noiseless, self._noiseless = self._noiseless.measure(ticks, states)
        for name, measured in samples.measured.items():
            exposed = true[name].exposed
            # What was exposed before the first samples has no truth here.
            values = measured.values[len(measured) - len(exposed) :]
            kept = (exposed % self._every[name] == 0) & (exposed >= self._window.start)
            truth = true[name].values[kept]
            if self._sensors[name].needs and np.any(kept):
                rows = exposed[kept] - samples.first_tick
                truth = self._sensors[name].truth(_modelled(samples.states.rows(rows)))
            self._found[name].append(
                (exposed[kept], values[kept], truth, noiseless[name].values[kept])
            )

    def _turns(self, motion: Motion, samples: Samples) -> np.ndarray:
        """Return the turns (N, 3) [rad] from the ticks before, zero where none is wanted."""
        ticks, rate = samples.first_tick + np.arange(len(samples)), float(self._ticks.rate)
        wanted = np.zeros(len(ticks), bool)
        for name, sensor in self._sensors.items():
            if sensor.counts_turns:
                sample = -(-ticks // sensor.divisor) * sensor.divisor
                wanted |= (sample % self._every[name] == 0) & (sample >= self._window.start)
        fastest = float(np.linalg.norm(samples.states.omega_bi_b, axis=1).max())
        turn_b, begins = np.zeros((len(ticks), 3)), ticks > round(motion.start_s * rate)
        # At its first tick, a motion has not yet turned.
        for flown, rows in ((self._motion, wanted & ~begins), (motion, wanted & begins)):
            if flown is None or not np.any(rows):
                continue
            if self._flown is None or self._flown.motion is not flown:
                self._flown = FlownAgain(flown)
            begin_s = (ticks[rows] - 1) / rate - flown.start_s
            turn_b[rows] = self._flown.turns(np.maximum(begin_s, 0.0), 1.0 / rate, fastest)
        self._motion = motion
        return turn_b

    def result(self) -> dict[str, SensorErrors]:
        """Return the errors of all samples that were taken, by the sensors' names."""
        return {name: self._errors(name) for name, parts in self._found.items() if parts}

    def _errors(self, name: str) -> SensorErrors:
        sensor = self._sensors[name]
        exposed, values, true, noiseless = (
            np.concatenate(parts) for parts in zip(*self._found[name], strict=True)
        )
        first_ns = self._ticks.stamp_ns(0)
        return SensorErrors(
            sensor=sensor,
            t_s=(self._ticks.stamps_of(exposed) - first_ns) * 1e-9,
            error=sensor.error(values, true),
            systematic=sensor.error(noiseless, true),
            sigma=np.sqrt(sensor.variances),
        )


def _modelled(states: States) -> States:
    """Return states whose environment is that of the models."""
    along = states.environment
    assert along is not None
    models: Any = SimpleNamespace(
        magnetic_field=_Model(along.modelled_field), sun=_Model(along.modelled_sun)
    )
    return replace(states, environment=models)


@dataclass(frozen=True)
class _Model:
    """A model in place of its table."""

    function: Callable[[np.ndarray], np.ndarray]

    def values(self, t_s: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """Return what a table of it would give."""
        return self.function(t_s)[:, columns]
