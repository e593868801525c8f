"""
Point body z to the Earth, x along the velocity, with wheels.

    satdyn simulate cubesat_adcs --duration 600 --controller nadir.py:Nadir -o bags/nadir
By quaternion feedback (Wie, Weiss and Arapostathis 1989): quaternion_feedback.py.

It flies inside the run, and a run repeats to the byte.  A controller that is a program of its own,
such as flight software, closes the loop over topics: examples/wheel_controller.py.
"""

from quaternion_feedback import QuaternionFeedback

from satdyn_ros import guidance


class Nadir(QuaternionFeedback):
    """The body axes become LVLH."""

    def __init__(self, **gains):
        super().__init__(guidance.nadir, **gains)
