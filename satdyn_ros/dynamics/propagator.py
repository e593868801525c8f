"""
The numeric motion: the equations integrated by the explicit Runge-Kutta method of order 8.

Dormand and Prince's method with the error estimates of orders 5 and 3 and the dense output of
order 7 (Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, 1993, II.5, II.6,
II.10).  The steps do not depend on the times that are asked for.
"""

from pathlib import Path

import numpy as np
from numba import njit

from .equations import (
    ANGLE,
    CENTRE,
    MOMENTUM,
    OMEGA,
    SIZE,
    WORK,
    derivative,
    initial_values,
    parameters,
)
from .motion import Motion
from .orbit import true_anomaly
from .system import State, System
from .tableau import COLUMNS, DENSE, ENTRIES, ERROR_3, ERROR_5, LENGTHS
from .vector import COMPILED

DEFAULT_TOLERANCE = 1e-12
_ZERO = np.zeros(SIZE)


class Propagation(Motion):
    """
    The motion of any system by numerical propagation.

    tolerance: relative local error of a step.  The propagation walks forward and keeps only its
    last step, so that memory stays flat; asked for an earlier time it begins again.

    >>> Propagation(system, state).at([10.0, 20.0]).q_ib  # doctest: +SKIP
    """

    name = 'propagation'
    source = 'Hairer, Norsett and Wanner 1993, II.10 (DOP853)'

    def __init__(
        self,
        system: System,
        state: State,
        start_s: float = 0.0,
        tolerance: float = DEFAULT_TOLERANCE,
    ):
        super().__init__(system, state, start_s)
        self.tolerance = tolerance
        self._of = parameters(system)
        self._anomaly = _anomaly(system, start_s)
        # Attitude and rate always; what stays constant or has no value is not interpolated.
        self._wanted = WORK + 1 if self._of.does_work else MOMENTUM
        if system.rotor.turns_freely:
            self._wanted = max(self._wanted, ANGLE + 1)
        self._begin()

    @property
    def steps(self) -> int:
        """The number of steps taken to where the propagation now stands."""
        return int(self._clock[3])

    def _begin(self):
        self._y = initial_values(self.system, self.state)
        self._stages = np.zeros((16, SIZE))
        self._dense = np.zeros((8, SIZE))
        self._dense[0] = self._y
        self._clock = np.zeros(5)
        self._clock[4] = 1.0

    def _states(self, t_s):
        order = None if (t_s[1:] >= t_s[:-1]).all() else np.argsort(t_s, kind='stable')
        sorted_s = t_s if order is None else t_s[order]
        if len(t_s) and sorted_s[0] < self._clock[0]:
            self._begin()
        out = np.empty((self._wanted, len(t_s)))
        reached_s = _walk(
            sorted_s,
            out,
            self._clock,
            self._y,
            self._stages,
            self._dense,
            self._anomaly,
            self._of,
            self.tolerance,
        )
        if len(t_s) and reached_s < sorted_s[-1]:
            raise RuntimeError(
                f'the propagation came to a halt at {reached_s:g} s: no step meets the tolerance '
                f'{self.tolerance:g}'
            )
        if order is not None:
            out[:, order] = out.copy()
        q_ib, omega_bi_b = out[:4].T, out[4:7].T
        q_ib, omega_bi_b = out[:OMEGA].T, out[OMEGA:MOMENTUM].T
        rotor = self.system.rotor
        p = out[MOMENTUM] if self._wanted > MOMENTUM else np.nan
        speed = rotor.speed(p, omega_bi_b)
        angle = out[ANGLE] if rotor.turns_freely else speed
        work = out[WORK] if self._of.does_work else np.broadcast_to(0.0, len(t_s))
        return q_ib, omega_bi_b, speed, angle, work


def is_compiled() -> bool:
    """Return whether the compiled code is on disk; without it, the first use takes seconds."""
    return any(Path(_walk.stats.cache_path).glob('propagator._walk-*.nbi'))


def _anomaly(system, start_s):
    """Return mean anomaly at the start, mean motion and eccentricity; zeros: no orbit."""
    orbit = system.orbit
    if not orbit.has_lvlh:
        return 0.0, 0.0, 0.0
    return (
        float(orbit.mean_anomaly + orbit.mean_motion * start_s),
        float(orbit.mean_motion),
        float(orbit.eccentricity),
    )


@njit(**COMPILED)
def _walk(t_s, out, clock, y, k, dense, anomaly, of, tolerance):
    """
    Fill out (SIZE, N) with the variables at the ascending times t_s (N,); return the time reached.

    clock: begin and end of the step in hand, the next step's proposed length, steps taken, and
    whether the dense output is ready.  y (SIZE,): the variables at the step's end; k: its stages.
    """
    first, count = 0, len(t_s)
    while first < count:
        last = first
        while last < count and t_s[last] <= clock[1]:
            last += 1
        if last > first:
            if clock[4] == 0.0:
                _make_dense(clock, y, k, dense, of)
            _interpolate(t_s, out, first, last, clock, dense)
            first = last
        elif not _step(clock, y, k, dense, anomaly, of, tolerance):
            return clock[1]
    return np.inf


@njit(**COMPILED)
def _step(clock, y, k, dense, anomaly, of, tolerance):
    """Take one step within the tolerance; return whether there is one."""
    t, y_0 = clock[1], dense[0]
    f = true_anomaly(anomaly[0] + anomaly[1] * t, anomaly[2])
    y[CENTRE], y[CENTRE + 1] = np.cos(f), np.sin(f)
    y_0[:] = y
    h = clock[2]
    if h == 0.0:
        h = 0.01 / (np.sqrt(_square(y_0, OMEGA)) + of.anomaly_rate + 1e-9)
    largest_growth = 6.0
    while True:
        if not t + h > t:
            return False
        h = (t + h) - t
        for i in range(12):
            derivative(y, of, k[i])
            _combine(i + 1, y_0, h, k, y)
        derivative(y, of, k[12])
        error = _error(y_0, h, k, of.slow_rate) / tolerance
        if error <= 1.0:
            break
        # nan fails every comparison: such a step is cut, until it is too short to be one.
        h *= max(0.2, 0.9 * error**-0.125) if error < np.inf else 0.2
        largest_growth = 1.0
        y[:] = y_0
    growth = 0.9 * max(error, 1e-12) ** -0.125
    clock[0], clock[1], clock[2] = t, t + h, h * min(largest_growth, growth)
    clock[3], clock[4] = clock[3] + 1.0, 0.0
    return True


@njit(inline='always', **COMPILED)
def _combine(row, y, h, k, z):
    """Write z = y + h sum_j a_j k_j with row's entries a_j: SIZE sums, held in registers."""
    s0 = s1 = s2 = s3 = s4 = s5 = s6 = s7 = s8 = s9 = s10 = s11 = 0.0
    for n in range(LENGTHS[row]):
        a, j = ENTRIES[row, n], COLUMNS[row, n]
        s0, s1, s2 = s0 + a * k[j, 0], s1 + a * k[j, 1], s2 + a * k[j, 2]
        s3, s4, s5 = s3 + a * k[j, 3], s4 + a * k[j, 4], s5 + a * k[j, 5]
        s6, s7, s8 = s6 + a * k[j, 6], s7 + a * k[j, 7], s8 + a * k[j, 8]
        s9, s10, s11 = s9 + a * k[j, 9], s10 + a * k[j, 10], s11 + a * k[j, 11]
    z[0], z[1], z[2] = y[0] + h * s0, y[1] + h * s1, y[2] + h * s2
    z[3], z[4], z[5] = y[3] + h * s3, y[4] + h * s4, y[5] + h * s5
    z[6], z[7], z[8] = y[6] + h * s6, y[7] + h * s7, y[8] + h * s8
    z[9], z[10], z[11] = y[9] + h * s9, y[10] + h * s10, y[11] + h * s11


@njit(**COMPILED)
def _error(y, h, k, slow_rate):
    """Return the error of a step from y, the mean over attitude, rate and orbit."""
    e_3, e_5 = k[13], k[14]
    _combine(ERROR_3, _ZERO, h, k, e_3)
    _combine(ERROR_5, _ZERO, h, k, e_5)
    # The natural scale of a rate: the rate itself and the root of the acceleration.  At rest both
    # may be rounding, which needs no digits.
    omega_scale = np.sqrt(_square(y, OMEGA)) + np.sqrt(np.sqrt(_square(k[0], OMEGA)))
    omega_scale += slow_rate + 1e-300
    square_3 = square_5 = 0.0
    for i in range(SIZE):
        if MOMENTUM <= i < CENTRE:
            continue
        scale = 1.0 / omega_scale if OMEGA <= i < MOMENTUM else 1.0
        square_3 += (scale * e_3[i]) ** 2
        square_5 += (scale * e_5[i]) ** 2
    if square_5 == 0.0:
        return 0.0
    return square_5 / np.sqrt(9.0 * (square_5 + 0.01 * square_3))


@njit(**COMPILED)
def _make_dense(clock, y, k, dense, of):
    """Write the terms of the dense output of the step in hand, y at its begin in dense[0]."""
    h, y_0, z = clock[1] - clock[0], dense[0], np.empty(SIZE)
    for i in range(13, 16):
        _combine(i, y_0, h, k, z)
        derivative(z, of, k[i])
    for i in range(SIZE):
        rise = y[i] - y_0[i]
        dense[1, i] = rise
        dense[2, i] = h * k[0, i] - rise
        dense[3, i] = 2.0 * rise - h * (k[0, i] + k[12, i])
    for n in range(4):
        _combine(DENSE + n, _ZERO, h, k, dense[4 + n])
    clock[4] = 1.0


@njit(**COMPILED)
def _interpolate(t_s, out, first, last, clock, dense):
    """Evaluate the dense output at t_s[first:last]; the quaternions come out as unit."""
    h = clock[1] - clock[0]
    per_step = 1.0 / h if h > 0.0 else 0.0
    for i in range(len(out)):
        d0, d1, d2, d3 = dense[0, i], dense[1, i], dense[2, i], dense[3, i]
        d4, d5, d6, d7 = dense[4, i], dense[5, i], dense[6, i], dense[7, i]
        for n in range(first, last):
            x = (t_s[n] - clock[0]) * per_step
            y = 1.0 - x
            out[i, n] = d0 + x * (
                d1 + y * (d2 + x * (d3 + y * (d4 + x * (d5 + y * (d6 + x * d7)))))
            )
    for n in range(first, last):
        square = out[0, n] ** 2 + out[1, n] ** 2 + out[2, n] ** 2 + out[3, n] ** 2
        # A quaternion that is unit to rounding stays as it is: a requested one is kept exactly.
        unit = 1.0 if abs(square - 1.0) < 1e-15 else 1.0 / np.sqrt(square)
        for i in range(4):
            out[i, n] *= unit


@njit(**COMPILED)
def _square(y, i):
    return y[i] * y[i] + y[i + 1] * y[i + 1] + y[i + 2] * y[i + 2]
