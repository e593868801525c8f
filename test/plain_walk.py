"""
The steps of a propagation in plain Python: the equations are called with floats.

It takes the equations, the error and the corners from the package, and walks by itself.  Run as a
program it prints the bits of drawn systems; numba and llvmlite cannot be imported then.
"""

import math
import sys

import numpy as np

from satdyn_ros.dynamics.equations import rates
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.dynamics.variables import RATE, Variables, initial_values
from satdyn_ros.integrate.course import Course
from satdyn_ros.integrate.dop853 import combination, error_of, part_before_corner, stage_time
from satdyn_ros.integrate.tableau import DENSE, ERROR_3, ERROR_5

AHEAD = 5e-4
ULP = 2.3e-16
TOLERANCE = 1e-13


class PlainWalk:
    """
    A motion that goes on step by step.

    y: the variables, a tuple of floats; t: when [s]; met: how often pieces ended, rotors left
    their range, steps ended at stops, and attempts were rejected for the sake of a corner.
    """

    def __init__(self, system: System, state: State, start_s: float):
        self._course = Course(system, state, start_s, TOLERANCE, math.inf)
        self._start_s = start_s
        self.y = tuple(map(float, initial_values(system, state)))
        self.t, self._next, self._foreseen, self._steps, self.begun = 0.0, 0.0, 0.0, 0, 0
        self._exit_s, self._exit = math.inf, 0
        self.met = {'pieces': 0, 'exits': 0, 'stops': 0, 'corners': 0}

    def step(self) -> None:
        """Take one step, or take it back where a rotor leaves its range in it."""
        self.begun += 1
        course, constants = self._course, self._course.constants
        self._correct_anomaly()
        stop_times_s = course.stop_times_s
        passed = sum(each - self._start_s <= self.t for each in stop_times_s)
        before = float(stop_times_s[passed - 1]) if passed else -math.inf
        following = float(stop_times_s[passed]) if passed < len(stop_times_s) else math.inf
        stop, until = float(following - self._start_s), following
        if math.isfinite(following):
            until = following - ULP * abs(following)
        t, y_0 = self.t, self.y
        if self._next == 0.0:
            square = 0.0
            for x in y_0[RATE]:
                square += x * x
            self._next = 0.01 / (math.sqrt(square) + constants.anomaly_rate + 1e-9)
        h = proposed = self._next
        most_growth, is_cut = 6.0, t < t + self._foreseen < t + h
        if is_cut:
            ahead = AHEAD * h
            h = self._foreseen - (ahead if self._foreseen > 2.0 * ahead else 0.0)
        while True:
            end = min(t + h, stop)
            h = end - t
            k, y, error, part = self._attempt(t, h, (before, until), constants)
            ratio = 0.9 / math.sqrt(math.sqrt(math.sqrt(max(error, 1e-12))))
            if error <= 1.0 and part >= 1.0:
                break
            if part < 1.0 and (error <= 1.0 or constants.corner_search.ahead > 0.0):
                h, is_cut = h * part, True
                self.met['corners'] += 1
            else:
                h *= max(ratio, 0.2) if error < math.inf else 0.2
                proposed, most_growth = h, 1.0
        grown = h * min(most_growth, ratio)
        self.met['stops'] += end == stop
        if end == stop or is_cut:
            grown = max(grown, proposed)
        self._next = min(grown, constants.longest_step)
        self._foreseen = h * (part - 1.0)
        self.t, self.y = float(stop if end == stop else t + h), y
        self._steps += 1
        if constants.events:
            self._end_at_exit(t, y_0, k, (before, until), constants)
        if self.t >= course.until_s:
            self.met['pieces'] += 1
            course.enter_next(np.array(self.y[:4]))

    def _correct_anomaly(self):
        constants = self._course.constants
        if not constants.integrates_anomaly or self._steps % 8:
            return
        anomaly, rate, e = self._course.anomaly
        f = true_anomaly(anomaly + rate * self.t, e)
        i = Variables.of(constants).anomaly.start
        self.y = (*self.y[:i], math.cos(f), math.sin(f), *self.y[i + 2 :])

    def _attempt(self, t, h, span, constants):
        k, y = [], self.y
        for i in range(12):
            f = rates(stage_time(i, t, h, span, constants), y, constants)
            k.append(tuple(h * x for x in f))
            y = self._combined(i + 1, k, self.y)
        e_3, e_5 = (self._combined(row, k) for row in (ERROR_3, ERROR_5))
        error = error_of(self.y, y, k[0], e_3, e_5, h, constants) / TOLERANCE
        return k, y, error, part_before_corner(self.y, y, k[0], k[11], t, h, span, constants)

    @staticmethod
    def _combined(row, k, y=None):
        columns = zip(*k, strict=True)
        sums = [combination(row, column.__getitem__) for column in columns]
        return tuple(sums) if y is None else tuple(a + b for a, b in zip(y, sums, strict=True))

    # -- rotors that leave their range ------------------------------------------------------------

    def _end_at_exit(self, t, y_0, k, span, constants):
        end, h = self.t, self.t - t
        if end >= self._exit_s * (1.0 - 4.0 * ULP):
            self._leave(self._exit)
            return
        self._exit_s = math.inf
        dense = self._dense(t, h, y_0, k, span, constants)
        part, which = 2.0, 0
        for i in range(len(constants.rotors)):
            share, side = self._exit_of(i, dense, h, constants)
            if share < part:
                part, which = share, side
        if part > 1.0:
            return
        self.t, self.y, self._next, self._foreseen = t, y_0, h, 0.0
        self._steps -= 1
        end = t + part * h
        if t < end:
            self._exit_s, self._exit, self._next = end, which, end - t
        else:
            self._leave(which)

    def _leave(self, which):
        self._exit_s = math.inf
        self.met['exits'] += 1
        speeds = np.full(len(self._course._system.rotors), np.nan)
        omega = np.array(self.y[RATE])
        for n, (i, rotor) in enumerate(self._course._system.turning_rotors):
            p = np.array([self.y[Variables.of(self._course.constants).momenta.start + n]])
            speeds[i] = np.asarray(rotor.speed(p, omega[None]))[0]
        self._course.leave(which, self.t, omega, speeds)

    def _dense(self, t, h, y_0, k, span, constants):
        """Return the terms of the dense output, a row of each."""
        k = [*k]
        f = rates(stage_time(12, t, h, span, constants), self.y, constants)
        k.append(tuple(h * x for x in f))
        for i in range(13, 16):
            y = self._combined(i, k, y_0)
            f = rates(stage_time(i, t, h, span, constants), y, constants)
            k.append(tuple(h * x for x in f))
        rise = tuple(b - a for a, b in zip(y_0, self.y, strict=True))
        first = tuple(a - b for a, b in zip(k[0], rise, strict=True))
        third = tuple(2.0 * r - (a + b) for r, a, b in zip(rise, k[0], k[12], strict=True))
        return [y_0, rise, first, third, *(self._combined(DENSE + n, k) for n in range(4))]

    def _exit_of(self, i, dense, h, constants):
        event, inside = constants.events[i], 0.0
        for n in range(9):
            outside = n / 8
            value = self._value(i, outside, dense, h, constants)
            if not (value < event.low or value > event.high):
                inside = outside
                continue
            is_above = value > event.high
            for _ in range(60 if n else 0):
                middle = 0.5 * (inside + outside)
                value = self._value(i, middle, dense, h, constants)
                if value > event.high if is_above else value < event.low:
                    outside = middle
                else:
                    inside = middle
            return outside, i + 1 if is_above else -i - 1
        return 2.0, 0

    def _value(self, i, x, dense, h, constants):
        event, rotor = constants.events[i], constants.rotors[i]
        p = [row[Variables.of(constants).momenta.start + i] for row in dense]
        if event.held_inertia > 0.0:
            return _slope(p, x) / h
        turn = 0.0
        for j in range(3):
            turn += rotor.axis[j] * _polynomial([row[RATE.start + j] for row in dense], x)
        return rotor.inertia_inverse * _polynomial(p, x) - turn


def _polynomial(d, x):
    y = 1.0 - x
    value = d[6] + x * d[7]
    for n, factor in ((5, y), (4, x), (3, y), (2, x), (1, y), (0, x)):
        value = d[n] + factor * value
    return value


def _slope(d, x):
    y = 1.0 - x
    value, rate = d[6] + x * d[7], d[7]
    for n, factor, sign in ((5, y, -1.0), (4, x, 1.0), (3, y, -1.0), (2, x, 1.0), (1, y, -1.0)):
        value, rate = d[n] + factor * value, factor * rate + sign * value
    return x * rate + value


def true_anomaly(mean_anomaly, e):
    """Return f of M by Newton's method from Danby's guess."""
    turns = 2.0 * math.pi * round(mean_anomaly / (2.0 * math.pi))
    M = mean_anomaly - turns
    E = M + math.copysign(1.0, M) * 0.85 * e if M else M
    for _ in range(50):
        correction = (E - e * math.sin(E) - M) / (1.0 - e * math.cos(E))
        E -= correction
        if abs(correction) < 1e-15:
            break
    beta = e / (1.0 + math.sqrt(1.0 - e * e))
    return turns + E + 2.0 * math.atan2(beta * math.sin(E), 1.0 - beta * math.cos(E))


def bits_after(walk: PlainWalk, steps: int) -> str:
    """Return the time and the variables of a walk when so many steps are begun, bit by bit."""
    while walk.begun < steps:
        walk.step()
    return np.array([walk.t, *walk.y]).tobytes().hex()


if __name__ == '__main__':
    from drawn_systems import drawn

    found = {'pieces': 0, 'exits': 0, 'stops': 0, 'corners': 0}
    for seed in map(int, sys.argv[2:]):
        walk = PlainWalk(*drawn(seed))
        print(seed, bits_after(walk, int(sys.argv[1])), flush=True)
        for name, count in walk.met.items():
            found[name] += count
    print(*found.values())
