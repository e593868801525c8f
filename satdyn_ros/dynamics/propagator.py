"""
The numeric motion: the equations integrated by the explicit Runge-Kutta method of dop853.py.

The steps do not depend on the times that are asked for.
"""

import numpy as np

from ..compiled import compiled, is_kept
from .dop853 import interpolate, make_dense, step
from .equations import (
    ANGLE,
    CENTRE,
    MOMENTUM,
    OMEGA,
    SIZE,
    WORK,
    Q,
    initial_values,
    parameters,
)
from .motion import Motion, States
from .system import State, System

DEFAULT_TOLERANCE = 1e-12


class Propagation(Motion):
    """
    The motion of any system by numerical propagation.

    tolerance: relative local error of a step.  The propagation walks forward and keeps only its
    last step, so that memory stays flat; asked for an earlier time it begins again.

    of, anomaly: the constants of the equations, and mean anomaly at the start [rad], mean motion
    [rad/s] and eccentricity; wanted: the variables that it interpolates (equations.py).

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
        self.of = parameters(system)
        self.anomaly = _anomaly(system, start_s)
        self.wanted = _wanted(system, self.of)
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
        out = np.empty((len(self.wanted), len(t_s)))
        reached_s = _walk(
            sorted_s,
            self.wanted,
            out,
            self._clock,
            self._y,
            self._stages,
            self._dense,
            self.anomaly,
            self.of,
            self.tolerance,
        )
        if len(t_s) and reached_s < sorted_s[-1]:
            raise self.halt(reached_s)
        if order is not None:
            out[:, order] = out.copy()
        return self._columns(out)

    def halt(self, reached_s: float) -> RuntimeError:
        """Return the error of a propagation that gets no further than reached_s."""
        return RuntimeError(
            f'the propagation came to a halt at {reached_s:g} s: no step meets the tolerance '
            f'{self.tolerance:g}'
        )

    def states_of(self, t_s: np.ndarray, out: np.ndarray) -> States:
        """Return the states at t_s (N,) of the wanted variables (V, N)."""
        return self._table(t_s, *self._columns(out))

    def _columns(self, out):
        found = dict(zip(self.wanted, out, strict=True))
        q_ib, omega_bi_b = out[Q:OMEGA].T, out[OMEGA:CENTRE].T
        rotor = self.system.rotor
        speed = rotor.speed(found.get(MOMENTUM, np.nan), omega_bi_b)
        angle = found.get(ANGLE, speed)
        work = found.get(WORK, np.broadcast_to(0.0, out.shape[1]))
        return q_ib, omega_bi_b, speed, angle, work


def _wanted(system, of):
    """Return the variables to be interpolated; the others are constant, or have no value."""
    wanted = [*range(Q, CENTRE)]
    if system.rotor.turns_freely:
        wanted += [MOMENTUM, ANGLE]
    if of.does_work:
        wanted += [WORK]
    return np.array(wanted)


def is_compiled() -> bool:
    """Return whether the compiled code is on disk; without it, the first use takes seconds."""
    return is_kept(_walk)


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


@compiled
def _walk(t_s, wanted, out, clock, y, k, dense, anomaly, of, tolerance):
    """
    Fill out with the wanted variables at the ascending times t_s (N,); return the time reached.

    clock, y, k, dense: the step in hand, as in dop853.py.
    """
    first, count = 0, len(t_s)
    while first < count:
        last = first
        while last < count and t_s[last] <= clock[1]:
            last += 1
        if last > first:
            if clock[4] == 0.0:
                make_dense(clock, y, k, dense, of)
            interpolate(t_s, wanted, out, first, last, clock, dense)
            first = last
        elif not step(clock, y, k, dense, anomaly, of, tolerance):
            return clock[1]
    return np.inf
