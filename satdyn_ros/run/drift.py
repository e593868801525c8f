"""How far the first integrals drift along a run, each since its motion began."""

from typing import NamedTuple

import numpy as np

from ..dynamics.integrals import applied_torque, conserve_alike, drift_since
from ..dynamics.motion import Motion, States, joined
from .samples import Samples

# Ticks that are measured together: some megabytes.
_MEASURED_TICKS = 4096


class MeasuredDrift(NamedTuple):
    """
    Samples that follow each other, measured.

    One row of a motion cannot drift: there is no drift where all motions have one.

    Attributes
    ----------
    parts : list of Samples
        as they were given
    states : States
        those of all their rows
    drift : dict of (N,)
        by first integral the relative change of each row, nan where it is not one
    """

    parts: list[Samples]
    states: States
    drift: dict[str, np.ndarray]


class Drift:
    """
    Measures the samples of a run in turn.

    A controller may begin a motion at every few ticks, so many motions are measured together, as
    long as they conserve the same.
    """

    def __init__(self) -> None:
        self._motion: Motion | None = None
        self._begin: States | None = None
        self._parts: list[Samples] = []
        # Before the parts the row where their first motion began, if that was measured before.
        self._carried: list[States] = []
        # The sizes of the integrals up to there, in a motion that goes on.
        self._sizes: dict[str, np.ndarray] = {}
        # By row, that one too, the row where its motion began.
        self._since: list[int] = []

    def take(self, motion: Motion, samples: Samples) -> list[MeasuredDrift]:
        """Take the next samples, which may be none; return what was measured now."""
        if len(samples) == 0:
            return []
        measured = []
        if self._parts and not (
            len(self._since) < _MEASURED_TICKS
            and conserve_alike(self._parts[0].system, samples.system)
        ):
            measured = self.close()
        if motion is not self._motion or self._begin is None:
            self._motion, self._begin = motion, samples.states.rows(slice(1))
            begin = len(self._since)
        elif self._parts:
            begin = self._since[-1]
        else:
            begin = 0
            self._carried, self._since = [self._begin], [0]
        self._parts.append(samples)
        self._since += len(samples) * [begin]
        return measured

    def close(self) -> list[MeasuredDrift]:
        """Measure what was taken since the last time."""
        if not self._parts:
            return []
        states = joined([*self._carried, *(part.states for part in self._parts)])
        since = np.array(self._since)
        drift: dict[str, np.ndarray] = {}
        if np.any(since != np.arange(len(since))):
            lengths = [len(part) for part in self._parts]
            lengths[0] += len(self._carried)
            applied = np.repeat([applied_torque(part.system) for part in self._parts], lengths)
            drift, self._sizes = drift_since(
                self._parts[0].system, states, since, applied, self._sizes if self._carried else {}
            )
        rows = slice(len(self._carried), None)
        measured = MeasuredDrift(
            self._parts, states.rows(rows), {name: values[rows] for name, values in drift.items()}
        )
        self._parts, self._carried, self._since = [], [], []
        return [measured]
