"""How far the first integrals of a run that is repeated drift, and how far they may."""

import numpy as np

from ..dynamics.motion import States
from ..integrate.propagation import Propagation
from ..run.drift import Drift, MeasuredDrift
from ..run.samples import Samples
from ..run.simulation import Simulation

# A propagation is not limited by a tolerance below this.
_LEAST_TOLERANCE = 1e-13
# The variables whose errors every step looks at: attitude, rate, and the orbit's anomaly.
_VARIABLES = 9
# The last digits by which an angle since tick 0 may be off.
_ROUNDINGS = 10.0


class Conservation:
    """
    How far the first integrals of a run drift between events; drift: the largest, relative.

    A step is taken if the root mean square of its errors of n variables is within the tolerance,
    of attitude by half the angle and of rate relative to the rates that the sizes of integrals.py
    are made of: each integral changes by at most 2 sqrt(n) tolerances of its size, and by twice
    that where modes swing, whose errors are relative to the sum of the swing at both ends of the
    step.  n is nine at most, and one more for each variable of a mode or of a torque.
    From there on the motion keeps it, so that what the steps change adds up and does not grow.
    Within a step the interpolation of an oscillation is off by three times the step's estimate,
    in the first row as in the last.  Angles since tick 0, of the orbit and of the body, which a
    closed form goes through without a step, have the rounding of their own size.
    """

    def __init__(self, tolerance: float):
        self.drift: dict[str, float] = {}
        self._tolerance = max(tolerance, _LEAST_TOLERANCE)
        self._steps = 0
        self._of_a_step = 0.0
        self._angle_rad = 0.0
        self._measuring = Drift()

    @property
    def allowed(self) -> float:
        """Return the drift that as many steps, and such angles, allow."""
        # The interpolation, in two rows, is as that of six steps.
        of_steps = self._of_a_step * (self._steps + 6.0)
        return self._tolerance * of_steps + _ROUNDINGS * np.finfo(float).eps * self._angle_rad

    def observe(self, simulation: Simulation, samples: Samples) -> None:
        """Take samples of a run."""
        motion = simulation.motion
        if isinstance(motion, Propagation):
            self._steps = max(self._steps, motion.steps)
        self._add(self._measuring.take(motion, samples))

    def close(self) -> None:
        """Measure the last of them."""
        self._add(self._measuring.close())

    def _add(self, measured: list[MeasuredDrift]) -> None:
        for parts, states, drift in measured:
            if not drift:
                continue
            of_a_step = 2.0 * np.sqrt(_VARIABLES + len(states.inner))
            if parts[0].system.modes:
                of_a_step *= 2.0
            self._of_a_step = max(self._of_a_step, of_a_step)
            for name, values in drift.items():
                before = self.drift.get(name, 0.0)
                self.drift[name] = float(np.fmax.reduce(np.abs(values), initial=before))
            self._angle_rad = max(self._angle_rad, float(np.max(_angles(states))))


def _angles(states: States) -> np.ndarray:
    """Return what body and orbit turn by since tick 0, at the rates of now [rad], shape (N,)."""
    rate, orbit = np.linalg.norm(states.omega_bi_b, axis=1), states.orbit
    if orbit.has_lvlh:
        rate = rate + np.linalg.norm(orbit.lvlh_rate(states.orbit_s), axis=1)
    return rate * states.orbit_s
