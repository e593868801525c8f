"""
Point body z to the Earth, x along the velocity, with wheels.

    satdyn simulate cubesat_adcs --duration 600 --controller nadir.py:Nadir -o bags/nadir
By quaternion feedback (Wie, Weiss and Arapostathis 1989): quaternion_feedback.py.
"""

from quaternion_feedback import QuaternionFeedback

from satdyn_ros import guidance


class Nadir(QuaternionFeedback):
    """The body axes become LVLH."""

    def __init__(self, **gains):
        super().__init__(guidance.nadir, **gains)
