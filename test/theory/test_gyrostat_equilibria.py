"""All relative equilibria of gyrostats against known sets, the balance and Morse's count."""

import numpy as np
import pytest

from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import KeplerOrbit
from satdyn_ros.theory.equilibria import is_balanced, relative_equilibria
from satdyn_ros.theory.gyrostat_equilibria import gyrostat_equilibria

ORBIT = KeplerOrbit()
N = ORBIT.mean_motion
I = np.diag([800.0, 900.0, 600.0])


def test_a_rigid_body_has_its_24():
    """Without a rotor these are the attitudes with the principal axes along LVLH's."""
    found, known = gyrostat_equilibria(I, I, np.zeros(3), N), relative_equilibria(I)
    gaps = rotation.angle_between(found[:, None], known[None])
    assert gaps.shape == (24, 24)
    assert np.max(np.min(gaps, axis=0)) < 1e-12


@pytest.mark.parametrize('h', [[0.1, 0.2, 0.05], [3.0, 1.0, 2.0], [0.0, -0.2, 0.0]])
def test_each_balances_and_they_are_as_many_as_morse_allows(h):
    """
    Each keeps its rate, and maxima, minima and saddles of the amended potential add up.

    The numbers of its extrema and saddles by index, with signs, give the Euler number of the
    attitudes, 0: one that was missed would leave the sum at +-1.
    """
    h = np.array(h)
    size = float(np.linalg.norm(h))
    system = System(I, (Rotor('constant_momentum', h / size, size),), ORBIT)
    total = 0
    found = gyrostat_equilibria(I, I, h, N)
    for q_lb in found:
        q_ib = rotation.multiply(ORBIT.lvlh(0.0), q_lb)
        omega = rotation.rotate(rotation.conjugate(q_ib), ORBIT.lvlh_rate(0.0))
        assert is_balanced(system, State(q_ib, omega))
        bend = _second_differences(q_lb, h)
        total += int(np.prod(np.sign(np.linalg.eigvalsh(bend))))
    assert 8 <= len(found) <= 24
    assert total == 0


def _second_differences(q_lb, h, step=1e-4):
    """Return the second derivatives (3, 3) of the amended potential in small turns, divided."""

    def potential(x):
        q = rotation.multiply(q_lb, rotation.normalise([*(np.asarray(x) / 2.0), 1.0]))
        to_body = rotation.conjugate(q)
        c, k = (rotation.rotate(to_body, -axis) for axis in np.eye(3)[[2, 1]])
        return 1.5 * N**2 * c @ I @ c - N**2 * k @ I @ k / 2.0 - N * h @ k

    e = step * np.eye(3)
    return np.array(
        [
            [potential(a + b) - potential(a - b) - potential(b - a) + potential(-a - b) for b in e]
            for a in e
        ]
    )


def test_a_symmetric_gyrostat_has_one_for_each_circle():
    """
    The axis along the normal always, and off it for a small rotor momentum (Likins 1965).

    Hyperbolic equilibria, in the plane of normal and track, need |h| < n |A - C|; conical ones, in
    the plane of normal and up, |h| < 4 n |A - C|.  Turns about the axis are not counted.
    """
    A, C, axis = 800.0, 600.0, np.array([0.0, 0.0, 1.0])
    inertia = np.diag([A, A, C])
    for share, count in ((0.0, 6), (0.5, 6), (2.0, 4), (5.0, 2)):
        h = share * N * (A - C) * axis
        found = gyrostat_equilibria(inertia, inertia, h, N, axis)
        assert len(found) == count
