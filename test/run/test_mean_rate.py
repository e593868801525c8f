"""An integrating gyro of a run reads the integral of the rate over its interval, divided by it."""

import numpy as np
import pytest
from cases import bounded, newtonian
from commands import motor_command, torque_command
from scipy.integrate import quad
from scipy.spatial.transform import Rotation

from satdyn_ros import exact
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.run.events import Event, Reset
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import Simulation

FREE = {
    'publish.rate': 1.0,
    'time.epoch_ns': 10**9,
    'orbit.type': 'fixed',
    'initial.frame': 'inertial',
    'sensors.names': ['gyro'],
    'sensors.seed': 3,
    'sensors.gyro.integrating': True,
}
METHODS = pytest.mark.parametrize('method', ['numeric', 'exact'])


def read(simulation, ticks, block):
    """Return what the gyro reads in so many ticks, asked for in blocks, (M, 3)."""
    values = []
    while simulation.next_tick < ticks:
        _, samples = simulation.advance(min(block, ticks - simulation.next_tick))
        values.append(samples.measured['gyro'].values)
    return np.concatenate(values)


@METHODS
def test_more_than_half_a_turn_a_sample(method):
    """At 4 rad/s about an axis it reads 4 rad/s once a second, not what is left of a turn."""
    given = {'initial.angular_velocity': [0.0, 0.0, 4.0], 'motion.method': method}
    found = read(Simulation(Scenario(FREE | given)), 20, 20)
    np.testing.assert_allclose(found, [[0.0, 0.0, 4.0]] * 20, rtol=0.0, atol=1e-13)


@METHODS
def test_coning_has_the_integral_of_the_textbook(method):
    """
    A free body symmetric about z: omega turns about z at (C - A) / A omega_z, in body axes.

    Its integral is known.  The rotation vector over the interval is another vector.
    """
    A, C, (x, y, z) = 2.0, 3.0, (0.5, 0.2, 1.0)
    given = {'body.inertia': [A, A, C], 'initial.angular_velocity': [x, y, z]}
    simulation = Simulation(Scenario(FREE | given | {'motion.method': method}))
    found = read(simulation, 40, 40)
    n = (C - A) / A * z
    cosine, sine = np.cos(n * np.arange(40)), np.sin(n * np.arange(40))
    turned = np.array([x * sine + y * cosine, y * sine - x * cosine, n * z * np.arange(40)]).T / n
    np.testing.assert_allclose(found[1:], np.diff(turned, axis=0), rtol=0.0, atol=1e-12)
    q_ib = simulation.motion.at(np.arange(2.0)).q_ib
    vector = (Rotation.from_quat(q_ib[0]).inv() * Rotation.from_quat(q_ib[1])).as_rotvec()
    assert np.linalg.norm(found[1] - vector) > 0.01


def by_quad(motion, begin_s, end_s):
    """Return the integral of the rate that a motion answers, (3,)."""

    def rate(t, axis):
        return motion.at(t).omega_bi_b[0, axis]

    return [
        quad(rate, begin_s, end_s, (axis,), epsabs=0.0, epsrel=1e-13, limit=200)[0]
        for axis in range(3)
    ]


@pytest.mark.filterwarnings('ignore::scipy.integrate.IntegrationWarning')
@pytest.mark.parametrize('name', bounded(newtonian(), 'bound_exact'))
def test_closed_forms_against_quadrature_of_what_they_answer(name):
    """By SciPy's adaptive quadrature, over a short interval and one of a turn and a half."""
    case = newtonian()[name]
    motion = exact.recognise(case.system, case.start)
    assert motion is not None
    rate = np.linalg.norm(case.start.omega_bi_b)
    t_s = np.array([0.3, 0.31, 10.0]) / rate
    states = motion.counting_at(t_s)
    assert states.turn_b is not None
    for i in (1, 2):
        expected = by_quad(motion, t_s[i - 1], t_s[i])
        turn = rate * (t_s[i] - t_s[i - 1])
        np.testing.assert_allclose(states.turn_b[i], expected, rtol=0.0, atol=1e-12 * turn)


@pytest.mark.filterwarnings('ignore::scipy.integrate.IntegrationWarning')
def test_a_propagation_against_quadrature_of_what_it_answers():
    """By SciPy's, over intervals within a step and of many; its states are what at() answers."""
    case = newtonian()['X5_circular_tumbling_1degps_3orbits']
    motion, again = (Propagation(case.system, case.start) for _ in range(2))
    rate = np.linalg.norm(case.start.omega_bi_b)
    t_s = np.cumsum([0.3, 0.01, 0.02, 9.0, 0.5]) / rate
    states = motion.counting_at(t_s)
    assert states.turn_b is not None
    np.testing.assert_array_equal(states.omega_bi_b, again.at(t_s).omega_bi_b)
    for i in range(1, len(t_s)):
        expected = by_quad(again, t_s[i - 1], t_s[i])
        turn = rate * (t_s[i] - t_s[i - 1])
        np.testing.assert_allclose(states.turn_b[i], expected, rtol=0.0, atol=1e-12 * turn)


# What acts at ticks that are not samples, and a wheel that a motor drives.
DRIVEN = FREE | {
    'body.inertia': [0.02, 0.03, 0.04],
    'rotor.mode': 'motor',
    'rotor.inertia': 1e-3,
    'initial.angular_velocity': [0.7, -0.2, 4.0],
    'sensors.gyro.divisor': 4,
    'sensors.gyro.bias_random_walk': 1e-5,
    'sensors.gyro.noise_density': 1e-4,
    'motion.method': 'auto',
}
EVENTS: list[Event] = [
    torque_command(5, (0.01, 0.0, 0.0), 7),
    motor_command(9, {'rotor': 0.002}, 14),
    torque_command(14, (0.0, 0.02, 0.0), 16),
    Reset(22),
    torque_command(30, (0.0, 0.02, -0.01), 39),
]


def test_torques_within_an_interval():
    """A sample is the sum over the motions in its interval; after a reset the rate at its tick."""
    quiet = {'sensors.gyro.bias_random_walk': 0.0, 'sensors.gyro.noise_density': 0.0}
    simulation = Simulation(Scenario(DRIVEN | quiet), EVENTS)
    nodes, weights = np.polynomial.legendre.leggauss(40)
    sums, turned, found = [], np.zeros(3), []
    for tick in range(44):
        _, samples = simulation.advance(1)
        found += samples.measured['gyro'].values.tolist()
        if tick % 4 == 0:
            sums.append(turned / 4.0)
            turned = np.zeros(3)
        motion = simulation.motion
        t_s = tick - motion.start_s + (nodes + 1.0) / 2.0
        flown = type(motion)(motion.system, motion.state, motion.start_s)
        turned = turned + weights / 2.0 @ flown.at(t_s).omega_bi_b
    first, after_reset = 0, 24 // 4
    for sample in range(len(found)):
        if sample in (first, after_reset):
            assert np.abs(np.subtract(found[sample], sums[sample])).max() > 0.01
        else:
            np.testing.assert_allclose(found[sample], sums[sample], rtol=0.0, atol=1e-12)
    assert len(found) == 11


def test_blocks_do_not_show():
    """Tick by tick, in any blocks, taken back, or from a snapshot of any tick: the same bits."""
    scenario = Scenario(DRIVEN)
    whole = read(Simulation(scenario, EVENTS), 44, 44)
    for block in (1, 3, 13):
        assert np.array_equal(read(Simulation(scenario, EVENTS), 44, block), whole)
    run = Simulation(scenario, EVENTS)
    while run.next_tick < 43:
        tick = run.next_tick
        run.advance(5)
        snapshot = run.snapshot(tick)
        later = [event for event in EVENTS if event.tick > tick]
        rest = read(Simulation.from_snapshot(scenario, snapshot, later), 44, 44)
        assert np.array_equal(rest, whole[len(whole) - len(rest) :]), tick
        run.rewind(tick + 1)
