"""
Point body z to the Sun, another body axis near the orbit normal, with wheels.

    satdyn simulate cubesat_adcs --duration 600 --controller sun.py:Sun -o bags/sun
By quaternion feedback (Wie, Weiss and Arapostathis 1989): quaternion_feedback.py.  The Sun is
where the time says it is, also in the shadow: no sun sensor is asked.

It flies inside the run, and a run repeats to the byte.  A controller that is a program of its own,
such as flight software, closes the loop over topics: examples/wheel_controller.py.
"""

from quaternion_feedback import QuaternionFeedback

from satdyn_ros import guidance


class Sun(QuaternionFeedback):
    """second_axis (3,): the body axis that comes near the orbit normal."""

    def __init__(self, second_axis=(1.0, 0.0, 0.0), **gains):
        super().__init__(guidance.sun(second_axis), **gains)
