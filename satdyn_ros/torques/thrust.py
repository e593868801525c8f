"""The torque of thrusters, whose valves open and close between ticks."""

from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import pairwise
from math import ulp
from typing import Any, NamedTuple

import numpy as np

from ..kernel.functions import divide, exp
from ..kernel.time_table import NO_TABLE, Table, look_up
from ..kernel.vector import Vector, add, cross, scale
from ..orbits.pieces import Piece, Pieces, Stretch
from .body_torque import BodyTorque

# Standard gravity [m/s^2], by which a specific impulse is stated in seconds.
STANDARD_GRAVITY = 9.80665
# Instants that are no further apart than this [s], or than a few roundings, are one.
_INSTANT_S = 1e-12
# Before every tick, and after every tick that has a stamp.
_BEGIN_S, _END_S = -1.0, 1e18
# The shortest time constant [s] of a chamber: faster ones are not distinguished from none.
LEAST_TIME_CONSTANT_S = 1e-6
# What the table of the valves has of each thruster.
_LEVEL, _EXCESS, _SINCE, _WIDTH = range(4)


class Firing(NamedTuple):
    """
    What a thruster does from an instant on.

    Attributes
    ----------
    since_s : s
        the instant, from tick 0
    force : N
        just after it
    impulse : N s
        up to it, since tick 0
    is_open : bool
        whether the valve is open from then on
    switches_s : s
        when it closes, or opens, and so on in turn, ascending
    """

    since_s: float = 0.0
    force: float = 0.0
    impulse: float = 0.0
    is_open: bool = False
    switches_s: tuple[float, ...] = ()


class Thruster(NamedTuple):
    """
    A thruster.

    Attributes
    ----------
    position : (3,), m, body axes
        from the mass centre
    direction : (3,), body axes
        of the force on the body, a unit vector
    thrust : N
        F
    min_on_time : s
        the shortest on-time
    delay : s
        from a command to the valve
    time_constant : s
        tau, of the chamber
    specific_impulse : s
        0: unknown
    """

    position: tuple[float, ...]
    direction: tuple[float, ...]
    thrust: float
    min_on_time: float = 0.0
    delay: float = 0.0
    time_constant: float = 0.0
    specific_impulse: float = 0.0

    @property
    def torque_b(self) -> np.ndarray:
        """The torque of the whole thrust [N m] (3,), body axes."""
        return self.thrust * np.cross(self.position, self.direction)

    @property
    def propellant_per_impulse(self) -> float:
        """The propellant that an impulse takes [kg/(N s)]; nan: unknown."""
        if not self.specific_impulse:
            return np.nan
        return 1.0 / (STANDARD_GRAVITY * self.specific_impulse)

    def commanded(self, firing: Firing, at_s: float, on_time: float) -> Firing:
        """
        Return a firing under a command of an instant: on for a time [s], in place of the rest.

        What the valve has still to do for earlier commands, before this one comes to it, stays.
        """
        acts_s = at_s + self.delay
        earlier = tuple(t_s for t_s in firing.switches_s if _is_before(t_s, acts_s))
        was_on = firing.is_open != bool(len(earlier) % 2)
        switches_s = earlier
        if on_time > 0.0:
            opens_s = () if was_on else (acts_s,)
            switches_s = (*earlier, *opens_s, acts_s + on_time)
        elif was_on:
            switches_s = (*earlier, acts_s)
        if switches_s == firing.switches_s:
            return firing
        *_, last = self.parts(firing._replace(switches_s=switches_s), at_s)
        return last

    def taking_over(self, firing: Firing, other: 'Thruster', at_s: float) -> Firing:
        """Return what this one does from an instant [s] on with the valve of another one."""
        if self == other:
            return firing
        *_, last = other.parts(firing, at_s)
        force, impulse = map(float, other._at(last, at_s))
        if not self.time_constant:
            force = self.thrust * last.is_open
        return Firing(at_s, force, impulse, last.is_open, last.switches_s)

    def ended(self, firing: Firing, at_s: float) -> Firing:
        """Return what is left of a firing where the valve closes and the chamber is empty."""
        *_, last = self.parts(firing, at_s)
        force, impulse = (float(x[0]) for x in self.thrust_and_impulse(firing, np.array([at_s])))
        if not (last.is_open or last.switches_s or force):
            return firing
        return Firing(at_s, 0.0, impulse)

    def parts(self, firing: Firing, until_s: float = _END_S) -> Iterator[Firing]:
        """Yield a firing as of its beginning, and as of each of its switches up to an instant."""
        yield firing
        for t_s in firing.switches_s:
            if _is_before(until_s, t_s):
                return
            force, impulse = self._at(firing, t_s)
            is_open = not firing.is_open
            if not self.time_constant:
                force = self.thrust * is_open
            firing = Firing(t_s, force, impulse, is_open, firing.switches_s[1:])
            yield firing

    def _at(self, part: Firing, t_s: Any) -> tuple[Any, Any]:
        """Return force [N] and impulse [N s] at times (N,), or one, before the next switch."""
        level, tau = self.thrust * part.is_open, self.time_constant
        excess, since_s = part.force - level, t_s - part.since_s
        left = exp(divide(-since_s, tau)) if tau else 0.0
        force = level + excess * left
        return force, part.impulse + level * since_s + tau * (excess - excess * left)

    def thrust_and_impulse(self, firing: Firing, t_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return force [N] and impulse [N s] of a firing at times (N,) from its beginning on."""
        parts = [*self.parts(firing)]
        which = np.searchsorted(firing.switches_s, t_s, side='right')
        force, impulse = np.empty((2, len(t_s)))
        for n, part in enumerate(parts):
            rows = which == n
            if rows.any():
                force[rows], impulse[rows] = self._at(part, t_s[rows])
        return force, impulse


class Thrust(BodyTorque):
    """
    The torque p x f n of each thruster, summed.

    The thrust f follows the valve with the time constant tau of the chamber, f' = (F u - f) / tau,
    u = 1 while it is open: between its switches it is F u + (f_s - F u) exp(-(t - t_s) / tau), and
    with tau = 0 it is F u.  Neither the position on the orbit nor the body's mass changes by it.

    Parameters
    ----------
    thrusters : dict of Thruster
        by name
    firings : sequence of Firing
        of each thruster
    """

    name = 'thruster'
    topic = 'thruster_wrench'
    title = 'thruster torque'
    is_steady = True

    class Constants(NamedTuple):
        """
        The constants of the torque.

        Attributes
        ----------
        arms : (3,), m, of each thruster
            p x n
        directions : (3,), of each thruster
            n
        decay_rates : 1/s, of each thruster
            1 / tau, 0 where tau is
        valves : Table
            between two switches, of each thruster F u [N], f_s - F u [N] and t_s [s]
        """

        arms: tuple[Any, ...]
        directions: tuple[Any, ...]
        decay_rates: tuple[float, ...]
        valves: Table

    def __init__(self, thrusters: Mapping[str, Thruster], firings: Sequence[Firing]):
        self.thrusters, self.firings = dict(thrusters), tuple(firings)
        constants, self.largest = _of_geometry(tuple(self.thrusters.values()))
        self._parts = [
            [*one.parts(firing)]
            for one, firing in zip(self.thrusters.values(), self.firings, strict=True)
        ]
        super().__init__(constants, {'valves': Pieces(self._valves, self._stretches())})

    def firing(self, firings: Sequence[Firing]) -> 'Thrust':
        """Return the torque of the same thrusters under other firings."""
        return type(self)(self.thrusters, firings)

    def _stretches(self) -> list[Stretch]:
        """Return the times between two switches, each one piece."""
        switches_s = sorted({t_s for firing in self.firings for t_s in firing.switches_s})
        # Of those that are one instant the last: there all of them have acted.
        lasting_s = [a for a, b in pairwise([*switches_s, _END_S]) if _is_before(a, b)]
        edges_s = pairwise([_BEGIN_S, *lasting_s, _END_S])
        return [Stretch(begin_s, end_s - begin_s, begin_s, end_s) for begin_s, end_s in edges_s]

    def _valves(self, piece: Piece) -> np.ndarray:
        rows = []
        for thruster, parts in zip(self.thrusters.values(), self._parts, strict=True):
            part = parts[bisect_right(parts[0].switches_s, piece.begin_s)]
            level = thruster.thrust * part.is_open
            rows += [level, part.force - level, part.since_s]
        return np.array(rows).reshape(-1, 1)

    @staticmethod
    def torque(
        t_s: float,
        r_i: tuple[float, ...],
        v_i: tuple[float, ...],
        q_ib: tuple[float, ...],
        omega_bi_b: tuple[float, ...],
        constants: Any,
    ) -> Vector:
        """Return the sum of p x f n."""
        return _sum(t_s, constants, constants.arms)

    @staticmethod
    def force(
        t_s: float,
        r_i: tuple[float, ...],
        v_i: tuple[float, ...],
        q_ib: tuple[float, ...],
        omega_bi_b: tuple[float, ...],
        constants: Any,
    ) -> Vector:
        """Return the sum of f n."""
        return _sum(t_s, constants, constants.directions)

    def thrusts(self, t_s: np.ndarray) -> np.ndarray:
        """Return the thrust of each thruster [N] at times (N,) from tick 0, (N, K)."""
        return self._of_each(t_s)[0]

    def mean_thrusts(self, t_s: np.ndarray, over_s: float) -> np.ndarray:
        """Return the mean thrust of each [N] over so long [s] from times (N,) on, (N, K)."""
        return (self._of_each(t_s + over_s)[1] - self._of_each(t_s)[1]) / over_s

    def propellant_used(self, t_s: np.ndarray) -> np.ndarray:
        """Return what each has used [kg] since tick 0, nan where it is unknown, (N, K)."""
        per_impulse = [one.propellant_per_impulse for one in self.thrusters.values()]
        return self._of_each(t_s)[1] * per_impulse

    def open_between(self, begin_s: float, end_s: float) -> dict[str, list[tuple[float, float]]]:
        """Return, by name, from when to when each valve is open between two instants [s]."""
        found: dict[str, list[tuple[float, float]]] = {}
        for name, firing in zip(self.thrusters, self.firings, strict=True):
            edges_s = [begin_s, *firing.switches_s, end_s]
            is_open = firing.is_open
            found[name] = []
            for a, b in pairwise(edges_s):
                a, b = max(a, begin_s), min(b, end_s)
                if is_open and a < b:
                    found[name].append((a, b))
                is_open = not is_open
        return found

    def _of_each(self, t_s):
        pairs = zip(self.thrusters.values(), self.firings, strict=True)
        found = [one.thrust_and_impulse(firing, t_s) for one, firing in pairs]
        return np.moveaxis(np.array(found), 0, -1)


@lru_cache
def _of_geometry(thrusters: tuple[Thruster, ...]) -> tuple[Any, float]:
    """Return what of the constants does not change, and the most torque [N m] there may be."""
    constants = Thrust.Constants(
        tuple(cross(each.position, each.direction) for each in thrusters),
        tuple(each.direction for each in thrusters),
        tuple(1.0 / each.time_constant if each.time_constant else 0.0 for each in thrusters),
        NO_TABLE,
    )
    return constants, sum(float(np.linalg.norm(each.torque_b)) for each in thrusters)


def thrust_of(system: Any) -> Thrust:
    """Return the torque of the thrusters of a system that has some."""
    thrust = Thrust.among(system.torques)
    assert thrust is not None
    return thrust


def _sum(t_s: Any, constants: Any, vectors: tuple[Any, ...]) -> Vector:
    """Return the sum of vectors, each times the thrust [N] of its thruster."""
    total: Vector = (0.0, 0.0, 0.0)
    for k, (vector, rate) in enumerate(zip(vectors, constants.decay_rates, strict=True)):
        level, excess, since_s = (
            look_up(constants.valves.coefficients, 0.0, _WIDTH * k + i)
            for i in (_LEVEL, _EXCESS, _SINCE)
        )
        thrust = level + excess * exp((since_s - t_s) * rate)
        total = add(total, scale(thrust, vector))
    return total


def _is_before(a_s: float, b_s: float) -> bool:
    """Return whether an instant is before another, and not the same to rounding."""
    return b_s - a_s > max(_INSTANT_S, 4.0 * ulp(b_s))
