"""
Point body z to the Earth with thrusters, by pulse-width modulation.

    satdyn simulate cold_gas --duration 300 --controller thruster_pointing.py:ThrusterPointing
Once a period the torque of the quaternion feedback (Wie, Weiss and Arapostathis 1989), times the
period, is given as pulses: thruster_pulses.py.
"""

import numpy as np
from quaternion_feedback import QuaternionFeedback
from thruster_pulses import Pulses

from satdyn_ros import guidance

# From the beginning of pulses to that of the next [s].
PERIOD_S = 1.0


class ThrusterPointing(QuaternionFeedback):
    """The body axes become LVLH, or another reference of satdyn_ros.guidance."""

    def __init__(self, reference=guidance.nadir, swing_rad_s=0.15, damping=0.9):
        super().__init__(reference, swing_rad_s, damping)

    def reset(self, scenario, seed):
        """Begin with what the scenario says of the body and its thrusters."""
        super().reset(scenario, seed)
        self.pulses = Pulses(scenario, PERIOD_S)
        self.every = round(PERIOD_S * scenario['publish.rate'])

    def command(self, sample):
        """Return the on-times [s] by name, once a period."""
        torque_b = self.torque(sample)
        if torque_b is None or sample.tick % self.every:
            return {}
        return {'thrusters': self.pulses.on_times(PERIOD_S * torque_b)}

    def wheel_momentum(self, sample):
        """Return that there is none."""
        return np.zeros(3)
