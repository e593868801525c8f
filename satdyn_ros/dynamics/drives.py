"""
The motors' drives: where on its law of torque and speed each one is, and when it leaves there.

A law is made of straight lines, tau = torque - gain s.  That of a commanded speed has the slope of
the loop in the drive, and is level where max_torque cuts it.  At max_speed a torque that makes the
rotor faster ends: the law jumps to zero.  There a rotor is held at its speed as long as the torque
that holds it, p' and the friction, is between those on both sides of the jump.  It turns with the
body then: J a a^T counts with the inertia of the carrier, and p' = J a . omega'.

On a line steps end where the speed leaves it, at a jump where p' leaves its range.
"""

from typing import NamedTuple

import numpy as np

from .constants import Constants, EventFunction, constants_of
from .rotor import Rotor
from .system import State, System

# By so much of its size a speed, or a torque, goes beyond an end of its range before it has left.
_BEYOND, _TORQUE_BEYOND = 1e-13, 1e-12
# A speed is the difference of p / J and the body's rate: rounding is of the size of that rate.
_ROUNDING = 2e-15
# A rotor within this share of a jump is at it.
AT_LIMIT = 1e-12


class Line(NamedTuple):
    """A line of a law, from one speed [rad/s] to another: tau = torque - gain s."""

    low: float
    high: float
    torque: float
    gain: float = 0.0

    def at(self, speed: float) -> float:
        """Return the torque [N m] at a speed."""
        return self.torque - self.gain * speed


def law_of(rotor: Rotor, torque: float, target: float) -> tuple[Line, ...]:
    """
    Return the law of a rotor under a commanded torque, or speed, by ascending speed.

    The loop for the speed gives J k (target - s), at most max_torque.
    """
    lines = [Line(-np.inf, np.inf, torque)]
    if np.isfinite(target):
        gain, most = rotor.inertia * rotor.speed_gain, rotor.max_torque
        lines = [Line(-np.inf, np.inf, gain * target, gain)]
        # Of a loop so slow that it commands nothing, max_torque cuts nothing.
        if most and gain:
            begin, end = target - most / gain, target + most / gain
            lines = [
                Line(-np.inf, begin, most),
                lines[0]._replace(low=begin, high=end),
                Line(end, np.inf, -most),
            ]
    if rotor.max_speed:
        upward = [line for line in lines if line.low < rotor.max_speed]
        if upward[-1].at(rotor.max_speed) > 0.0:
            last = upward[-1]._replace(high=rotor.max_speed)
            lines = [*upward[:-1], last, Line(rotor.max_speed, np.inf, 0.0)]
        downward = [line for line in lines if line.high > -rotor.max_speed]
        if downward[0].at(-rotor.max_speed) < 0.0:
            first = downward[0]._replace(low=-rotor.max_speed)
            lines = [Line(-np.inf, -rotor.max_speed, 0.0), first, *downward[1:]]
    return tuple(lines)


class Drives:
    """
    The drives of a system's turning rotors, from a state on.

    Parameters
    ----------
    system : System
        what moves
    state : State
        at the start of the motion

    Attributes
    ----------
    met : list of s and int
        the instants at which rotors came to a jump, from the start of the motion, and the indices
        of these rotors among all
    """

    def __init__(self, system: System, state: State):
        self._system = system
        # Of when a rotor last left its range.
        self._omega_bi_b, self._speeds = state.omega_bi_b, system.rotor_speeds(state)
        self._laws = [
            law_of(rotor, float(system.rotor_torque[i]), float(system.rotor_target[i]))
            for i, rotor in system.turning_rotors
        ]
        # Twice the number of a line, or one more: at the jump to the next.
        self._indices = [
            _index(law, state.rotor_speed[i])
            for law, (i, _) in zip(self._laws, system.turning_rotors, strict=True)
        ]
        self.met: list[tuple[float, int]] = []

    @property
    def hold(self) -> bool:
        """Whether a rotor is held at a jump."""
        return any(index % 2 for index in self._indices)

    def torques_and_events(self) -> tuple[np.ndarray, list[EventFunction]]:
        """Return the level parts of the torques [N m] (R,), and what ends a step of each one."""
        system = self._system
        torque, events = system.rotor_torque.copy(), []
        rounding = _ROUNDING * float(np.linalg.norm(self._omega_bi_b))
        for n, (i, rotor) in enumerate(system.turning_rotors):
            line, is_held = self._laws[n][self._indices[n] // 2], self._indices[n] % 2
            torque[i] = 0.0 if is_held else line.torque
            if is_held:
                events.append(_at_jump(rotor, line, self._laws[n][self._indices[n] // 2 + 1]))
            else:
                events.append(_on_line(line, float(self._speeds[i]), rounding))
        return torque, events

    def constants(self, start_s: float) -> Constants:
        """Return the constants of the equations as long as all rotors are where they are."""
        system, (torque, events) = self._system, self.torques_and_events()
        constants = constants_of(system, start_s)
        if not np.array_equal(torque, system.rotor_torque):
            driven = constants_of(system.driven(rotor_torque=torque), start_s)
            constants = driven._replace(does_work=constants.does_work)
        rotors = tuple(
            turning._replace(friction=0.0 if event.held_inertia else turning.friction + event.gain)
            for turning, event in zip(constants.rotors, events, strict=True)
        )
        if self.hold:
            inertia = system.carrier_inertia
            for event, (_, rotor) in zip(events, system.turning_rotors, strict=True):
                if event.held_inertia:
                    inertia = inertia + rotor.inertia * np.outer(rotor.axis, rotor.axis)
            inverse = np.linalg.inv(inertia)
            is_diagonal = not isinstance(constants.carrier_inverse[0], tuple)
            rows = inverse.diagonal().tolist() if is_diagonal else map(tuple, inverse.tolist())
            constants = constants._replace(carrier_inverse=tuple(rows))
        coulomb = tuple(
            dry._replace(torque=0.0) if event.held_inertia else dry
            for event, dry in zip(events, constants.coulomb, strict=False)
        )
        return constants._replace(rotors=rotors, events=tuple(events), coulomb=coulomb)

    def leave(self, which: int, t_s: float, omega_bi_b: np.ndarray, speeds: np.ndarray) -> None:
        """
        Let a turning rotor leave where it is.

        Parameters
        ----------
        which : int
            n + 1 by the upper end of its range, -n - 1 by the lower one
        t_s : s
            when, from the start of the motion
        omega_bi_b : (3,), rad/s, body axes
            rate of the body then
        speeds : (R,), rad/s
            of the rotors then
        """
        self._omega_bi_b, self._speeds = omega_bi_b, speeds
        n, up = abs(which) - 1, which > 0
        index, law = self._indices[n], self._laws[n]
        if index % 2:
            # Where less is needed than the law gives beyond the jump the speed rises, and so on.
            self._indices[n] = index - 1 if up else index + 1
            return
        first = index // 2 if up else index // 2 - 1
        jumps = _jumps(law, first)
        self._indices[n] = 2 * first + 1 if jumps else 2 * first + (2 if up else 0)
        if jumps:
            self.met.append((t_s, self._system.turning_rotors[n][0]))

    def forget(self, before_s: float) -> None:
        """Forget the instants before one."""
        self.met = [(t_s, i) for t_s, i in self.met if t_s >= before_s]


def _jumps(law, k):
    """Return whether a law jumps after line k: at a limit of speed, beyond which it is zero."""
    return any(line.torque == 0.0 and line.gain == 0.0 for line in law[k : k + 2])


def _index(law, speed):
    for k, line in enumerate(law[:-1]):
        if _jumps(law, k) and abs(speed - line.high) <= AT_LIMIT * abs(line.high):
            return 2 * k + 1
        if speed < line.high:
            return 2 * k
    return 2 * (len(law) - 1)


def _on_line(line, speed, rounding):
    low, high = min(line.low, speed), max(line.high, speed)
    return EventFunction(
        held_inertia=0.0,
        low=low - max(_BEYOND * abs(low), rounding),
        high=high + max(_BEYOND * abs(high), rounding),
        effort=line.torque,
        gain=line.gain,
    )


def _at_jump(rotor, before, after):
    speed = before.high
    friction = float(rotor.friction_torque(speed))
    low, high = after.at(speed), before.at(speed)
    beyond = _TORQUE_BEYOND * (high - low)
    return EventFunction(
        held_inertia=rotor.inertia,
        low=low - friction - beyond,
        high=high - friction + beyond,
        effort=friction,
        gain=0.0,
    )
