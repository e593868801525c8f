"""
Point body z to the Earth with thrusters, by a phase plane of each axis.

    satdyn simulate cold_gas --duration 300 --controller phase_plane.py:PhasePlane -o bags/plane
In the plane of an axis' error and rate the body coasts inside a dead band and on its way home;
elsewhere a pulse brings it onto the curve on which half of the thrust would stop it at the edge
of the dead band (Bryson, Control of Spacecraft and Aircraft, 1994, chapter 8, has such curves).
In the end it drifts from one edge to the other, turned back by short pulses.
"""

import numpy as np
from thruster_pointing import PERIOD_S, ThrusterPointing

from satdyn_ros import guidance
from satdyn_ros.kernel import rotation


class PhasePlane(ThrusterPointing):
    """
    dead_band [rad]: the error about an axis that is left alone.

    drift, fastest [rad/s]: the least and the most rate at which the body is sent home.
    """

    def __init__(self, reference=guidance.nadir, dead_band=5e-3, drift=3e-4, fastest=0.03):
        super().__init__(reference)
        self.dead_band, self.drift, self.fastest = dead_band, drift, fastest

    def reset(self, scenario, seed):
        """Begin; what two of the thrusters give about an axis is what there is for it."""
        super().reset(scenario, seed)
        self.most = 2.0 * np.abs(self.pulses.torques_b).min(axis=1) / np.diag(self.inertia)

    def acceleration(self, q_ib, omega_b, reference):
        """Return what brings the body onto the curves in one period [rad/s^2] (3,), body axes."""
        q_br = rotation.multiply(rotation.conjugate(q_ib), reference.q_ir)
        error = -2.0 * np.copysign(1.0, q_br[3]) * q_br[:3]
        slip = omega_b - rotation.rotate(q_br, reference.omega_ri_r)
        beyond = np.maximum(np.abs(error) - self.dead_band, 0.0)
        home = np.clip(np.sqrt(self.most * beyond), self.drift, self.fastest)
        goal = -np.sign(error) * home
        # Inside the dead band, and on the way home not faster than on the curve, it coasts.
        is_slow = np.abs(slip) <= self.drift
        is_on_its_way = (slip * goal > 0.0) & (np.abs(slip) >= 0.5 * home) & (np.abs(slip) <= home)
        coasts = np.where(beyond > 0.0, is_on_its_way, is_slow)
        return np.where(coasts, 0.0, (np.where(beyond > 0.0, goal, 0.0) - slip) / PERIOD_S)
