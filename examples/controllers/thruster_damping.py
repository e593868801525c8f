"""
Take a body's rate away with thrusters, by what a gyro measures.

    satdyn simulate cold_gas --duration 60 --controller thruster_damping.py:ThrusterDamping
Once a period all the momentum that is left is asked for; what the pulses cannot give in it comes
in the next.
"""

import numpy as np
from thruster_pulses import Pulses

from satdyn_ros.kernel import rotation


class ThrusterDamping:
    """dead_band [rad/s]: a rate within it is left alone, so that noise costs no propellant."""

    period_s = 1.0
    needs_truth = False

    def __init__(self, dead_band=2e-4):
        self.dead_band = dead_band

    def reset(self, scenario, seed):
        """Begin with what the scenario says of the body, its thrusters and its gyro."""
        self.inertia, self.pulses = scenario.system.inertia, Pulses(scenario, self.period_s)
        self.q_bg = scenario['sensors.gyro.mounting']

    def command(self, sample):
        """Return the on-times [s] by name."""
        omega_b = rotation.rotate(self.q_bg, sample.measured['gyro'])
        left_b = np.where(np.abs(omega_b) > self.dead_band, omega_b, 0.0)
        return {'thrusters': self.pulses.on_times(-self.inertia @ left_b)}
