"""The propagation against truths from outside: 190-bit integrations, NASA's logs, SciPy."""

import copy
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cases import REFERENCE, bounded, newtonian, rigid
from scipy.integrate import DOP853, solve_ivp
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from satdyn_ros.dynamics.integrals import first_integrals, relative_drift
from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.integrate import tableau
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import FixedDirection, KeplerOrbit
from satdyn_ros.run.scenario import Scenario

ROOT = Path(__file__).parents[2]
CASES = newtonian() | rigid()


@pytest.mark.parametrize('name', bounded(CASES, 'bound_numeric'))
def test_reference_case(name):
    """Every reference case stays within its bound at tolerance 1e-13, ten times it in rate."""
    case = CASES[name]
    states = Propagation(case.system, case.start, tolerance=1e-13).at(case.t_s)
    assert rotation.angle_between(states.q_ib, case.q_ib).max() < case.bound_numeric
    rate = np.linalg.norm(case.omega_bi_b, axis=1).max()
    error = np.linalg.norm(states.omega_bi_b - case.omega_bi_b, axis=1).max()
    assert error < 10.0 * case.bound_numeric * rate


def test_nasa_jeod_attitude_after_eight_hours():
    """JEOD's check case 10A from its first state: within 7e-11 rad in all of the 8 hours."""
    log = json.loads((REFERENCE / 'nasa_jeod.json').read_text())
    first, *later = log['runs'].popitem()[1]
    orbit = KeplerOrbit.from_state(first['r_i_m'], first['v_i_m_s'], log['meta']['mu_m3_s2'])
    system = System(np.diag(log['meta']['inertia_kg_m2']), orbit=orbit)
    start = State(_q_ib(first), np.array(first['omega_bi_b_rad_s']))
    states = Propagation(system, start, tolerance=1e-13).at([row['t_s'] for row in later])
    for i, row in enumerate(later):
        # JEOD integrates the orbit too: metres of its own error are no error of the attitude.
        np.testing.assert_allclose(states.r_i[i], row['r_i_m'], rtol=1e-9, atol=1e-2)
        np.testing.assert_allclose(states.omega_bi_b[i], row['omega_bi_b_rad_s'], atol=1e-12)
        # 6.0e-11 at tolerances of 1e-13 and 1e-14: the rest is in the logged digits.
        assert rotation.angle_between(states.q_ib[i], _q_ib(row)) < 7e-11


def _q_ib(row):
    return rotation.from_matrix(np.array(row['T_inertial_to_body']).T)


NASA_CYLINDER = np.array([500.0, 12250.0, 12250.0])
NASA_PERIOD_S = 5526.56


def _cylinder(pitch_deg, roll_deg):
    """Return the NASA cylinder at rest in LVLH, its long axis turned from the local vertical."""
    mu = 3.986004418e14
    orbit = KeplerOrbit(mu=mu, semi_major_axis=(mu * (NASA_PERIOD_S / 2 / np.pi) ** 2) ** (1 / 3))
    tilt = rotation.from_roll_pitch_yaw(np.radians(roll_deg), np.radians(pitch_deg), 0.0)
    vertical = rotation.about([0, 1, 0], -np.pi / 2)
    q_ib = rotation.multiply(orbit.lvlh(0.0), rotation.multiply(tilt, vertical))
    omega = rotation.rotate(rotation.conjugate(q_ib), orbit.lvlh_rate(0.0))
    return Propagation(System(np.diag(NASA_CYLINDER), orbit=orbit), State(q_ib, omega))


def _period(motion, component, duration_s=20000.0):
    """Return the mean time between upward zeros of a component of the long axis in LVLH."""
    t_s = np.linspace(0.0, duration_s, 200001)
    states = motion.at(t_s)
    x = rotation.matrix(states.q_lb)[:, component, 0]
    rises = np.nonzero((x[:-1] < 0.0) & (x[1:] >= 0.0))[0]
    zeros = t_s[rises] - x[rises] * (t_s[rises + 1] - t_s[rises]) / (x[rises + 1] - x[rises])
    return np.mean(np.diff(zeros))


@pytest.mark.parametrize(
    ('pitch_deg', 'roll_deg', 'component', 'period_s'),
    [
        (0.001, 0.0, 0, 3257.94),
        (5.0, 0.0, 0, 3264.16),
        # Hughes' 2821.46 s, orbital period / sqrt(4 (Iyy - Ixx) / Izz), holds yaw still.  Free in
        # yaw, the axis of a symmetric body has period / sqrt(4 - 3 Ixx / Iyy): the linear
        # equations of roll and yaw, coupled.
        (0.0, 0.001, 1, 2806.57),
    ],
)
def test_nasa_cylinder_periods(pitch_deg, roll_deg, component, period_s):
    """The NASA cylinder librates with the periods of Hughes 2004, to their last digit."""
    assert _period(_cylinder(pitch_deg, roll_deg), component) == pytest.approx(period_s, abs=0.006)


def test_relative_equilibria_stay():
    """The 24 relative equilibria of a triaxial body are fixed points to round-off."""
    orbit = KeplerOrbit(inclination=0.7, raan=0.3)
    system = System(np.diag([800.0, 900.0, 600.0]), orbit=orbit)
    orbit_s = 2.0 * np.pi / orbit.mean_motion
    for R in Rotation.create_group('O').as_quat():
        q_ib = rotation.multiply(orbit.lvlh(0.0), R)
        start = State(q_ib, rotation.rotate(rotation.conjugate(q_ib), orbit.lvlh_rate(0.0)))
        q_lb = Propagation(system, start, tolerance=1e-13).at([orbit_s / 4.0]).q_lb
        # An unstable one (rate below 3 n) lets rounding grow by exp(3 pi / 2) in that time.
        assert rotation.angle_between(q_lb[0], R) < 1e-12


def test_at_rest_in_lvlh_stays_there():
    """A body without gradient torque that turns with LVLH keeps its attitude to LVLH."""
    orbit = KeplerOrbit(inclination=1.0, argument_of_periapsis=0.4)
    q_ib = rotation.multiply(orbit.lvlh(0.0), rotation.about([0, 0, 1], 0.3))
    start = State(q_ib, rotation.rotate(rotation.conjugate(q_ib), orbit.lvlh_rate(0.0)))
    motion = Propagation(System(700.0 * np.eye(3), orbit=orbit), start)
    q_lb = motion.at(np.linspace(0.0, 6000.0, 13)).q_lb
    assert rotation.angle_between(q_lb, q_lb[0]).max() < 1e-11


@pytest.mark.parametrize('method_tolerance', [(1e-13, 2e-11), (1e-12, 2e-10)])
def test_first_integrals_over_100_orbits(method_tolerance):
    """The energy-like integral of the default scenario keeps its value for 100 orbits."""
    tolerance, bound = method_tolerance
    scenario = Scenario.from_yaml(ROOT / 'config' / 'default.yaml')
    scenario = scenario.with_values({'motion.tolerance': tolerance})
    orbit = scenario.system.orbit
    assert isinstance(orbit, KeplerOrbit)
    period_s = 2.0 * np.pi / orbit.mean_motion
    states = scenario.motion().at(np.linspace(0.0, 100.0 * period_s, 2001))
    for name, values in scenario.integrals(states).items():
        assert np.max(np.abs(values / values[0] - 1.0)) < bound, name


SYSTEMS = {
    'circular gyrostat': System(
        np.array([[800.0, 10.0, 5.0], [10.0, 900.0, -7.0], [5.0, -7.0, 600.0]]),
        (Rotor('constant_momentum', np.array([0.0, 0.6, 0.8]), momentum=-3.0),),
        KeplerOrbit(inclination=0.5, true_anomaly=1.0),
    ),
    'ellipse, free rotor': System(
        np.diag([800.0, 900.0, 600.0]),
        (Rotor('free', np.array([0.6, 0.0, 0.8]), inertia=0.5),),
        KeplerOrbit(semi_major_axis=9e6, eccentricity=0.25, argument_of_periapsis=0.3),
    ),
    'motor and torque': System(
        np.diag([800.0, 900.0, 600.0]),
        (Rotor('motor', np.array([0.0, 0.6, 0.8]), inertia=0.5),),
        KeplerOrbit(semi_major_axis=9e6, eccentricity=0.1, true_anomaly=2.0),
        torque_b=np.array([0.01, -0.02, 0.005]),
        rotor_torque=np.array(0.03),
    ),
    'heavy top': System(
        np.diag([1.0, 1.5, 2.0]),
        (Rotor(),),
        FixedDirection(0.7),
        weight_moment=np.array([0.3, -0.2, 0.4]),
    ),
}


# Code of its own is compiled for a body that turns a rotor on an ellipse.
EACH_SYSTEM = [
    pytest.param(
        name, marks=[pytest.mark.long] * (system.has_turning_rotor and system.orbit.is_eccentric)
    )
    for name, system in SYSTEMS.items()
]


def _start(system):
    q_ib = rotation.normalise([0.4, 0.4, 0.8, 0.2])
    turns = system.has_turning_rotor
    scale = 1.0 if isinstance(system.orbit, FixedDirection) else 0.01
    speed, angle = (100.0, 0.5) if turns else (np.nan, np.nan)
    return State(q_ib, scale * np.array([1.0, 2.0, -1.5]), speed, angle), 10.0 / scale


def line_of_sight(orbit, t):
    """Return c in inertial axes and 3 mu / r^3, from Kepler's equation solved by bisection."""
    if isinstance(orbit, FixedDirection):
        return np.array([0.0, 0.0, 1.0]), orbit.gradient
    e, a, mu = orbit.eccentricity, orbit.semi_major_axis, orbit.mu
    f_0 = orbit.true_anomaly
    E_0 = 2.0 * np.arctan2(np.sqrt(1.0 - e) * np.sin(f_0 / 2), np.sqrt(1.0 + e) * np.cos(f_0 / 2))
    M = E_0 - e * np.sin(E_0) + np.sqrt(mu / a**3) * t
    E = brentq(lambda E: E - e * np.sin(E) - M, M - 1.0, M + 1.0, xtol=1e-15, rtol=9e-16)
    in_plane = [a * (np.cos(E) - e), a * np.sqrt(1.0 - e * e) * np.sin(E), 0.0]
    angles = [orbit.raan, orbit.inclination, orbit.argument_of_periapsis]
    r = Rotation.from_euler('ZXZ', angles).apply(in_plane)
    return r / np.linalg.norm(r), 3.0 * mu / np.linalg.norm(r) ** 3


@pytest.mark.parametrize('name', EACH_SYSTEM)
def test_against_an_independent_integration(name):
    """
    Every rotor mode, orbit and torque against the equations written anew for SciPy's DOP853.

    Rotations are SciPy's, the orbit is solved anew.
    """
    system = SYSTEMS[name]
    start, duration_s = _start(system)
    I, rotor, orbit = system.inertia, system.rotors[0], system.orbit
    a, J, tau = rotor.axis, rotor.inertia, system.rotor_torque[0]

    def equations(t, y):
        R, omega, s = Rotation.from_quat(y[:4]), y[4:7], y[7]
        c_i, gradient = line_of_sight(orbit, t)
        c = R.inv().apply(c_i)
        torque = gradient * np.cross(c, I @ c) - np.cross(system.weight_moment, c)
        torque = torque + system.torque_b
        if rotor.turns_freely:
            # I w' + J s' a + w x (I w + J s a) = torque;  J (s' + a . w') = tau
            left = np.block([[I, J * a[:, None]], [J * a, J]])
            momentum = I @ omega + J * s * a
            rates = np.linalg.solve(left, np.append(torque - np.cross(omega, momentum), tau))
        else:
            momentum = I @ omega + rotor.momentum * a
            rates = np.append(np.linalg.solve(I, torque - np.cross(omega, momentum)), 0.0)
        x, y_, z, w = y[:4]
        q_dot = (
            0.5
            * np.array(
                [
                    [w, -z, y_],
                    [z, w, -x],
                    [-y_, x, w],
                    [-x, -y_, -z],
                ]
            )
            @ omega
        )
        return [*q_dot, *rates, s if rotor.turns_freely else 0.0]

    speed, angle = np.nan_to_num([start.rotor_speed[0], start.rotor_angle[0]])
    y_0 = [*start.q_ib, *start.omega_bi_b, speed, angle]
    truth = solve_ivp(equations, (0.0, duration_s), y_0, 'DOP853', rtol=3e-14, atol=1e-15).y[:, -1]
    states = Propagation(system, start, tolerance=1e-13).at([duration_s])
    # Both integrate at 1e-13 or so; 1e-10 leaves their errors room to add up over ten radians.
    assert rotation.angle_between(states.q_ib[0], rotation.normalise(truth[:4])) < 1e-10
    np.testing.assert_allclose(states.omega_bi_b[0], truth[4:7], rtol=1e-9)
    if rotor.turns_freely:
        np.testing.assert_allclose(states.rotor_speed[0], truth[7], rtol=1e-11)
        np.testing.assert_allclose(states.rotor_angle[0], truth[8], rtol=1e-11)


@pytest.mark.parametrize('name', EACH_SYSTEM)
def test_first_integrals_stay(name):
    """Each first integral that a system is said to have keeps its value along the propagation."""
    system = SYSTEMS[name]
    start, duration_s = _start(system)
    states = Propagation(system, start, tolerance=1e-13).at(np.linspace(0, duration_s, 101))
    drift = relative_drift(system, states)
    assert drift
    for integral, values in drift.items():
        # Between steps the dense output, of lower order, costs up to some hundred tolerances.
        assert np.max(np.abs(values)) < 3e-11, integral


@pytest.mark.parametrize('name', EACH_SYSTEM)
def test_row_depends_on_its_time_alone(name):
    """A state has the same bits alone, in any order and among thousands."""
    system = SYSTEMS[name]
    start, duration_s = _start(system)
    t_s = np.linspace(0.0, duration_s, 1001)
    table = Propagation(system, start).at(t_s)
    shuffled = np.random.default_rng(7).permutation(len(t_s))
    other = Propagation(system, start).at(t_s[shuffled])
    motion = Propagation(system, start)
    for column in (
        'q_ib',
        'omega_bi_b',
        'rotor_speed',
        'rotor_angle',
        'work',
        'r_i',
        'v_i',
        'c_b',
    ):
        np.testing.assert_array_equal(getattr(table, column)[shuffled], getattr(other, column))
        for i in (0, 1, 500, 333, 1000):
            alone = getattr(motion.at(t_s[i]), column)[0]
            np.testing.assert_array_equal(alone, getattr(table, column)[i], err_msg=column)


def test_start_is_kept_to_the_bit():
    """At t = 0 stands exactly what was asked for, whatever the body's axes."""
    system = SYSTEMS['circular gyrostat']
    start, _ = _start(system)
    states = Propagation(system, start).at(0.0)
    assert np.array_equal(states.q_ib[0], start.q_ib)
    assert np.array_equal(states.omega_bi_b[0], start.omega_bi_b)


@pytest.mark.long
@pytest.mark.parametrize('start_s', [0.0, 12345.0])
def test_axes_do_not_show(start_s):
    """The motion on a circle is that on an ellipse without a difference, in axes that stay."""
    circle = SYSTEMS['circular gyrostat']
    assert isinstance(circle.orbit, KeplerOrbit)
    ellipse = replace(circle, orbit=replace(circle.orbit, eccentricity=1e-18))
    start, duration_s = _start(circle)
    t_s = np.linspace(0.0, duration_s, 101)
    ours, theirs = (Propagation(system, start, start_s).at(t_s) for system in (circle, ellipse))
    # The steps of each may be off by some tolerances.
    assert rotation.angle_between(ours.q_ib, theirs.q_ib).max() < 1e-11
    np.testing.assert_allclose(ours.omega_bi_b, theirs.omega_bi_b, atol=1e-13)


def test_order_of_convergence():
    """The error falls with the eighth power of the step, the order of the method, or faster."""
    system = SYSTEMS['circular gyrostat']
    start, duration_s = _start(system)
    truth = Propagation(system, start, tolerance=1e-15).at(duration_s)

    def error_and_steps(tolerance):
        motion = Propagation(system, start, tolerance=tolerance)
        error = rotation.angle_between(motion.at(duration_s).q_ib[0], truth.q_ib[0])
        return error, motion.steps

    (error_1, steps_1), (error_2, steps_2) = error_and_steps(1e-5), error_and_steps(1e-10)
    # Step control leaves the exponent some per cent of scatter.
    assert np.log(error_1 / error_2) / np.log(steps_2 / steps_1) > 7.8


def test_coefficients_are_those_of_scipy():
    """What is packed, unpacked: each number at its index, of stages, errors and dense output."""
    rows = np.zeros((len(tableau.LENGTHS), 16))
    for row, length, columns, entries in zip(
        rows, tableau.LENGTHS, tableau.COLUMNS, tableau.ENTRIES, strict=True
    ):
        row[columns[:length]] = entries[:length]
    np.testing.assert_array_equal(rows[:12, :12], DOP853.A)
    np.testing.assert_array_equal(rows[12, :12], DOP853.B)
    np.testing.assert_array_equal(rows[13:16], DOP853.A_EXTRA)
    np.testing.assert_array_equal(rows[tableau.ERROR_3, :13], DOP853.E3)
    np.testing.assert_array_equal(rows[tableau.ERROR_5, :13], DOP853.E5)
    np.testing.assert_array_equal(rows[tableau.DENSE : tableau.DENSE + 4], DOP853.D)
    assert not np.any(rows[:13, 12:])
    assert not np.any(rows[[tableau.ERROR_3, tableau.ERROR_5], 13:])


@pytest.mark.parametrize('angle', [0.2, 0.5, 1.0, 2.0, 4.0])
def test_what_a_step_makes_of_its_estimate(angle):
    """In y' = i y it errs by less than half of it, its interpolation by less than 3.2 times."""

    def combined(row):
        n = tableau.LENGTHS[row]
        return tableau.ENTRIES[row, :n] @ k[tableau.COLUMNS[row, :n]]

    k, y = np.zeros(16, complex), 1.0
    for i in range(12):
        k[i] = 1j * angle * y
        y = 1.0 + combined(i + 1)
    k[12] = 1j * angle * y
    for i in range(13, 16):
        k[i] = 1j * angle * (1.0 + combined(i))
    e_3, e_5 = abs(combined(tableau.ERROR_3)), abs(combined(tableau.ERROR_5))
    estimate = e_5**2 / np.sqrt(e_5**2 + 0.01 * e_3**2)
    assert abs(y - np.exp(1j * angle)) < 0.5 * estimate
    x, rise = np.linspace(0.0, 1.0, 101), y - 1.0
    terms = [rise, k[0] - rise, 2.0 * rise - k[0] - k[12]]
    terms += [combined(tableau.DENSE + n) for n in range(4)]
    between = 0.0
    for n, term in reversed(list(enumerate(terms))):
        between = (term + between) * ((1.0 - x) if n % 2 else x)
    assert 2.5 < np.max(np.abs(1.0 + between - np.exp(1j * angle * x))) / estimate < 3.2


@pytest.mark.parametrize('t_s', [-1.0, np.nan, np.inf])
def test_times_that_are_none(t_s):
    """A time before the start, or none at all, is refused in one sentence."""
    system = SYSTEMS['heavy top']
    with pytest.raises(ValueError, match='it must be finite and at least 0 s'):
        Propagation(system, _start(system)[0]).at([0.0, t_s])


def test_rest_costs_few_steps():
    """A body at rest in an equilibrium, where torques are rounding, is not followed in detail."""
    system = System(np.diag([1.0, 1.5, 2.0]), orbit=FixedDirection(1.0))
    tilted = rotation.normalise([1e-17, 0.5, 1e-17, 0.5])
    motion = Propagation(system, State(tilted, np.zeros(3)), tolerance=1e-14)
    motion.at(2000.0)
    # The field swings a body by a radian in about a second; each step is a good part of that.
    assert motion.steps < 20000


def test_a_rate_whose_square_is_zero_counts_as_rest():
    """Errors are not relative to it, or a step would be as much shorter than a second."""
    rotor = Rotor('free', axis=np.array([0.0, 0.0, 1.0]), inertia=0.1)
    start = State(
        np.array([0.0, 0.0, 0.0, 1.0]),
        np.array([1e-179, 2e-180, -3e-179]),
        np.array([0.4]),
        np.array([0.0]),
    )
    motion = Propagation(System(np.diag([2.0, 1.5, 1.0]), (rotor,)), start, most_steps=1000)
    assert motion.at(1000.0)[0].omega_bi_b == pytest.approx(start.omega_bi_b, abs=1e-150)


@pytest.mark.parametrize('seed', range(4))
def test_a_step_that_overflows_is_none(seed):
    """
    A first step of millions of seconds, for a body nearly at rest, never counts as exact.

    With rates of 1e155 on the way, one estimate of its error overflowed alone, and their quotient
    was 0.  The truth is the energy of each of 500 starts a hair from rest.
    """
    random = np.random.default_rng(seed)
    for _ in range(500):
        I = random.uniform(0.4, 0.6, 3)
        rotor = Rotor('constant_momentum', np.array([0.0, 0.0, 1.0]), random.uniform(0.0, 2.0))
        system = System(np.diag(I), (rotor,), FixedDirection(-1.0))
        q_ib = rotation.normalise(random.normal(size=4))
        state = State(q_ib, 1e-9 * random.normal(size=3))
        states = Propagation(system, state).at([0.0, 1.0])
        energy = first_integrals(system, states)['energy']
        np.testing.assert_allclose(energy[1], energy[0], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize('copied', [copy.copy, copy.deepcopy])
def test_a_copy_goes_its_own_way(copied):
    """Neither moves the other, whatever was asked for before, in whatever order."""
    state = State(rotation.IDENTITY, np.array([0.1, 0.2, 0.3]))
    motion = Propagation(System(np.diag([3.0, 2.0, 4.0])), state)
    right = Propagation(motion.system, state).at([50.0, 100.0]).q_ib
    motion.at(50.0)
    other = copied(motion)
    np.testing.assert_array_equal(other.at(100.0).q_ib[0], right[1])
    np.testing.assert_array_equal(motion.at(100.0).q_ib[0], right[1])
    np.testing.assert_array_equal(other.at(50.0).q_ib[0], right[0])
