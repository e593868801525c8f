"""
One step of Dormand and Prince's method of order 8, and its error by orders 5 and 3.

Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, 1993, II.5, II.10.

Plain functions of floats: code is made of them in step_code.py, and walk.py takes step after step.
Variables are tuples, k are the stages, h times the derivatives.
"""

from collections.abc import Callable
from typing import Any

from ..dynamics.constants import Constants
from ..dynamics.equations import modal_rates, rotor_speeds, seen_by_torques
from ..dynamics.variables import RATE, Variables
from ..kernel.functions import divide, maximum, minimum, select, sqrt
from ..kernel.vector import Vector, add, dot, scale
from ..torques.body_torque import scales_of
from ..torques.corner_search import first_corner
from ..torques.sums import signs_of
from .tableau import COLUMNS, ENTRIES, LENGTHS, NODES

# Above it a variable counts as infinite: the dense output multiplies it by up to some thousand.
LARGEST = 1e300
# Keeps a quotient of zeros finite and changes no other.
TINY = 1e-300
# A rate below it has a square of zero, and counts as it [rad/s].
LEAST_RATE = 1e-150
_INFINITE = float('inf')


def stage_time(i: int, t: Any, h: Any, span: tuple[Any, Any], constants: Constants) -> Any:
    """
    Return the time of stage i from tick 0 [s].

    span: the times from tick 0 between which the torques are smooth.
    """
    return minimum(maximum(constants.start_s + (t + float(NODES[i]) * h), span[0]), span[1])


def combination(row: int, k: Callable[[int], Any]) -> Any:
    """Return sum_j a_j k_j with a row's entries a_j, of one variable."""
    total = float(ENTRIES[row, 0]) * k(int(COLUMNS[row, 0]))
    for n in range(1, LENGTHS[row]):
        total = total + float(ENTRIES[row, n]) * k(int(COLUMNS[row, n]))
    return total


def error_of(
    y_0: Vector, y: Vector, k_0: Vector, e_3: Vector, e_5: Vector, h: Any, constants: Constants
) -> Any:
    """Return the error of a step h from y_0 to y, of the variables that the motion depends on."""
    # The natural scale of a rate: the rate itself and the root of the acceleration.  At rest both
    # may be rounding, which needs no digits.
    parts = Variables.of(constants)
    omega, k_omega = y_0[parts.rate], k_0[parts.rate]
    acceleration = divide(sqrt(dot(k_omega, k_omega)), h)
    rate = sqrt(dot(omega, omega)) + sqrt(acceleration) + constants.slow_rate + LEAST_RATE
    scales = {
        'attitude': [1.0] * 4,
        'rate': [divide(1.0, rate)] * 3,
        'momenta': _per_momentum(y_0, y, rate, constants),
        'anomaly': [1.0] * 2 if constants.integrates_anomaly else [],
    }
    if constants.modes:
        per_size = _per_displacement(y_0, y, rate, constants)
        scales['displacements'] = [per_eta for per_eta, _ in per_size]
        scales['modal_momenta'] = [per_pi for _, per_pi in per_size]
    scales['of_torques'] = [
        divide(1.0, size) for torque in constants.torques for size in scales_of(torque)
    ]
    square_3, square_5 = _square(e_3, scales, parts), _square(e_5, scales, parts)
    # The error does not look at the other variables: they must be finite.  So must the squares,
    # or a quotient by infinity would take the worst of steps for one without an error.
    rest = square_3 + square_5
    for each in y[RATE.stop :]:
        rest = rest + abs(each)
    # The root mean square of the estimate of order 5, damped by that of order 3 (II.10).
    count = float(sum(len(some) for name, some in scales.items() if name != 'momenta'))
    error = divide(square_5, sqrt(count * (square_5 + 0.01 * square_3) + TINY))
    return select(rest < LARGEST, error, _INFINITE)


def _per_momentum(y_0, y, rate, constants):
    """Return what a rotor's momentum is in proportion to, inverse, and zero without friction."""
    # Without friction a momentum has no error.  Friction acts by the relative speed, which may
    # be far below the rate of the body: nearly all of p / J may be due to that rate.
    # A tenth of that rate is the least speed that its error is relative to.
    both = zip(rotor_speeds(y_0, constants), rotor_speeds(y, constants), strict=True)
    found = []
    for rotor, (before, after) in zip(constants.rotors, both, strict=True):
        per_momentum = divide(rotor.inertia_inverse, abs(before) + abs(after) + 0.1 * rate)
        found.append(select(rotor.friction > 0.0, per_momentum, 0.0))
    return found


def _per_displacement(y_0, y, rate, constants):
    """Return what eta and pi of each mode are in proportion to, inverse."""
    # The amplitude of the swing, or what the rate of the body bends the part by if that is more.
    parts = Variables.of(constants)
    both = zip(modal_rates(y_0, constants), modal_rates(y, constants), strict=True)
    ends = zip(y_0[parts.displacements], y[parts.displacements], strict=True)
    found = []
    for mode, (swing_0, swing), (eta_0, eta) in zip(constants.modes, both, ends, strict=True):
        frequency = mode.frequency()
        bend = sqrt(dot(mode.coupling, mode.coupling)) * rate
        size = frequency * (abs(eta_0) + abs(eta)) + abs(swing_0) + abs(swing) + bend + TINY
        found.append((divide(frequency, size), divide(1.0, size)))
    return found


def _square(e, scales, parts):
    """Return the sum of the squares of errors, each by its scale."""
    total = 0.0
    for name, per_size in scales.items():
        for each, inverse in zip(e[getattr(parts, name)], per_size, strict=True):
            relative = each * inverse
            total = total + relative * relative
    return total


def part_before_corner(
    y_0: Vector,
    y: Vector,
    k_0: Vector,
    k_11: Vector,
    t: Any,
    h: Any,
    span: tuple[Any, Any],
    constants: Constants,
) -> Any:
    """
    Return the part of the step h after which a torque may have a corner; 1: it needs no cut.

    One as near to either end as the step does not feel it, or time cannot resolve it, needs none.
    Above 1: nor does the step, and a corner may come so soon after it.
    """
    search = constants.corner_search
    soon = search.share
    begin_s = stage_time(0, t, h, span, constants)
    end_s = stage_time(11, t, h, span, constants)
    seen_at = (
        (begin_s, y_0),
        (begin_s + soon * h, add(y_0, scale(soon, k_0))),
        (end_s - soon * h, add(y, scale(-soon, k_11))),
        (end_s, y),
    )
    signs = [signs_of(constants.torques, seen_by_torques(*each, constants)) for each in seen_at]
    part = first_corner(signs, search)
    cut = maximum(part, search.least)
    time = t + cut * h
    cut_off = select(t < time, select(time < t + h, cut, 1.0), 1.0)
    inside = select(minimum(part, 1.0 - part) < search.at_begin, 1.0, cut_off)
    return select(part > 1.0, part, inside)
