"""
Turn to an attitude in inertial axes and hold it, with wheels.

    satdyn simulate cubesat_adcs --duration 600 --controller inertial.py:Inertial -o bags/inertial
By quaternion feedback (Wie, Weiss and Arapostathis 1989): quaternion_feedback.py.

It flies inside the run, and a run repeats to the byte.  A controller that is a program of its own,
such as flight software, closes the loop over topics: examples/wheel_controller.py.
"""

from quaternion_feedback import QuaternionFeedback

from satdyn_ros import guidance


class Inertial(QuaternionFeedback):
    """
    q (4,): the attitude x, y, z, w, from body to inertial axes.

    By default z is along inertial -Y, and the star tracker of cubesat_adcs, which looks the other
    way, sees sky all along the orbit.
    """

    def __init__(self, q=(1.0, 0.0, 0.0, 1.0), **gains):
        super().__init__(guidance.inertial(q), **gains)
