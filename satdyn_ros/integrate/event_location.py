"""Where in a step a rotor leaves the line of its drive's law, or the jump, that it is on."""

from typing import Any

from ..dynamics.constants import EVENT_SIZE, INVERSE_AT, ROTOR_SIZE
from ..dynamics.variables import RATE
from .dense_output import polynomial, slope, terms

# Where in a step values are looked at, and how often the interval is halved.
_SAMPLES, _HALVINGS = 8, 60
# The numbers of an EventFunction.
_RATE = RATE.start
_HELD_INERTIA, _LOW, _HIGH, _EFFORT, _GAIN = range(EVENT_SIZE)


def first_exit(
    rotors: Any, events: Any, count: int, momenta: int, dense: Any, row: int, h: float
) -> tuple[float, float]:
    """
    Return the part of a step h after which a value leaves its range, and whose; 2: none.

    rotors and events: the numbers of the constants of so many rotors; momenta: where theirs begin
    among the variables; dense: the terms of the step, rows of so many; whose: as of Drives.leave.
    """
    part, which = 2.0, 0.0
    for i in range(count):
        low, high = events[i * EVENT_SIZE + _LOW], events[i * EVENT_SIZE + _HIGH]
        inside = 0.0
        for n in range(_SAMPLES + 1):
            outside = n / _SAMPLES
            value = _value(i, outside, rotors, events, momenta, dense, row, h)
            if not (value < low or value > high):
                inside = outside
                continue
            is_above = value > high
            for _ in range(_HALVINGS if n > 0 else 0):
                middle = 0.5 * (inside + outside)
                value = _value(i, middle, rotors, events, momenta, dense, row, h)
                if (value > high) if is_above else (value < low):
                    outside = middle
                else:
                    inside = middle
            if outside < part:
                part, which = outside, (i + 1.0 if is_above else -i - 1.0)
            break
    return part, which


def effort(
    i: int, x: float, rotors: Any, events: Any, momenta: int, dense: Any, row: int, h: float
) -> float:
    """Return the torque [N m] of the drive of rotor i at a share x of the step."""
    event = i * EVENT_SIZE
    per_value = 1.0 if events[event + _HELD_INERTIA] > 0.0 else -events[event + _GAIN]
    value = _value(i, x, rotors, events, momenta, dense, row, h)
    return events[event + _EFFORT] + per_value * value


def _value(i, x, rotors, events, momenta, dense, row, h):
    """Return what is watched: a speed [rad/s] or, of a rotor that is held, p' [N m]."""
    p = terms(dense, row, momenta + i)
    if events[i * EVENT_SIZE + _HELD_INERTIA] > 0.0:
        return slope(p, x) / h if h > 0.0 else 0.0
    at, turn = i * ROTOR_SIZE, 0.0
    for j in range(3):
        turn += rotors[at + j] * polynomial(terms(dense, row, _RATE + j), x)
    return rotors[at + INVERSE_AT] * polynomial(p, x) - turn
