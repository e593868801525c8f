"""
Point body z to a point on the ground, x near the velocity, with wheels.

    satdyn simulate cubesat_adcs --duration 600 --controller target.py:Target -o bags/target
By quaternion feedback (Wie, Weiss and Arapostathis 1989): quaternion_feedback.py.

It flies inside the run, and a run repeats to the byte.  A controller that is a program of its own,
such as flight software, closes the loop over topics: examples/wheel_controller.py.
"""

from quaternion_feedback import QuaternionFeedback

from satdyn_ros import guidance


class Target(QuaternionFeedback):
    """
    latitude, longitude: of the point [rad], or texts; see guidance.target.

    By default Darmstadt, from where OPS-SAT was flown.
    """

    def __init__(self, latitude='49.871 deg', longitude='8.622 deg', **gains):
        super().__init__(guidance.target(latitude, longitude), **gains)
