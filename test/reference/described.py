"""The cases as equations; each of the three files describes bodies and fields its own way."""

from __future__ import annotations

from typing import Any

import gmpy2
from equations import Problem, gyrostat, immersed, numbers, unit
from gmpy2 import mpfr


def problem_of(case: dict[str, Any]) -> Problem:
    """Return the equations of a case of any of the files."""
    if 'rotors' in case:
        return gyrostat({**case, **case['initial']})
    body, field = case['body'], case['field']
    if 'H1' not in field:
        return gyrostat(_newtonian(case))
    common = {
        'q_xyzw': case['q0_xyzw'],
        'omega': case['omega0'],
        'potential': (field['H1'], field['H2']),
    }
    if 'P0' in case:
        return immersed({**common, 'body': body, 'P0': case['P0']})
    rigid = {'orbit': {'type': 'fixed', 'gradient': 0}, 'rotors': _held(case['rotor_h_body'])}
    return gyrostat({**common, **rigid, 'inertia': _diagonal(body)})


def _newtonian(case: dict[str, Any]) -> dict[str, Any]:
    field = case['field']
    described: dict[str, Any] = {
        'inertia': _diagonal(case['body']),
        'rotors': _held(case['rotor_h']),
        **_start(case),
    }
    if field['type'] == 'fixed':
        described['orbit'] = {'type': 'fixed', 'gradient': field['k']}
        described['weight_moment'] = field['Mgr0']
    elif field['type'] == 'circular':
        mu = mpfr(field['n']) ** 2  # of the unit circle
        described['orbit'] = {'type': 'circular', 'mu': mu, 'semi_major_axis': 1}
        described['orbit']['true_anomaly'] = field['u0']
    else:
        described['orbit'] = {
            'type': 'kepler',
            'mu': field['mu'],
            'semi_major_axis': field['a'],
            'eccentricity': field['e'],
            'true_anomaly': field['f0'],
        }
    return described


def _start(case: dict[str, Any]) -> dict[str, list[mpfr]]:
    """
    Return q and omega of a newtonian case at the start.

    Agostinelli's cases are unstable: the 32 stored digits would not do, and the state is built
    from its angles psi, theta, phi (z-x-z) and nu, omega_i = omega_0 alpha_i c_i.
    """
    given = case['closed_form_params']
    if 'nu' not in given:
        return {
            'q_xyzw': unit(case['initial']['q_xyzw']),
            'omega': numbers(case['initial']['omega']),
        }
    moments, nu = numbers(case['body'][axis] for axis in 'ABC'), mpfr(given['nu'])
    N = [1 - 2 * nu * moment for moment in moments]
    root = given['sign_mu'] * gmpy2.sqrt(mpfr(case['field']['k']) * N[0] * N[1] * N[2])
    psi, theta, phi = numbers(given[angle] for angle in ('psi0', 'theta0', 'phi0'))
    if 'e_minus_alpha_mid' in given:
        theta, phi = _on_separatrix([root / n for n in N], theta, phi)
    plus, minus = (psi + phi) / 2, (psi - phi) / 2
    s, c = gmpy2.sin(theta / 2), gmpy2.cos(theta / 2)
    q = [s * gmpy2.cos(minus), s * gmpy2.sin(minus), c * gmpy2.sin(plus), c * gmpy2.cos(plus)]
    direction = _direction(theta, phi)
    return {'q_xyzw': q, 'omega': [root / n * c_i for n, c_i in zip(N, direction, strict=True)]}


def _direction(theta: mpfr, phi: mpfr) -> list[mpfr]:
    s = gmpy2.sin(theta)
    return [gmpy2.sin(phi) * s, gmpy2.cos(phi) * s, gmpy2.cos(theta)]


def _on_separatrix(alpha: list[mpfr], theta: mpfr, phi: mpfr) -> tuple[mpfr, mpfr]:
    """Return the angles of the point of sum alpha_i c_i^2 = alpha_2 that has the same c_2."""
    c_2 = _direction(theta, phi)[1]
    rest = (1 - c_2 * c_2) / (alpha[2] - alpha[0])
    c_1, c_3 = gmpy2.sqrt(rest * (alpha[2] - alpha[1])), gmpy2.sqrt(rest * (alpha[1] - alpha[0]))
    return gmpy2.acos(c_3), gmpy2.atan2(c_1, c_2)


def _diagonal(body: dict[str, str]) -> list[list[Any]]:
    A, B, C = (body[axis] for axis in 'ABC')
    return [[A, 0, 0], [0, B, 0], [0, 0, C]]


def _held(momentum: list[str]) -> list[dict[str, Any]]:
    return [{'mode': 'constant_momentum', 'axis': momentum, 'momentum': 1}]
