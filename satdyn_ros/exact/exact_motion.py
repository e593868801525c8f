"""What all closed forms share: the rotors' speeds and angles follow from the body's motion."""

from abc import abstractmethod
from dataclasses import replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..dynamics.motion import Motion
from ..dynamics.system import State, System
from ..theory.equilibria import direction

# Times evaluated at once: what is computed from them stays in the processor's cache.
_BLOCK = 4096
# Gauss and Legendre's rule, for parts of this length in the inverse of a motion's sharpness; how
# many parts are evaluated at once.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)
_SMOOTH, _PARTS = 0.5, _BLOCK // 8


class Fact(NamedTuple):
    """
    A constant of a motion.

    Attributes
    ----------
    name : str
        as in its source
    value : number, list of numbers, or word
        inf for an infinite period
    unit : str
        empty: none
    meaning : str
        what it is
    """

    name: str
    value: Any
    unit: str
    meaning: str


class ExactMotion(Motion):
    """
    A motion in closed form, evaluated at any time without steps.

    takes_torque_b says whether it may hold under a constant torque on the body, which its own
    conditions then judge.  Every other closed form refuses a driven system.

    Parameters
    ----------
    system : System
        what moves
    state : State
        its state at the start
    start_s : s
        time of the start from tick 0

    Raises
    ------
    ValueError
        the closed form does not apply, with the sentence of why_not
    """

    takes_torque_b = False

    def __init__(self, system: System, state: State, start_s: float = 0.0):
        super().__init__(system, state, start_s)
        reason = self.why_not(system, state, start_s)
        if reason:
            raise ValueError(reason)

    @classmethod
    def why_not(cls, system: System, state: State, start_s: float = 0.0) -> str | None:
        """
        Return one sentence that says why this closed form does not apply, or None.

        Parameters
        ----------
        system : System
            what moves
        state : State
            its state at start_s
        start_s : s
            time from tick 0, which determines where the attracting centre is

        Raises
        ------
        ValueError
            the state lacks the speed or the angle of a free rotor
        """
        system.check(state)
        for rotor in system.rotors:
            if rotor.is_damped:
                key = f'rotor.{rotor.name}'.rstrip('.')
                kind = 'friction' if rotor.friction else 'coulomb_friction'
                return f'{key}.{kind} is not zero: friction drives the body'
        if system.modes:
            names = ', '.join(mode.name for mode in system.modes)
            return f'closed forms do not know the flexible parts {names}'
        if system.torques:
            names = ', '.join(torque.name for torque in system.torques)
            return f'closed forms do not know the torque {names}'
        known = replace(system, torque_b=np.zeros(3)) if cls.takes_torque_b else system
        if not known.is_newtonian:
            return 'a torque is applied to the body or to a rotor'
        return cls._why_not(system, state, start_s)

    @classmethod
    @abstractmethod
    def _why_not(cls, system: System, state: State, start_s: float = 0.0) -> str | None:
        """Return why_not of a system without motor torque and friction."""

    @abstractmethod
    def facts(self) -> list[Fact]:
        """Return the constants, periods and limits that say what the motion is like."""

    @abstractmethod
    def attitude(self, t_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """
        Return the attitude q_ib (N, 4) and the rate omega_bi_b (N, 3) [rad/s].

        Parameters
        ----------
        t_s : (N,), s
            since the motion began
        """

    @abstractmethod
    def axial_turn(self, t_s: np.ndarray, axis: np.ndarray) -> np.ndarray:
        """
        Return the integral of axis . omega from 0 to t_s (N,) [rad], for a rotor's axis.

        Parameters
        ----------
        t_s : (N,), s
            since the motion began
        axis : (3,), body axes
            the rotor's unit axis
        """

    def _states(self, t_s, turn_b=None):
        if turn_b is not None:
            self._add_turns(t_s, turn_b)
        q_ib, omega_bi_b = np.empty((len(t_s), 4)), np.empty((len(t_s), 3))
        for i in range(0, len(t_s), _BLOCK):
            rows = slice(i, i + _BLOCK)
            q_ib[rows], omega_bi_b[rows] = self.attitude(t_s[rows])
        # The start is the given state, to the last bit.
        start_rows = t_s == 0.0
        q_ib[start_rows], omega_bi_b[start_rows] = self.state.q_ib, self.state.omega_bi_b
        start, rotors = self.state, self.system.rotors
        speeds = np.full((len(t_s), len(rotors)), np.nan)
        angles = speeds.copy()
        for i, rotor in enumerate(rotors):
            if rotor.turns_freely:
                p = rotor.axial_momentum(start.rotor_speed[i], start.omega_bi_b)
                turned = p / rotor.inertia * t_s - self.axial_turn(t_s, rotor.axis)
                speeds[:, i] = rotor.speed(p, omega_bi_b)
                angles[:, i] = start.rotor_angle[i] + turned
        return q_ib, omega_bi_b, speeds, angles, {}, self._work(t_s)

    def _add_turns(self, t_s, turn_b):
        """Add to row i the integral of omega from row i - 1 on, by parts in which it is smooth."""
        interval_s = np.diff(t_s)
        counts = np.maximum(np.ceil(interval_s * self._sharpness / _SMOOTH), 1.0).astype(int)
        ends = np.cumsum(counts)
        for first in range(0, ends[-1] if len(ends) else 0, _PARTS):
            part = np.arange(first, min(first + _PARTS, ends[-1]))
            row = np.searchsorted(ends, part, 'right')
            half = interval_s[row] / counts[row] / 2.0
            middle = t_s[row] + half * (2 * (part - ends[row] + counts[row]) + 1)
            _, omega_bi_b = self.attitude((middle[:, None] + half[:, None] * _NODES).ravel())
            omega_bi_b = omega_bi_b.reshape(len(part), len(_NODES), 3)
            # One addition after the other, so that blocks do not show in the bits.
            mean = sum(w * omega_bi_b[:, n] for n, w in enumerate(_WEIGHTS)) / 2.0
            np.add.at(turn_b, row + 1, 2.0 * half[:, None] * mean)

    @cached_property
    def _sharpness(self):
        """
        Return how fast omega may change [1/s]: in the inverse of it, by its own size.

        The energy bounds the rate, from which Euler's equations give that of its change.
        """
        system, state, orbit = self.system, self.state, self.system.orbit
        least, _, largest = np.linalg.eigvalsh(system.carrier_inertia)
        rate = np.linalg.norm(state.omega_bi_b) * np.sqrt(largest / least)
        if orbit.is_keplerian:
            gradient = 3.0 * orbit.fastest_rate**2
        else:
            gradient = float(abs(orbit.gradient_at(self.start_s)))
        torque = np.linalg.norm(system.weight_moment) + np.linalg.norm(system.torque_b)
        swing = np.sqrt((gradient * largest + torque) / least)
        return rate + 3.0 * swing + np.linalg.norm(system.rotor_momentum(state)) / least

    def _work(self, t_s):
        """
        Return the work (N,) by which the energy changes [J].

        Every closed form keeps its energy where the gradient is constant, also under a torque.
        Those of an ellipse keep omega . K omega and c . I c.
        """
        orbit, start_s = self.system.orbit, self.start_s
        if not orbit.is_eccentric:
            return np.zeros(len(t_s))
        c_b = direction(self.system, self.state, start_s)
        rise = orbit.gradient_at(start_s + t_s) - orbit.gradient_at(start_s)
        return rise / 2.0 * (c_b @ self.system.inertia @ c_b)
