"""
The variables of the integration: named parts, one behind the other.

    attitude         q (4), in the axes of the equations
    rate             omega_bi_b (3)
    momenta          p of every turning rotor
    angles           the angle of each
    modal_momenta    pi of every mode
    displacements    eta of each
    of_torques       what torques have of their own
    work             what the energy changes by
    anomaly          cos f and sin f, where the true anomaly is integrated

What every body has comes first.  Of all others nothing depends on the order.
"""

from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np

from ..kernel.vector import Vector
from ..torques.body_torque import scales_of
from .constants import Constants
from .system import State, System

ATTITUDE, RATE = slice(0, 4), slice(4, 7)
ORDER = 'momenta', 'angles', 'modal_momenta', 'displacements', 'of_torques', 'work', 'anomaly'


class Variables(NamedTuple):
    """Where each part of the variables is; size: of all together."""

    attitude: slice
    rate: slice
    momenta: slice
    angles: slice
    modal_momenta: slice
    displacements: slice
    of_torques: slice
    work: slice
    anomaly: slice
    size: int

    @classmethod
    def of(cls, what: System | Constants) -> 'Variables':
        """Return the parts of a system's variables, or of those of its constants."""
        if isinstance(what, System):
            rotors: Any = what.turning_rotors
            torques: Any = [torque.constants for torque in what.torques]
        else:
            rotors, torques = what.rotors, what.torques
        turning, modes = len(rotors), len(what.modes)
        sizes = {
            'momenta': turning,
            'angles': turning,
            'modal_momenta': modes,
            'displacements': modes,
            'of_torques': sum(len(scales_of(constants)) for constants in torques),
            'work': 1,
            'anomaly': 2 if what.integrates_anomaly else 0,
        }
        slices, end = {}, RATE.stop
        for name in ORDER:
            slices[name] = slice(end, end + sizes[name])
            end += sizes[name]
        return cls(attitude=ATTITUDE, rate=RATE, **slices, size=end)

    def joined(self, **values: Iterable[Any]) -> Vector:
        """Return the variables, or what belongs to each, by the names of the parts."""
        found: list[Any] = [0.0] * self.size
        for name, some in values.items():
            found[getattr(self, name)] = some
        return tuple(found)


def initial_values(system: System, state: State) -> np.ndarray:
    """Return the variables (..., V) of a state at the start, the anomaly f = 0."""
    parts, omega = Variables.of(system), state.omega_bi_b
    y = np.zeros((*np.shape(state.q_ib)[:-1], parts.size))
    y[..., parts.attitude], y[..., parts.rate] = state.q_ib, omega
    y[..., parts.anomaly] = (1.0, 0.0) if system.integrates_anomaly else ()
    momenta, angles = y[..., parts.momenta], y[..., parts.angles]
    for n, (i, rotor) in enumerate(system.turning_rotors):
        momenta[..., n] = rotor.axial_momentum(state.rotor_speed[..., i], omega)
        angles[..., n] = state.rotor_angle[..., i]
    modal_momenta, displacements = y[..., parts.modal_momenta], y[..., parts.displacements]
    for n, mode in enumerate(system.modes):
        modal_momenta[..., n] = state.inner.get(mode.rate_name, 0.0) + mode.along(omega)
        displacements[..., n] = state.inner.get(mode.displacement_name, 0.0)
    names = [name for torque in system.torques for name in torque.inner_names]
    own = y[..., parts.of_torques]
    for n, name in enumerate(names):
        own[..., n] = state.inner[name]
    return y


def wanted_count(system: System, does_work: bool) -> int:
    """Return how many variables are interpolated: not the anomaly, nor the work without any."""
    *kept, work, _, _ = Variables.of(system)
    return max(part.stop for part in (*kept, *([work] if does_work else [])))


def columns(system: System, out: np.ndarray) -> tuple[Any, ...]:
    """Return the columns of States of the wanted variables (..., V, N)."""
    parts = Variables.of(system)
    q_ib = out[..., parts.attitude, :].swapaxes(-2, -1)
    omega_bi_b = out[..., parts.rate, :].swapaxes(-2, -1)
    rows = out[..., 0, :].shape
    speeds = [_repeated(np.nan, rows)] * len(system.rotors)
    angles = speeds.copy()
    momenta, turned = out[..., parts.momenta, :], out[..., parts.angles, :]
    for n, (i, rotor) in enumerate(system.turning_rotors):
        speeds[i] = np.asarray(rotor.speed(momenta[..., n, :], omega_bi_b))
        angles[i] = turned[..., n, :]
    has_work = out.shape[-2] >= parts.work.stop
    work = out[..., parts.work.start, :] if has_work else _repeated(0.0, rows)
    inner = dict(_inner(system, parts, out, omega_bi_b))
    return q_ib, omega_bi_b, _of_rotors(speeds, rows), _of_rotors(angles, rows), inner, work


def _inner(
    system: System, parts: Variables, out: np.ndarray, omega_bi_b: np.ndarray
) -> Iterator[tuple[str, np.ndarray]]:
    """Yield the name and the values (..., N) of each inner coordinate."""
    momenta, displacements = out[..., parts.modal_momenta, :], out[..., parts.displacements, :]
    for n, mode in enumerate(system.modes):
        yield mode.displacement_name, displacements[..., n, :]
        yield mode.rate_name, momenta[..., n, :] - mode.along(omega_bi_b)
    names = [name for torque in system.torques for name in torque.inner_names]
    own = out[..., parts.of_torques, :]
    for n, name in enumerate(names):
        yield name, own[..., n, :]


def _repeated(value, shape):
    # Of one row, np.broadcast_to costs more than the propagation of a tick.
    return np.ndarray(shape, float, np.float64(value), strides=(0,) * len(shape))


def _of_rotors(columns, rows):
    """Return one column per rotor as a table (..., N, R), without a copy where it can."""
    if len(columns) == 1:
        return columns[0][..., None]
    return np.stack(columns, axis=-1) if columns else np.empty((*rows, 0))
