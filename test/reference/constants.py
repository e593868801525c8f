"""
The constants of the reference cases: first integrals, roots, periods and mean rates, by mpmath.

Periods and mean rates are integrals over the way between the turning points, or complete elliptic
integrals where the papers have those. What is no number (a kind, a family) is left out, and so are
roots listed to twelve digits.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

from mpmath import (
    atan2,
    cos,
    ellipk,
    ellippi,
    findroot,
    fprod,
    inf,
    mp,
    mpf,
    pi,
    polyroots,
    polyval,
    quad,
    re,
    sign,
    sin,
    sqrt,
    workdps,
)

mp.dps = 45
NOTHING = mpf(10) ** -35  # what rounding leaves of zero

Constants = dict[str, Any]
Vector = list[mpf]


def numbers(values: Any) -> Vector:
    """Return decimal strings as numbers."""
    return [mpf(value) for value in values]


def dot(a: Sequence[mpf], b: Sequence[mpf]) -> mpf:
    """Return a . b."""
    return sum((x * y for x, y in zip(a, b, strict=True)), mpf(0))


def times(a: Sequence[mpf], b: Sequence[mpf]) -> Vector:
    """Return the products element by element."""
    return [x * y for x, y in zip(a, b, strict=True)]


def length(v: Sequence[mpf]) -> mpf:
    """Return the length of a vector."""
    return sqrt(dot(v, v))


def rows(q: Vector) -> list[Vector]:
    """Return the rows of R, v_i = R v."""
    x, y, z, w = (component / length(q) for component in q)
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]


class Swing:
    """u between two roots of u'^2 = f(u), a polynomial: its period and means over time."""

    def __init__(self, f: Vector, u: mpf) -> None:
        """f: by falling powers; u: a value on the way."""
        while f[0] == 0:
            f = f[1:]
        self.roots = polyroots(f, maxsteps=500, extraprec=400)
        real = sorted(root.real for root in self.roots if abs(root.imag) < NOTHING)
        self.low, self.high = next(
            (low, high)
            for low, high in pairwise(real)
            if low - NOTHING <= u <= high + NOTHING and polyval(f, (low + high) / 2) > 0
        )
        turning = [min(self.roots, key=lambda r: abs(r - end)) for end in (self.low, self.high)]
        self.others = [root for root in self.roots if root not in turning]
        self.factor = -f[0]  # f = factor (high - u) (u - low) times the others' u - root
        self.period = self.integral(lambda u: mpf(1))

    def rest(self, u: mpf) -> mpf:
        """Return f / ((high - u) (u - low))."""
        return self.factor * re(fprod(u - root for root in self.others))

    def integral(self, weight: Callable[[mpf], mpf]) -> mpf:
        """Return the integral of a function of u over a period, with u = mid - half cos x."""
        mid, half = (self.low + self.high) / 2, (self.high - self.low) / 2

        def integrand(x: mpf) -> mpf:
            u = mid - half * cos(x)
            return weight(u) / sqrt(self.rest(u))

        return 2 * quad(integrand, [0, pi / 2, pi])

    def pole(self, residue: mpf, denominator: Callable[[mpf], mpf]) -> mpf:
        """Return the mean of residue / denominator(u); zero where the residue is."""
        if abs(residue) < NOTHING:
            return mpf(0)
        return residue * self.integral(lambda u: 1 / denominator(u)) / self.period

    def mean_rates(self, kp: mpf, lp: mpf, km: mpf, lm: mpf) -> tuple[mpf, mpf]:
        """Return the mean precession and spin of s+' = kp + lp / (1 + u), s-' = km + ..."""
        plus = kp + self.pole(lp, lambda u: 1 + u)
        minus = km + self.pole(lm, lambda u: 1 - u)
        return (plus + minus) / 2, (plus - minus) / 2

    def kernel_modulus(self) -> mpf:
        """Return m of w = sqrt((u - low) / (high - u)) in Jacobi's functions."""
        a, b, end = self.high, self.low, self.rest
        G = 2 * sqrt(end(a) * end(b))
        # M / 2 is the polar form of the rest, a polynomial of second degree, at a and b
        M = 4 * end((a + b) / 2) - end(a) - end(b)
        return (1 - M / G) / 2 if M <= G else (M - G) / (M + G)

    def classical_modulus(self) -> mpf:
        """Return k^2 of Paladini's reductions of a quartic with two or four real roots."""
        real = sorted(root.real for root in self.roots if abs(root.imag) < NOTHING)
        if len(real) == 4:
            a1, a2, a3, a4 = real
            inner = (a3 - a2) * (a4 - a1) if self.low == a2 else (a2 - a1) * (a4 - a3)
            return inner / ((a4 - a2) * (a3 - a1))
        pair = next(root for root in self.roots if abs(root.imag) >= NOTHING)
        down, up = self.low - pair.real, self.high - pair.real
        product = sqrt((down**2 + pair.imag**2) * (up**2 + pair.imag**2))
        return (1 - (down * up + pair.imag**2) / product) / 2


def newtonian_integrals(case: dict[str, Any]) -> Constants:
    """Return the first integrals of a case of newtonian.json, as its meta defines them."""
    I, h = numbers(case['body'][axis] for axis in 'ABC'), numbers(case['rotor_h'])
    w, R = numbers(case['initial']['omega']), rows(numbers(case['initial']['q_xyzw']))
    field = case['field']
    H = [a + b for a, b in zip(times(I, w), h, strict=True)]
    known: Constants = {'quat_norm': mpf(1), 'r': w[2]}
    if field['type'] == 'fixed':
        k, m, g = mpf(field['k']), numbers(field['Mgr0']), R[2]
        others = [I[1] * I[2], I[2] * I[0], I[0] * I[1]]
        known['energy'] = dot(w, times(I, w)) / 2 + k / 2 * dot(g, times(I, g)) + dot(m, g)
        known['area_H_dot_gamma'] = dot(H, g)
        known['F2'] = dot(times(I, w), times(I, w)) - k * dot(others, times(g, g))
        known['r0_dot_omega'] = dot(m, w)
    elif field['type'] == 'circular':
        n, u = mpf(field['n']), mpf(field['u0'])
        c = [cos(u) * R[0][i] + sin(u) * R[1][i] for i in range(3)]
        jacobi = dot(w, times(I, w)) / 2 - n * dot(R[2], H) + 3 * n**2 / 2 * dot(c, times(I, c))
        known |= {'jacobi': jacobi, 'E0_BalliGrioli': 2 * jacobi - 3 * n**2 * I[0]}
    else:
        mu, a, e = numbers(field[key] for key in ('mu', 'a', 'e'))
        known |= {'orbit_energy': -mu / (2 * a), 'orbit_angmom': sqrt(mu * a * (1 - e**2))}
    return known


def stationary(case: dict[str, Any]) -> Constants:
    """Return the constants of Agostinelli's class (THEORY: alphas, e, modulus, rate, period)."""
    given, I = case['closed_form_params'], numbers(case['body'][axis] for axis in 'ABC')
    w0, nu = sqrt(mpf(case['field']['k'])), mpf(given['nu'])
    N = [1 - 2 * nu * moment for moment in I]
    alpha = [given['sign_mu'] * sqrt(fprod(N)) / n for n in N]
    g = rows(numbers(case['initial']['q_xyzw']))[2]
    e = dot(alpha, times(g, g))
    a, b, c = sorted(alpha, reverse=True)
    one, two = (a - b) * (e - c), (b - c) * (a - e)
    m, lam = (two / one, w0 * sqrt(one)) if e > b else (one / two, w0 * sqrt(two))
    known = {'omega0': w0, 'e': e, 'c0': e - alpha[2], 'm': m, 'lam': lam}
    known |= {f'alpha{i + 1}': alpha[i] for i in range(3)}
    energy = newtonian_integrals(case)['energy']
    return known | {'period_gamma': 4 * ellipk(m) / lam, 'h_energy': energy}


def pendulum(case: dict[str, Any]) -> Constants:
    """Return N^2, k^2 and the period of a planar motion without offset (Beletsky, BG)."""
    A, C = mpf(case['body']['A']), mpf(case['body']['C'])
    field, given = case['field'], case['closed_form_params']
    if field['type'] == 'fixed':
        N2 = mpf(field['k']) * (A - C) / mpf(case['body']['B'])
        theta, rate = mpf(given['vartheta0']), mpf(given['vartheta_dot0'])
    else:
        N2 = 3 * mpf(field['n']) ** 2 * (A - C) / A
        theta, rate = mpf(given['theta0']), mpf(given['thetadot0'])
    from_rest = theta if N2 > 0 else theta - pi / 2
    N = sqrt(abs(N2))
    k2 = rate**2 / N**2 + sin(from_rest) ** 2
    period = 4 * ellipk(k2) / N if k2 < 1 else 4 * ellipk(1 / k2) / (N * sqrt(k2))
    return {'N2': N2, 'k2': k2, 'period': period}


@workdps(2 * mp.dps)  # the integrand is 0 / 0 at the turning points
def offset_pendulum(case: dict[str, Any]) -> Constants:
    """Return the constants of theta'^2 = l + G1 cos(theta + delta) + G2 cos 2 theta (Beletsky)."""
    A, B, C = numbers(case['body'][axis] for axis in 'ABC')
    k, (x0, _, z0) = mpf(case['field']['k']), numbers(case['field']['Mgr0'])
    given = case['closed_form_params']
    theta, rate = mpf(given['vartheta0']), mpf(given['vartheta_dot0'])
    G1, G2, delta = 2 * sqrt(x0**2 + z0**2) / B, k * (A - C) / (2 * B), atan2(x0, -z0)
    level = rate**2 - G1 * cos(theta + delta) - G2 * cos(2 * theta)

    def square(angle: mpf) -> mpf:
        return level + G1 * cos(angle + delta) + G2 * cos(2 * angle)

    if 'rotation' in given['kind']:
        period = quad(lambda angle: 1 / sqrt(square(angle)), [0, pi / 2, pi, 3 * pi / 2, 2 * pi])
    else:
        low, high = (findroot(square, (theta + side, theta + 2 * side)) for side in (-0.5, 0.5))
        mid, half = (low + high) / 2, (high - low) / 2

        def integrand(x: mpf) -> mpf:
            angle = mid - half * cos(x)
            return half * sin(x) / sqrt(square(angle))

        period = 2 * quad(integrand, [0, pi / 2, pi])
    return {'G1': G1, 'delta': delta, 'G2': G2, 'period': period}


def lagrange(case: dict[str, Any]) -> Constants:
    """Return the constants of x'^2 = P(x), x = c_3, of Beletsky's analogue of Lagrange's top."""
    A, C = mpf(case['body']['A']), mpf(case['body']['C'])
    w, R = numbers(case['initial']['omega']), rows(numbers(case['initial']['q_xyzw']))
    m, alpha = (A - C) / A, -mpf(case['field']['Mgr0'][2]) / A
    beta, cs = mpf(case['field']['k']), (C * w[2] + mpf(case['rotor_h'][2])) / A
    x = R[2][2]
    h = w[0] ** 2 + w[1] ** 2 - 2 * alpha * x - m * beta * x**2
    k = w[0] * R[2][0] + w[1] * R[2][1] + cs * x
    a, b, c = h - beta * m + cs**2, -2 * k * cs - 2 * alpha, h - k**2
    swing = Swing([-beta * m, -2 * alpha, -a, -b, c], x)
    known = {'m_sym': m, 'alpha': alpha, 'beta': beta, 'h': h, 'k': k, 'a': a, 'b': b, 'c': c}
    return known | {'nutation_period': swing.period}


def rigid_integrals(case: dict[str, Any]) -> Constants:
    """Return the first integrals of a case of rigid.json."""
    w, R = numbers(case['omega0']), rows(numbers(case['q0_xyzw']))
    u, H1, H2 = R[2][2], mpf(case['field']['H1']), mpf(case['field']['H2'])
    U = H1 * u**2 + H2 * u
    if 'P0' in case:
        body, P0 = {key: mpf(value) for key, value in case['body'].items()}, mpf(case['P0'])
        P = [P0 * c for c in R[2]]
        v = [(P[i] - body['a14'] * w[i]) / body['a11'] for i in range(2)]
        v.append((P[2] - body['a36'] * w[2]) / body['a33'])
        G = [body['a44'] * w[i] + body['a14'] * v[i] for i in range(2)]
        G.append(body['a66'] * w[2] + body['a36'] * v[2])
        energy = (dot(P, v) + dot(G, w)) / 2 - U
        known = {'energy_T_minus_U': energy, 'P_space': [mpf(0), mpf(0), P0]}
        return known | {'G_body_3': G[2], 'G_dot_z': dot(G, R[2])}
    I = numbers(case['body'][axis] for axis in 'ABC')
    H = [i * x + h for i, x, h in zip(I, w, numbers(case['rotor_h_body']), strict=True)]
    L = [dot(row, H) for row in R]
    known = {'energy_T_minus_U': dot(w, times(I, w)) / 2 - U, 'norm_q': mpf(1)}
    return known | {'L_space_z': L[2], 'L_space': L, 'L_norm': length(H), 'L_body_3': H[2]}


def free(case: dict[str, Any]) -> Constants:
    """Return the constants of a free triaxial body (textbook, sections 46.1 and 46.11)."""
    I, w = numbers(case['body'][axis] for axis in 'ABC'), numbers(case['omega0'])
    I1, I2, I3 = sorted(I)
    E, L = dot(w, times(I, w)) / 2, length(times(I, w))
    a1 = sqrt((2 * E * I3 - L**2) / (I2 * (I3 - I2)))
    a3 = sqrt((L**2 - 2 * E * I1) / (I2 * (I2 - I1)))
    k2, lam = (min(a1, a3) / max(a1, a3)) ** 2, sqrt((I3 - I2) * (I2 - I1) / (I1 * I3))
    lam *= max(a1, a3)
    about_largest = L**2 > 2 * E * I2
    Io, Ip = (I1, I3) if about_largest else (I3, I1)
    n = Ip * (Io - I2) / (Io * (Ip - I2))
    T1 = 4 * ellipk(k2) / lam
    chi0 = L / Ip + L * (Ip - Io) / (Io * Ip) * ellippi(n, k2) / ellipk(k2)
    spin = -sign(w[I.index(I3)]) * 2 * pi / T1 if about_largest else mpf(0)
    chi0 += 0 if about_largest else 2 * pi / T1
    known = {'E': E, 'L': L, 'T1': T1, 'T2': 2 * pi / chi0, 'chi0': chi0, 'a1': a1, 'a3': a3}
    return known | {'k2': k2, 'lam': lam, 'mean_spin_psi': spin, 'mean_prec_phi': chi0}


def free_symmetric(case: dict[str, Any]) -> Constants:
    """Return the regular precession of a free symmetric body (textbook, section 45)."""
    A, C = mpf(case['body']['A']), mpf(case['body']['C'])
    integrals, r = rigid_integrals(case), mpf(case['omega0'][2])
    L, alpha = integrals['L_norm'], (C - A) * r / A
    known = {'prec_rate': L / A, 'spin_rate': -alpha, 'body_cone_rate_alpha': alpha}
    return known | {'cos_theta': integrals['L_body_3'] / L}


def free_gyrostat(case: dict[str, Any]) -> Constants:
    """Return the constants of a free gyrostat, its rotor along a principal axis."""
    I, h = numbers(case['body'][axis] for axis in 'ABC'), numbers(case['rotor_h_body'])
    w = numbers(case['omega0'])
    axis = next(i for i in range(3) if h[i])
    (I1, I2, I3), rotor = (I[axis - 2], I[axis - 1], I[axis]), h[axis]
    momentum = [I1 * w[axis - 2], I2 * w[axis - 1], I3 * w[axis] + rotor]
    L, two_E = length(momentum), dot(w, times(I, w))
    known: Constants = {'L': L, 'two_E_carrier': two_E}
    if I1 == I2:
        alpha = ((I3 - I1) * w[axis] + rotor) / I1
        return known | {'mean_prec': L / I1, 'mean_spin': -alpha, 'period_v': inf}
    # E'(v) = 2E - (L v - h)^2 / I3 and N = L^2 (1 - v^2), by falling powers
    carrier = [-(L**2) / I3, 2 * L * rotor / I3, two_E - rotor**2 / I3]
    N = [-(L**2), mpf(0), L**2]
    first = [I2 * e - n for e, n in zip(carrier, N, strict=True)]
    second = [n - I1 * e for e, n in zip(carrier, N, strict=True)]
    product = [mpf(0)] * 5
    for i, x in enumerate(first):
        for j, y in enumerate(second):
            product[i + j] += x * y / (I1 * I2 * L**2)
    swing = Swing(product, momentum[2] / L)
    at = {v: carrier[0] + carrier[1] * v + carrier[2] for v in (1, -1)}
    rates = swing.mean_rates((L + rotor) / I3, at[-1] / L, (L - rotor) / I3, at[1] / L)
    known |= {'period_v': swing.period, 'roots_v': swing.roots}
    return known | dict(zip(('mean_prec', 'mean_spin'), rates, strict=True))


def symmetric(case: dict[str, Any]) -> Constants:
    """Return the constants of Paladini's body of revolution, in a fluid or not (section 12)."""
    w, R = numbers(case['omega0']), rows(numbers(case['q0_xyzw']))
    H1, H2, u = mpf(case['field']['H1']), mpf(case['field']['H2']), R[2][2]
    known: Constants = {}
    if 'P0' in case:
        a11, a33, a44, a66, a14, a36 = numbers(
            case['body'][key] for key in ('a11', 'a33', 'a44', 'a66', 'a14', 'a36')
        )
        P0, D, D_3 = mpf(case['P0']), a11 * a44 - a14**2, a33 * a66 - a36**2
        A, C, drift = D / a11, D_3 / a33, -a14 * P0 / D
        J3, kappa = rigid_integrals(case)['G_body_3'], P0 * (a36 / D_3 - a14 / D)
        H1 += P0**2 / 2 * (a44 / D - a66 / D_3)
        H2 += J3 * kappa
        w = [w[0] - drift * R[2][0], w[1] - drift * R[2][1], J3 / C]
        known |= {'A_star': A, 'C_star': C, 'H1_star': H1, 'H2_star': H2, 'Omega_z': drift}
        known |= {'kappa': kappa, 'G3': J3, 'r0_star': w[2]}
    else:
        A, C, drift, kappa = mpf(case['body']['A']), mpf(case['body']['C']), mpf(0), mpf(0)
        J3 = C * w[2] + mpf(case['rotor_h_body'][2])
    r0 = w[2]
    g = A * (w[0] * R[2][0] + w[1] * R[2][1]) + J3 * u
    level = A / 2 * (w[0] ** 2 + w[1] ** 2) - H1 * u**2 - H2 * u
    known |= {'g': g, 'g_star': g, 'C_r0_plus_h': J3, 'L_coefficient_minus_2AH1': -2 * A * H1}
    f = [
        -2 * H1 / A,
        -2 * H2 / A,
        2 * (H1 - level) / A - (J3 / A) ** 2,
        2 * H2 / A + 2 * g * J3 / A**2,
        2 * level / A - (g / A) ** 2,
    ]
    flow = (r0 - J3 / A, (g + J3) / A, J3 / A - r0, (g - J3) / A)
    if 'steady' in case['name']:
        plus, minus = flow[0] + flow[1] / (1 + u), flow[2] + flow[3] / (1 - u)
        rates = (plus + minus) / 2, (plus - minus) / 2
        return dict(zip(('mean_precession_rate', 'mean_spin_rate'), rates, strict=True))
    if 'asymptotic' in case['name']:
        return known
    swing = Swing(f, u)
    P, S = swing.mean_rates(*flow)
    mean_u = swing.integral(lambda u: u) / swing.period
    known |= {'mean_precession_rate': P, 'mean_spin_rate': S, 'period_theta': swing.period}
    known |= {'mean_precession': P + drift, 'mean_spin': S - kappa * mean_u}
    known |= {'u_min': swing.low, 'u_max': swing.high, 'roots': swing.roots}
    known['roots_real'] = [root for root in swing.roots if abs(root.imag) < NOTHING]
    known['roots_complex'] = [root for root in swing.roots if abs(root.imag) >= NOTHING]
    known['kernel_modulus_k2'] = swing.kernel_modulus()
    if H1 and len(swing.roots) == 4:
        known['classical_k2'] = swing.classical_modulus()
    return known


def constants_of(case: dict[str, Any]) -> Constants:
    """Return the constants of a case of newtonian.json or rigid.json, by the file's names."""
    if 'closed_form_params' in case:
        given = case['closed_form_params']
        known = newtonian_integrals(case)
        for key, function in (('alpha1', stationary), ('N2', pendulum), ('G1', offset_pendulum)):
            if key in given:
                return known | function(case)
        return known | (lagrange(case) if 'm_sym' in given else {})
    known, derived = rigid_integrals(case), case['derived']
    for key, function in (('T2', free), ('prec_rate', free_symmetric), ('L', free_gyrostat)):
        if key in derived:
            return known | function(case)
    return known | (symmetric(case) if case['name'].startswith('pal') else {})
