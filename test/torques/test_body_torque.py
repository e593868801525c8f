"""A torque that depends on time, position, attitude and rate, flown alone and beside others."""

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import plain_equations
import pytest
from scipy.integrate import quad, solve_ivp

from satdyn_ros import exact
from satdyn_ros.dynamics.integrals import first_integrals, relative_drift
from satdyn_ros.dynamics.motion import States
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.integrate.batch import propagate_all
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.kernel.functions import select
from satdyn_ros.kernel.vector import dot, scale, to_body
from satdyn_ros.orbits import FixedDirection, KeplerOrbit
from satdyn_ros.torques.body_torque import BodyTorque

INERTIA = np.diag([3.0, 2.0, 4.0])
ORBITS: dict[str, FixedDirection | KeplerOrbit] = {
    'fixed': FixedDirection(1e-6),
    'circle': KeplerOrbit(inclination=0.7),
    'ellipse': KeplerOrbit(eccentricity=0.2, inclination=0.7, semi_major_axis=9e6),
}
STATE = State(rotation.normalise([0.1, 0.2, 0.3, 0.9]), np.array([0.01, 0.02, -0.015]))
TIMES = np.linspace(0.0, 2000.0, 41)
START_S = 30.0
# Both keep 1e-13 a step, in some thousand steps, and attitudes grow apart a hundredfold.
ANGLE = 1e-9


class Kick(BodyTorque):
    """A pulse, a push that follows the position on the orbit, and plates that brake."""

    name = 'kick'

    class Constants(NamedTuple):
        pulse: tuple[float, float]
        size: float
        brakes: np.ndarray

    @staticmethod
    def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        begin_s, end_s = constants.pulse
        pulse = select(t_s >= begin_s, constants.size, 0.0)
        pulse = select(t_s < end_s, pulse, 0.0)
        y = 1e-11 * r_i[0] * math.sin(0.01 * t_s) - 1e-9 * v_i[2] * q_ib[1]
        z = 0.0
        for brake in constants.brakes:
            z = z - brake * max(omega_bi_b[2], 0.0)
        return pulse, y, z

    def stops(self):
        return np.array(self.constants.pulse)


def kick(begin_s=50.0, size=1e-3, brakes=(1e-4, 3e-4)):
    return Kick(Kick.Constants((begin_s, begin_s + 20.0), size, np.array(brakes)))


def system_of(orbit, torque):
    return System(INERTIA, orbit=ORBITS[orbit], torques=(torque,))


def slope_of(system):
    """Return the derivatives of q_ib and omega_bi_b as a function of t and both."""

    def slope(t, y):
        q_ib = y[:4] / np.linalg.norm(y[:4])
        found = plain_equations.rates(system, START_S + t, q_ib, y[4:], np.zeros(0))
        return [*found.q_ib, *found.omega_bi_b]

    return slope


def by_scipy(system, state, t_s):
    """Return the attitudes (N, 4), integrated from each stop to the next."""
    slope = slope_of(system)
    stops = [s - START_S for torque in system.torques for s in torque.stops()]
    edges = [0.0, *(s for s in sorted(stops) if 0.0 < s < t_s[-1]), t_s[-1]]
    y, found = [*state.q_ib, *state.omega_bi_b], []
    for begin, end in pairwise(edges):
        inside = t_s[(begin <= t_s) & (t_s < end)]
        # less a rounding, so that the jump at the end is not seen
        times = [*inside, end * (1.0 - 1e-15)]
        part = solve_ivp(slope, (begin, times[-1]), y, 'DOP853', times, rtol=1e-13, atol=1e-15).y.T
        found += list(part[:-1])
        y = part[-1]
    return rotation.normalise(np.array([*found, y])[:, :4])


@pytest.mark.parametrize('orbit', ORBITS)
def test_a_torque_is_integrated_as_scipy_does(orbit):
    """Jumps at its stops and all; its work keeps the balance of energy."""
    system = system_of(orbit, kick())
    states = Propagation(system, STATE, START_S).at(TIMES)
    apart = rotation.angle_between(states.q_ib, by_scipy(system, STATE, TIMES))
    assert np.max(apart) < ANGLE
    drift = relative_drift(system, states)
    assert set(drift) == {'energy_balance'}
    assert np.max(np.abs(drift['energy_balance'])) < 1e-12


@pytest.mark.parametrize('orbit', ORBITS)
def test_many_beside_each_other_are_as_each_alone(orbit):
    """With pulses at other times, sizes and brakes, some more than others."""
    torques = [
        *(kick(40.0 + 100.0 * i) for i in range(5)),
        *(kick(size=1e-3 * i) for i in range(5)),
        *(kick(brakes=[1e-4] * i) for i in range(3)),
    ]
    motions = [Propagation(system_of(orbit, torque), STATE, START_S) for torque in torques]
    for motion, states in zip(motions, propagate_all(motions, TIMES), strict=True):
        assert isinstance(states, States)
        alone = Propagation(motion.system, STATE, START_S).at(TIMES)
        assert states.q_ib.tobytes() == alone.q_ib.tobytes()
        assert states.work.tobytes() == alone.work.tobytes()


def test_a_pulse_is_not_stepped_over():
    """A body at rest without a field has steps of months, but for the stops."""
    system = System(INERTIA, torques=(kick(1e6),))
    rest = State(np.array([0.0, 0.0, 0.0, 1.0]), np.zeros(3))
    for states in (
        Propagation(system, rest).at([2e6]),
        *propagate_all([Propagation(system, rest)], [2e6]),
    ):
        assert isinstance(states, States)
        assert states.omega_bi_b[0, 0] == pytest.approx(1e-3 * 20.0 / 3.0, rel=1e-12)


def test_no_closed_form_takes_it():
    """It says so, and by name."""
    system = System(INERTIA, torques=(kick(),))
    assert exact.recognise(system, STATE) is None
    assert 'kick' in str(exact.explain(system, STATE))


class Sail(BodyTorque):
    """A sail that is pushed through the half turn in which it shows its face."""

    name = 'sail'

    class Constants(NamedTuple):
        size: float

    @staticmethod
    def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        return 0.0, 0.0, constants.size * max(2.0 * q_ib[2] * q_ib[3], 0.0)


class Edged(Sail):
    """The same, with the edges named."""

    name = 'edged'

    class Constants(NamedTuple):
        size: float

    @staticmethod
    def signs(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        return (q_ib[2] * q_ib[3],)


def half_turns(size, rate, count):
    """Return the times (count,) at which the body of a Sail has turned by pi, 2 pi, ..."""
    # I omega^2 / 2 grows by size (1 - cos f), by quadrature of df / omega.
    times, square, inertia = [], rate**2, INERTIA[2, 2]
    for k in range(count):
        push = 2.0 * size / inertia if k % 2 == 0 else 0.0
        took, _ = quad(
            lambda f, begin, push: 1.0 / math.sqrt(begin + push * (1.0 - math.cos(f))),
            *(0.0, math.pi, (square, push)),
            epsabs=0.0,
            epsrel=1e-13,
        )
        times.append(took)
        square += 2.0 * push
    return np.cumsum(times)


def test_steps_end_at_corners():
    """Alone and beside others, after ten turns; steps across corners leave a larger error."""
    rest = State(np.array([0.0, 0.0, 0.0, 1.0]), np.array([0.0, 0.0, 0.03]))
    sizes = [1e-3 * (1 + i) for i in range(4)]

    def missing(kind):
        """Return what is missing of the last half turn [rad], of each alone and beside others."""
        motions = [
            Propagation(System(INERTIA, torques=(kind(kind.Constants(size)),)), rest)
            for size in sizes
        ]
        found = []
        for motion, size in zip(motions, sizes, strict=True):
            t_s = half_turns(size, 0.03, 20)
            for states in (motion.at(t_s), *propagate_all([*motions, motion], t_s)[-1:]):
                assert isinstance(states, States)
                found.append(rotation.angle_between(states.q_ib[-1], rest.q_ib))
        return np.array(found)

    # A hundred steps of 1e-13, which the growing rate carries on.
    assert np.max(missing(Edged)) < 1e-11
    assert np.max(missing(Sail)) > 1e-9


class Needle(BodyTorque):
    """A dipole along x in a field along the line from the attracting centre, +Z on `fixed`."""

    name = 'needle'
    is_steady = True

    class Constants(NamedTuple):
        moment: float
        z: float

    @staticmethod
    def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        _, y, z = field_of(r_i, q_ib, constants.z)
        return 0.0, -constants.moment * z, constants.moment * y

    @staticmethod
    def potential(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        x, _, _ = field_of(r_i, q_ib, constants.z)
        return -constants.moment * x


def field_of(r_i, q_ib, z):
    along = to_body(q_ib, (r_i[0], r_i[1], r_i[2] + z))
    return scale(1.0 / math.sqrt(dot(along, along)), along)


class Compass(Needle):
    """The same, whose field is said to be fixed in inertial axes."""

    name = 'compass'
    is_steady = False

    class Constants(NamedTuple):
        moment: float
        z: float


def test_a_dipole_in_a_uniform_field_is_a_top():
    """Its motion and its energy are those of a weight."""
    dipole = System(INERTIA, orbit=ORBITS['fixed'], torques=(Needle(Needle.Constants(1e-3, 1.0)),))
    weight = System(INERTIA, orbit=ORBITS['fixed'], weight_moment=np.array([-1e-3, 0.0, 0.0]))
    states, right = (Propagation(system, STATE).at(TIMES) for system in (dipole, weight))
    assert np.max(rotation.angle_between(states.q_ib, right.q_ib)) < ANGLE
    found, expected = first_integrals(dipole, states), first_integrals(weight, right)
    assert set(found) == {'energy'}
    assert found['energy'] == pytest.approx(expected['energy'], rel=1e-12)


@pytest.mark.parametrize(
    ('orbit', 'kind', 'name'),
    [
        ('circle', Needle, 'jacobi'),
        ('circle', Compass, 'energy_balance'),
        ('ellipse', Needle, 'energy_balance'),
    ],
)
def test_a_potential_counts_where_its_field_is_fixed(orbit, kind, name):
    """In axes that turn with a circle; elsewhere the torque does work, and the balance holds."""
    system = system_of(orbit, kind(kind.Constants(1e-3, 0.0)))
    drift = relative_drift(system, Propagation(system, STATE, START_S).at(TIMES))
    assert set(drift) == {name}
    assert np.max(np.abs(drift[name])) < 1e-12
