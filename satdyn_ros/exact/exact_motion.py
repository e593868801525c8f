"""What all closed forms share: the rotor's speed and angle follow from the body's motion."""

from abc import abstractmethod
from typing import Any, NamedTuple

import numpy as np

from ..dynamics.motion import Motion
from ..dynamics.system import State, System


class Fact(NamedTuple):
    """
    A constant of a motion: name as in its source, value, unit ('' for none) and what it means.

    value: a number, a list of numbers, or a word; inf for an infinite period.
    """

    name: str
    value: Any
    unit: str
    meaning: str


class ExactMotion(Motion):
    """
    A motion in closed form, evaluated at any time without stepping.

    ValueError: it does not apply, with the sentence of why_not.
    """

    def __init__(self, system: System, state: State, start_s: float = 0.0):
        super().__init__(system, state, start_s)
        reason = self.why_not(system, state, start_s)
        if reason:
            raise ValueError(reason)

    @classmethod
    @abstractmethod
    def why_not(cls, system: System, state: State, start_s: float = 0.0) -> str | None:
        """
        Return one sentence that says why this closed form does not apply, or None.

        start_s: seconds from tick 0, which say where the attracting centre is.
        """

    @abstractmethod
    def facts(self) -> list[Fact]:
        """Return the constants, periods and limits that say what the motion is like."""

    @abstractmethod
    def attitude(self, t_s):
        """Return q_ib (N, 4) and omega_bi_b (N, 3) at t_s (N,)."""

    @abstractmethod
    def axial_turn(self, t_s):
        """Return the integral of a . omega from 0 to t_s [rad], (N,), a the rotor's axis."""

    def _states(self, t_s):
        q_ib, omega_bi_b = self.attitude(t_s)
        # The start is what was asked for, to the last bit.
        start_rows = t_s == 0.0
        q_ib[start_rows], omega_bi_b[start_rows] = self.state.q_ib, self.state.omega_bi_b
        rotor, start, no_work = self.system.rotor, self.state, np.zeros(len(t_s))
        if not rotor.turns_freely:
            absent = np.full(len(t_s), np.nan)
            return q_ib, omega_bi_b, absent, absent, no_work
        p = rotor.axial_momentum(start.rotor_speed, start.omega_bi_b)
        angle = start.rotor_angle + p / rotor.inertia * t_s - self.axial_turn(t_s)
        return q_ib, omega_bi_b, rotor.speed(p, omega_bi_b), angle, no_work
