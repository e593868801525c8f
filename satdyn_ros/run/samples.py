"""The results of a run: the states at its ticks, and what its sensors measured."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from ..dynamics.motion import States, joined
from ..dynamics.system import System
from ..environment import geodetic, turned
from ..sensors import Measurements
from .ticks import Ticks


class Stamped:
    """What has stamps: stamps_ns (N,) int64."""

    stamps_ns: np.ndarray

    @cached_property
    def seconds(self) -> tuple[np.ndarray, np.ndarray]:
        """The stamps' whole seconds (N,) int32, and the nanoseconds (N,) uint32 beyond them."""
        seconds, nanoseconds = np.divmod(self.stamps_ns, 10**9)
        return seconds.astype(np.int32), nanoseconds.astype(np.uint32)

    def __len__(self) -> int:
        return len(self.stamps_ns)


@dataclass(frozen=True, eq=False)
class Measured(Stamped):
    """
    What a sensor gives at some of consecutive ticks.

    Attributes
    ----------
    indices : (M,) int
        their ticks, counted from the first
    stamps_ns : (M,) int64, ns
        of the exposures
    values : (M, 3), (M, 4) or (M,)
        as of the sensor
    """

    indices: np.ndarray
    stamps_ns: np.ndarray
    values: np.ndarray

    @classmethod
    def of(cls, measurements: Measurements, first_tick: int, ticks: Ticks) -> 'Measured':
        """Return what a sensor gives from a tick on."""
        stamps_ns = ticks.stamps_of(measurements.exposed)
        return cls(measurements.ticks - first_tick, stamps_ns, measurements.values)


@dataclass(frozen=True, eq=False)
class Samples(Stamped):
    """
    What happens at consecutive ticks, all under one event.

    Attributes
    ----------
    first_tick : int
        the tick of row 0
    stamps_ns : (N,) int64, ns
        of the rows
    states : States
        the rows' states
    system : System
        body, field and the torques that act
    measured : dict of Measured
        what the sensors give, by their names
    acting : dict
        what actuators are commanded, by the names under which it is held
    """

    first_tick: int
    stamps_ns: np.ndarray
    states: States
    system: System
    measured: Mapping[str, Measured] = field(default_factory=dict)
    acting: Mapping[str, Any] = field(default_factory=dict)

    def rows(self, first: int, last: int) -> 'Samples':
        """Return what happens at the ticks of the rows from first to before last."""
        measured = {
            name: Measured(some.indices[at] - first, some.stamps_ns[at], some.values[at])
            for name, some in self.measured.items()
            for at in [(first <= some.indices) & (some.indices < last)]
        }
        return Samples(
            self.first_tick + first,
            self.stamps_ns[first:last],
            self.states.rows(slice(first, last)),
            self.system,
            measured,
            self.acting,
        )

    @property
    def rotor_torque(self) -> np.ndarray:
        """The torques of the motors [N m], (N, R)."""
        torque = self.states.rotor_torque
        if torque is None:
            torque = self.system.rotor_torque
        return np.broadcast_to(torque, (len(self), len(self.system.rotors)))

    @cached_property
    def to_itrs(self) -> np.ndarray:
        """The matrices (N, 3, 3) that turn components in inertial axes into ITRS."""
        environment = self.states.environment
        assert environment is not None
        return environment.to_itrs.values(self.states.orbit_s, np.arange(9)).reshape(-1, 3, 3)

    @cached_property
    def geodetic(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Latitude and longitude [rad] and height [m] on WGS 84, (N,) each."""
        return geodetic(turned(self.to_itrs, self.states.r_i))


def merged(parts: Sequence[Samples]) -> Samples:
    """Return samples that follow each other as one, with the system of the first."""
    if len(parts) == 1:
        return parts[0]
    first_tick = parts[0].first_tick
    measured: dict[str, list[tuple[int, Measured]]] = {}
    for part in parts:
        for name, found in part.measured.items():
            measured.setdefault(name, []).append((part.first_tick - first_tick, found))
    return Samples(
        first_tick,
        np.concatenate([part.stamps_ns for part in parts]),
        joined([part.states for part in parts]),
        parts[0].system,
        {
            name: Measured(
                np.concatenate([before + some.indices for before, some in found]),
                np.concatenate([some.stamps_ns for _, some in found]),
                np.concatenate([some.values for _, some in found]),
            )
            for name, found in measured.items()
        },
        parts[0].acting,
    )
