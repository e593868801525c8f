"""
Point to nadir with wheels, and take their momentum from them with magnetorquers.

    satdyn simulate cubesat_adcs --duration 6000 --controller dumping.py:Dumping -o bags/dumping
Against the momentum h of the wheels the torquers make the torque T = -k h as far as the field B
allows, by the dipole m = B x T / |B|^2 (Camillo and Markley, Orbit-averaged behavior of magnetic
control laws for momentum unloading, Journal of Guidance and Control 3, 1980).  The wheels give the
body the opposite torque, which slows them down.

It flies inside the run, and a run repeats to the byte.  A controller that is a program of its own,
such as flight software, closes the loop over topics: examples/wheel_controller.py.
"""

import numpy as np
from nadir import Nadir


class Dumping(Nadir):
    """dumping_per_s: k [1/s]."""

    def __init__(self, dumping_per_s=1e-3, **gains):
        super().__init__(**gains)
        self.dumping_per_s = dumping_per_s

    def reset(self, scenario, seed):
        """Begin with what the scenario says of the body, its wheels and its torquers."""
        super().reset(scenario, seed)
        self.max_dipole = np.array(scenario['magnetorquer.max_dipole'])

    def command(self, sample):
        """Return torques of the motors [N m] and the dipole (3,) [A m^2]."""
        torque_b, B = self.torque(sample), sample.measured.get('magnetometer')
        if torque_b is None or B is None:
            return {}
        dumped_b = -self.dumping_per_s * self.wheel_momentum(sample)
        dipole_b = np.cross(B, dumped_b) / (B @ B)
        dipole_b = np.clip(dipole_b, -self.max_dipole, self.max_dipole)
        torques = self.motor_torques(torque_b - np.cross(dipole_b, B), sample.rotor_speed)
        return {'rotor_torque': torques, 'dipole_b': tuple(dipole_b.tolist())}
