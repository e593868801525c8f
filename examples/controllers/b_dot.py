"""
Damp a tumble with magnetorquers, by what a magnetometer measures alone.

    satdyn simulate cubesat_adcs --duration 6000 --controller b_dot.py:BDot -o bags/b_dot
The law m = -k dB/dt (Stickler and Alfriend, Elementary magnetic attitude control system, Journal
of Spacecraft and Rockets 13, 1976), with differences of samples: the field seems to turn with
-omega, so that the torque m x B takes work from what turns across B.

It flies inside the run, and a run repeats to the byte.  A controller that is a program of its own,
such as flight software, closes the loop over topics: examples/bdot.py.
"""

import numpy as np


class BDot:
    """
    gain: k [A m^2 s/T], about 2 n J / B^2 with the orbital rate n and a moment J.

    By Avanzini and Giulietti (Magnetic detumbling of a rigid spacecraft, Journal of Guidance,
    Control, and Dynamics 35, 2012) that takes what turns across B and what turns about it alike.
    """

    period_s = 1.0
    needs_truth = False
    vectorized = True

    def __init__(self, gain=1e5):
        self.gain = gain

    def reset(self, scenario, seed):
        """Begin without a sample."""
        self.last = None

    def command(self, sample):
        """Return the dipole (..., 3) [A m^2], body axes; without two samples none."""
        B = sample.measured.get('magnetometer')
        if B is None:
            return {}
        last, self.last = self.last, (B.stamp_ns, np.array(B))
        if last is None:
            return {}
        last_ns, last_B = last
        # Of one run, or of each of many.
        interval_s = 1e-9 * np.asarray(B.stamp_ns - last_ns)[..., None]
        return {'dipole_b': -self.gain * (self.last[1] - last_B) / interval_s}
