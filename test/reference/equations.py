"""
The equations of motion of the reference cases, from the papers and from nothing else in here.

Quaternions are (x, y, z, w) and turn body components into inertial ones. Vectors are in body axes,
but for those whose name ends in _i; their elements are numbers or series of time. Units are those
of the case.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any

import gmpy2
from gmpy2 import mpfr
from taylor import Series, Unknowns

Scalar = Any  # a Series or an mpfr
Vector = list[Scalar]


def cross(a: Vector, b: Vector) -> Vector:
    """Return a x b."""
    return [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]


def dot(a: Iterable[Scalar], b: Iterable[Scalar]) -> Scalar:
    """Return a . b, also of more than three components."""
    return sum((x * y for x, y in zip(a, b, strict=True)), mpfr(0))


def times(matrix: list[Vector], v: Vector) -> Vector:
    """Return a matrix, given by rows, times a vector."""
    return [dot(row, v) for row in matrix]


def add(*vectors: Vector) -> Vector:
    """Return the sum of vectors."""
    return [sum(elements, mpfr(0)) for elements in zip(*vectors, strict=True)]


def scaled(factor: Scalar, v: Vector) -> Vector:
    """Return factor v."""
    return [factor * x for x in v]


def inverse(m: list[Vector]) -> list[Vector]:
    """Return the inverse of a 3 x 3 matrix of numbers, by its cofactors."""
    cofactors = [cross(m[i - 2], m[i - 1]) for i in range(3)]
    return [[cofactors[j][i] / dot(m[0], cofactors[0]) for j in range(3)] for i in range(3)]


def numbers(values: Iterable[Any]) -> list[mpfr]:
    """Return decimal strings, or the very values of doubles, as numbers of full precision."""
    return [mpfr(value) for value in values]


def unit(values: Iterable[Any]) -> list[mpfr]:
    """Return the values divided by their length."""
    v = numbers(values)
    return scaled(1 / gmpy2.sqrt(dot(v, v)), v)


def rows(q: list[Scalar]) -> list[Vector]:
    """Return the rows of R, v_i = R v, of a unit quaternion."""
    x, y, z, w = q
    xx, yy, zz, ww = x * x, y * y, z * z, w * w
    xy, xz, yz, wx, wy, wz = x * y, x * z, y * z, w * x, w * y, w * z
    return [
        [ww + xx - yy - zz, 2 * (xy - wz), 2 * (xz + wy)],
        [2 * (xy + wz), ww - xx + yy - zz, 2 * (yz - wx)],
        [2 * (xz - wy), 2 * (yz + wx), ww - xx - yy + zz],
    ]


def quaternion_rate(q: list[Series], omega: Vector) -> list[Series]:
    """Return q' = q (omega, 0) / 2."""
    *v, w = q
    doubled = [*add(scaled(w, omega), cross(v, omega)), dot(v, omega) * -1]
    return scaled(mpfr('0.5'), doubled)


class Centre:
    """
    The attracting centre: what moves, how, and its pull.

    start: the values of its unknowns; rates(x): their rates; pull(x): a vector d_i and a strength
    s, so that the torque on a body is s d x I d.
    """

    start: list[mpfr]
    rates: Callable[[list[Series]], list[Scalar]]
    pull: Callable[[list[Series]], tuple[Vector, Scalar]]

    def __init__(self, orbit: dict[str, Any]) -> None:
        """orbit: its type and elements as in rotors.json; fixed: the direction is e_z."""
        if orbit['type'] == 'fixed':
            self._fix(mpfr(orbit['gradient']))
            return
        mu, a, f = numbers(orbit[key] for key in ('mu', 'semi_major_axis', 'true_anomaly'))
        if orbit['type'] == 'circular':
            self._turn(gmpy2.sqrt(mu / a) / a, f)
        else:
            self._fall(mu, a, mpfr(orbit['eccentricity']), f)

    def _fix(self, gradient: mpfr) -> None:
        self.start, self.rates = [], lambda x: []
        self.pull = lambda x: (numbers((0, 0, 1)), gradient)

    def _turn(self, n: mpfr, f: mpfr) -> None:
        """Move by d_i = (cos(n t + f), sin(n t + f), 0); s = 3 n^2."""
        self.start = [gmpy2.cos(f), gmpy2.sin(f)]
        self.rates = lambda c: [c[1] * -n, c[0] * n]
        self.pull = lambda c: ([*c, mpfr(0)], 3 * n * n)

    def _fall(self, mu: mpfr, a: mpfr, e: mpfr, f: mpfr) -> None:
        """Move by r'' = -mu r / r^3 from the anomaly f; d_i = r, s = 3 mu / r^5."""
        parameter = a * (1 - e * e)
        r, v = parameter / (1 + e * gmpy2.cos(f)), gmpy2.sqrt(mu / parameter)
        self.start = [r * gmpy2.cos(f), r * gmpy2.sin(f)]
        self.start += [v * -gmpy2.sin(f), v * (e + gmpy2.cos(f))]

        def power(x: list[Series], exponent: str) -> Series:
            return (x[0] * x[0] + x[1] * x[1]) ** mpfr(exponent)

        self.rates = lambda x: [x[2], x[3], *scaled(power(x, '-1.5') * -mu, x[:2])]
        self.pull = lambda x: ([x[0], x[1], mpfr(0)], power(x, '-2.5') * (3 * mu))


class Problem:
    """A case as equations: its unknowns, their rates, and what is listed of their values."""

    def __init__(
        self,
        unknowns: Unknowns,
        rates: list[Scalar],
        listed: Callable[[list[mpfr]], dict[str, list[mpfr]]],
        leading: list[slice],
    ) -> None:
        """Keep listed: what the case lists, of the unknowns; leading: those of the step."""
        self.unknowns, self.rates, self.listed, self.leading = unknowns, rates, listed, leading

    def states(self, times: list[mpfr]) -> Iterator[dict[str, list[mpfr]]]:
        """Yield the quantities at each of the rising times."""
        return map(self.listed, self.unknowns.integrate(self.rates, times, self.leading))


def gyrostat(case: dict[str, Any]) -> Problem:
    """
    Return the equations of a gyrostat with any rotors in any field.

    K omega' = (K omega + sum p a + sum h) x omega + torque - sum p' a,
    torque = s d x I d - m x c + U'(c_3) (-c_2, c_1, 0) + torque_b,
    p' = rotor torque - friction speed, speed = p / J - a . omega,

    where h are the momenta of rotors that keep theirs, K is I less the inertia of those that turn,
    c = R^T e_z and U = H1 c_3^2 + H2 c_3. Unknowns: q, omega, angles, p, those of the centre.
    """
    inertia = [numbers(row) for row in case['inertia']]
    q_0, omega_0 = unit(case['q_xyzw']), numbers(case['omega'])
    turning = [rotor for rotor in case['rotors'] if rotor['mode'] != 'constant_momentum']
    axes, J = [numbers(rotor['axis']) for rotor in turning], [mpfr(r['inertia']) for r in turning]
    p_0 = [
        J_i * (mpfr(rotor['speed']) + dot(axis, omega_0))
        for rotor, axis, J_i in zip(turning, axes, J, strict=True)
    ]
    centre, many = Centre(case['orbit']), len(turning)
    unknowns = Unknowns([*q_0, *omega_0, *[mpfr(0)] * many, *p_0, *centre.start])
    q, omega, p = unknowns.x[:4], unknowns.x[4:7], unknowns.x[7 + many : 7 + 2 * many]
    moving = unknowns.x[7 + 2 * many :]

    speeds = [p_i * (1 / J_i) - dot(a, omega) for p_i, J_i, a in zip(p, J, axes, strict=True)]
    p_rates = [
        speed * -mpfr(rotor.get('friction', 0)) + mpfr(rotor.get('torque', 0))
        for rotor, speed in zip(turning, speeds, strict=True)
    ]
    kinetic = [
        add(row, *(scaled(-J_i * a[i], a) for J_i, a in zip(J, axes, strict=True)))
        for i, row in enumerate(inertia)
    ]
    held = [
        scaled(mpfr(rotor['momentum']), numbers(rotor['axis']))
        for rotor in case['rotors']
        if rotor['mode'] == 'constant_momentum'
    ]
    momentum = add(times(kinetic, omega), *held, *map(scaled, p, axes))

    R = rows(q)
    c = R[2]
    d_i, s = centre.pull(moving)
    d = [dot(column, d_i) for column in zip(*R, strict=True)]
    H1, H2 = numbers(case.get('potential', (0, 0)))
    slope = c[2] * (2 * H1) + H2
    torques = [
        scaled(s, cross(d, times(inertia, d))),
        cross(c, numbers(case.get('weight_moment', (0, 0, 0)))),
        [c[1] * slope * -1, c[0] * slope, mpfr(0)] if H1 or H2 else [mpfr(0)] * 3,
        numbers(case.get('torque_b', (0, 0, 0))),
        *(scaled(rate * -1, a) for rate, a in zip(p_rates, axes, strict=True)),
    ]
    omega_rate = times(inverse(kinetic), add(cross(momentum, omega), *torques))
    rates = [*quaternion_rate(q, omega), *omega_rate, *speeds, *p_rates, *centre.rates(moving)]

    def listed(values: list[mpfr]) -> dict[str, list[mpfr]]:
        q, omega, angles = values[:4], values[4:7], values[7 : 7 + many]
        p, d_i = values[7 + many : 7 + 2 * many], centre.pull(values[7 + 2 * many :])[0]
        return {
            'q_xyzw': q,
            'omega': omega,
            'c_body': unit(dot(column, d_i) for column in zip(*rows(q), strict=True)),
            'speeds': [p_i / J_i - dot(a, omega) for p_i, J_i, a in zip(p, J, axes, strict=True)],
            'angles': angles,
        }

    index = 7 + 2 * many
    return Problem(unknowns, rates, listed, [slice(0, 4), slice(index, index + 2)])


def immersed(case: dict[str, Any]) -> Problem:
    """
    Return Kirchhoff's equations of a body in a fluid, its impulse along e_z at the start.

    P' = P x omega, G' = G x omega + P x v + U'(c_3) (-c_2, c_1, 0), x' = R v, where P = dT/dv and
    G = dT/domega. Unknowns: q, P, G, x.
    """
    a11, a33, a44, a66, a14, a36 = numbers(
        case['body'][key] for key in ('a11', 'a33', 'a44', 'a66', 'a14', 'a36')
    )
    H1, H2 = numbers(case['potential'])
    q_0, omega_0 = unit(case['q_xyzw']), numbers(case['omega'])
    P_0 = scaled(mpfr(case['P0']), rows(q_0)[2])
    v_0 = [(P_0[i] - a14 * omega_0[i]) / a11 for i in range(2)]
    v_0.append((P_0[2] - a36 * omega_0[2]) / a33)
    G_0 = [a44 * omega_0[i] + a14 * v_0[i] for i in range(2)]
    G_0.append(a66 * omega_0[2] + a36 * v_0[2])
    D, D_3 = a11 * a44 - a14 * a14, a33 * a66 - a36 * a36

    def velocities(P: Vector, G: Vector) -> tuple[Vector, Vector]:
        """Return v and omega."""
        v = [P[i] * (a44 / D) - G[i] * (a14 / D) for i in range(2)]
        omega = [G[i] * (a11 / D) - P[i] * (a14 / D) for i in range(2)]
        v.append(P[2] * (a66 / D_3) - G[2] * (a36 / D_3))
        omega.append(G[2] * (a33 / D_3) - P[2] * (a36 / D_3))
        return v, omega

    unknowns = Unknowns([*q_0, *P_0, *G_0, *[mpfr(0)] * 3])
    q, P, G = unknowns.x[:4], unknowns.x[4:7], unknowns.x[7:10]
    (v, omega), R = velocities(P, G), rows(q)
    slope = R[2][2] * (2 * H1) + H2
    torque = [R[2][1] * slope * -1, R[2][0] * slope, mpfr(0)]
    G_rate = add(cross(G, omega), cross(P, v), torque)
    rates = [*quaternion_rate(q, omega), *cross(P, omega), *G_rate, *times(R, v)]

    def listed(values: list[mpfr]) -> dict[str, list[mpfr]]:
        q, P, G, x = values[:4], values[4:7], values[7:10], values[10:]
        v, omega = velocities(P, G)
        keys = ('q_xyzw', 'omega', 'v_body', 'P_body', 'G_body', 'position')
        return dict(zip(keys, (q, omega, v, P, G, x), strict=True))

    return Problem(unknowns, rates, listed, [slice(0, 4), slice(4, 7)])
