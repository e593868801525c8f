"""The test problem: a triaxial gyrostat over ten circular orbits, and its truth."""

import json
from pathlib import Path

import numpy as np
from common import QUICK

from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import KeplerOrbit

MU = 3.986004418e14
N = 1.1e-3
SEMI_MAJOR_AXIS = (MU / N**2) ** (1.0 / 3.0)
INERTIA = np.array([900.0, 800.0, 600.0])
MOMENTUM = np.array([0.0, 5.0, 0.0])
ORBIT_S = 5712.0
DURATION_S = ORBIT_S if QUICK else 10.0 * ORBIT_S
GRID_S = np.arange(round(10.0 * DURATION_S) + 1) * 0.1
MAX_ERROR_RAD = 1e-10
START = State(
    rotation.normalise([0.4, 0.4, 0.8, 0.2]),
    np.array([0.01, 0.02, -0.015]),
    np.zeros(1),
    np.zeros(1),
)


def system(eccentricity: float = 0.0, rotor: Rotor | None = None) -> System:
    """Return the satellite; the orbit's mean motion is N."""
    rotor = rotor or Rotor('constant_momentum', np.array([0.0, 1.0, 0.0]), momentum=5.0)
    orbit = KeplerOrbit(mu=MU, semi_major_axis=SEMI_MAJOR_AXIS, eccentricity=eccentricity)
    return System(np.diag(INERTIA), (rotor,), orbit)


def truth() -> tuple[np.ndarray, np.ndarray]:
    """Return times (11,) and attitudes (11, 4) of the stored high-precision reference."""
    stored = json.loads((Path(__file__).parent / 'reference.json').read_text())
    return np.array(stored['t_s']), np.array(stored['states'], float)[:, :4]


def error_rad(q_ib, t_s) -> float:
    """Return the largest attitude error of q_ib (N, 4) at t_s where the truth has these times."""
    times, attitudes = truth()
    rows = np.searchsorted(t_s, times)
    found = rows < len(t_s)
    found[found] = t_s[rows[found]] == times[found]
    return float(np.max(rotation.angle_between(q_ib[rows[found]], attitudes[found])))


def right_hand_side(t, y):
    """Return dy/dt for y = (q_ib, omega) as a user writes it with NumPy."""
    q, omega = y[:4], y[4:]
    x, yy, z, w = q
    R = np.array(
        [
            [1 - 2 * (yy * yy + z * z), 2 * (x * yy - w * z), 2 * (x * z + w * yy)],
            [2 * (x * yy + w * z), 1 - 2 * (x * x + z * z), 2 * (yy * z - w * x)],
            [2 * (x * z - w * yy), 2 * (yy * z + w * x), 1 - 2 * (x * x + yy * yy)],
        ]
    )
    c = R.T @ np.array([np.cos(N * t), np.sin(N * t), 0.0])
    torque = 3 * N**2 * np.cross(c, INERTIA * c)
    omega_dot = (torque - np.cross(omega, INERTIA * omega + MOMENTUM)) / INERTIA
    p, r, s = omega
    q_dot = 0.5 * np.array(
        [
            w * p + yy * s - z * r,
            w * r + z * p - x * s,
            w * s + x * r - yy * p,
            -x * p - yy * r - z * s,
        ]
    )
    return np.concatenate([q_dot, omega_dot])


def right_hand_side_floats(t, y):
    """Return dy/dt written out in plain floats."""
    from math import cos, sin

    x, yy, z, w, p, q, r = y.tolist()
    c, s = cos(N * t), sin(N * t)
    c1 = c * (1 - 2 * (yy * yy + z * z)) + s * 2 * (x * yy + w * z)
    c2 = c * 2 * (x * yy - w * z) + s * (1 - 2 * (x * x + z * z))
    c3 = c * 2 * (x * z + w * yy) + s * 2 * (yy * z - w * x)
    k = 3 * N * N
    h1, h2, h3 = 900.0 * p, 800.0 * q + 5.0, 600.0 * r
    return [
        0.5 * (w * p + yy * r - z * q),
        0.5 * (w * q + z * p - x * r),
        0.5 * (w * r + x * q - yy * p),
        -0.5 * (x * p + yy * q + z * r),
        (k * (600.0 - 800.0) * c2 * c3 - (q * h3 - r * h2)) / 900.0,
        (k * (900.0 - 600.0) * c3 * c1 - (r * h1 - p * h3)) / 800.0,
        (k * (800.0 - 900.0) * c1 * c2 - (p * h2 - q * h1)) / 600.0,
    ]


def heyoka_equations(lvlh: bool = False):
    """
    Return the problem as heyoka's symbolic equations of the attitude and the inertial rate.

    lvlh: of q_lb in place of q_ib, in whose axes the centre stands still: no sine, no cosine.
    """
    import heyoka as hy

    x, y, z, w, p, q, r = hy.make_vars('x', 'y', 'z', 'w', 'p', 'q', 'r')
    if lvlh:
        c1, c2, c3 = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
        turn = [N * z, N * w, -N * x, -N * y]
    else:
        c, s = hy.cos(N * hy.time), hy.sin(N * hy.time)
        c1 = c * (1 - 2 * (y * y + z * z)) + s * 2 * (x * y + w * z)
        c2 = c * 2 * (x * y - w * z) + s * (1 - 2 * (x * x + z * z))
        c3 = c * 2 * (x * z + w * y) + s * 2 * (y * z - w * x)
        turn = [0.0, 0.0, 0.0, 0.0]
    k = 3 * N * N
    h1, h2, h3 = 900.0 * p, 800.0 * q + 5.0, 600.0 * r
    return [
        (x, 0.5 * (w * p + y * r - z * q + turn[0])),
        (y, 0.5 * (w * q + z * p - x * r + turn[1])),
        (z, 0.5 * (w * r + x * q - y * p + turn[2])),
        (w, -0.5 * (x * p + y * q + z * r - turn[3])),
        (p, (k * (600.0 - 800.0) * c2 * c3 - (q * h3 - r * h2)) / 900.0),
        (q, (k * (900.0 - 600.0) * c3 * c1 - (r * h1 - p * h3)) / 800.0),
        (r, (k * (800.0 - 900.0) * c1 * c2 - (p * h2 - q * h1)) / 600.0),
    ]


def from_lvlh(q_lb, t_s):
    """Return q_ib (N, 4) of attitudes q_lb (N, 4) at t_s."""
    return rotation.multiply(system().orbit.lvlh(t_s), q_lb)


def to_lvlh(q_ib):
    """Return q_lb of an attitude q_ib at the start."""
    return rotation.multiply(rotation.conjugate(system().orbit.lvlh(0.0)), q_ib)


def check(name, q_ib, t_s):
    """Print the error of attitudes at t_s; SystemExit: it is above MAX_ERROR_RAD."""
    error = error_rad(q_ib, t_s)
    print(f'{name}: error {error:.2g} rad')
    if error > MAX_ERROR_RAD:
        raise SystemExit(f'{name} misses {MAX_ERROR_RAD:g} rad by its error of {error:.3g} rad')
