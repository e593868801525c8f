"""Motions for which tables say what depends on time alone: the orbit, the field along it."""

import numpy as np
import plain_equations
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from satdyn_ros import exact
from satdyn_ros.dynamics.integrals import relative_drift
from satdyn_ros.dynamics.motion import Halted, States
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.integrate.batch import propagate_all
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import KeplerOrbit, TabledOrbit
from satdyn_ros.orbits.j2 import OblateOrbit
from satdyn_ros.orbits.pieces import Stretch, fitted
from satdyn_ros.orbits.tabled import OrbitSource

KEPLER = KeplerOrbit(eccentricity=0.05, inclination=0.9, raan=0.3, true_anomaly=2.0)
# Of the Earth, times ten: the plane turns by degrees.
OBLATE = TabledOrbit(OblateOrbit(KEPLER, 0.0108))
INERTIA = np.diag([900.0, 800.0, 600.0])
STATE = State(rotation.normalise([0.4, 0.4, 0.8, 0.2]), np.array([1e-3, 2e-3, -1.5e-3]))
# An orbit and a half: twenty pieces.
T_S = np.linspace(0.0, 8600.0, 173)


class Ending(OblateOrbit):
    """An orbit that is known for a while."""

    @property
    def stretches(self):
        (stretch,) = super().stretches
        return (Stretch(0.0, stretch.length_s, 0.0, 3.0 * stretch.length_s),)

    def outside(self, t_s):
        return f'nothing is known of {t_s:g} s'


# Another ellipse takes over at this time, until another.
AFTER = KeplerOrbit(eccentricity=0.05, inclination=0.9, raan=0.3001, true_anomaly=2.0)
AT_S, UNTIL_S = 2000.0, 4000.0


class Meeting(OrbitSource):
    """Two ellipses, each known for a while."""

    stretches = (Stretch(0.0, 250.0, 0.0, AT_S), Stretch(AT_S, 250.0, AT_S, UNTIL_S))

    def coefficients(self, piece):
        ellipse = AFTER if piece.begin_s >= AT_S else KEPLER
        return fitted(lambda t_s: ellipse.position_velocity(t_s)[0])(piece)


def system(orbit=OBLATE):
    return System(INERTIA, orbit=orbit)


def flown(motion, t_s=T_S):
    return np.hstack([motion.at(t_s).q_ib, motion.at(t_s).omega_bi_b])


def test_an_ellipse_from_a_table_is_flown_as_the_ellipse():
    """To the tolerance: attitude, rate and the work of the orbit."""
    table = Propagation(system(TabledOrbit(OblateOrbit(KEPLER, 0.0))), STATE).at(T_S)
    ellipse = Propagation(system(KEPLER), STATE).at(T_S)
    for name in ('q_ib', 'omega_bi_b', 'work'):
        expected = getattr(ellipse, name)
        size = np.max(np.abs(expected))
        assert_allclose(getattr(table, name), expected, rtol=0.0, atol=2e-11 * size, err_msg=name)


def test_agrees_with_another_integrator_of_the_plain_equations():
    """Attitude and work on an orbit whose plane turns, against SciPy's DOP853."""

    def slope(t, y):
        q_ib = rotation.normalise(y[:4])
        found = plain_equations.rates(system(), t, q_ib, y[4:7], np.zeros(0))
        return [*found.q_ib, *found.omega_bi_b, found.work]

    t_s = T_S[T_S <= 2000.0]
    y = [*STATE.q_ib, *STATE.omega_bi_b, 0.0]
    # SciPy's steps do not end where pieces do, across which r'' jumps by rounding alone.
    expected = solve_ivp(slope, (0.0, t_s[-1]), y, 'DOP853', t_s, rtol=1e-12, atol=1e-14).y
    found = Propagation(system(), STATE).at(t_s)
    assert np.max(rotation.angle_between(found.q_ib, rotation.normalise(expected[:4].T))) < 1e-10
    assert_allclose(found.work, expected[7], rtol=0.0, atol=1e-10 * np.max(np.abs(expected[7])))


def test_the_balance_of_energy_holds():
    """The orbit's work is counted, of a plane that turns too."""
    states = Propagation(system(), STATE).at(T_S)
    assert np.max(np.abs(relative_drift(system(), states)['energy_balance'])) < 1e-12


def test_where_an_orbit_jumps_the_orbit_does_the_work():
    """
    Two ellipses of which one takes over from the other, a row at that time and others around it.

    The balance of energy closes, forwards, from behind and up to a halt; the work has the jump of
    the potential (3 mu / 2 r^3) c . I c, worked out here, and 3e-5 of it are the microsecond.
    """
    orbit = TabledOrbit(Meeting())
    jumping = System(INERTIA, orbit=orbit)
    motion = Propagation(jumping, STATE)
    t_s = np.union1d(T_S[T_S < 3900.0], [AT_S - 1e-6, AT_S])
    states = motion.at(t_s)
    assert np.max(np.abs(relative_drift(jumping, states)['energy_balance'])) < 1e-12
    np.testing.assert_array_equal(motion.at(t_s[::-1]).work[::-1], states.work)
    at = int(np.searchsorted(t_s, AT_S))
    potentials = []
    for ellipse in (KEPLER, AFTER):
        r_b = rotation.rotate(
            rotation.conjugate(states.q_ib[at]), ellipse.position_velocity(AT_S)[0]
        )
        potentials.append(1.5 * ellipse.mu * (r_b @ INERTIA @ r_b) / np.linalg.norm(r_b) ** 5)
    jump = potentials[1] - potentials[0]
    assert_allclose(states.work[at] - states.work[at - 1], jump, rtol=1e-4, atol=0.0)
    with pytest.raises(Halted) as halted:
        motion.at(T_S)
    found = halted.value.states
    assert np.max(np.abs(relative_drift(jumping, found)['energy_balance'])) < 1e-12


def test_states_do_not_depend_on_what_was_asked_before():
    """Bit by bit: row by row, from behind, and all at once."""
    once = flown(Propagation(system(), STATE))
    motion = Propagation(system(), STATE)
    one_by_one = np.vstack([flown(motion, T_S[k : k + 1]) for k in range(len(T_S))])
    np.testing.assert_array_equal(one_by_one, once)
    np.testing.assert_array_equal(flown(motion, T_S[::-1])[::-1], once)


def test_goes_on_from_a_state_on_the_way():
    """At any time from tick 0, not only where a piece begins."""
    states = Propagation(system(), STATE).at(T_S)
    later = Propagation(system(), states[80], T_S[80])
    rest = later.at(T_S[80:] - T_S[80])
    assert np.max(rotation.angle_between(rest.q_ib, states.q_ib[80:])) < 1e-11


def test_batch_is_the_motions_one_by_one():
    """Motions that start at different times have parts of the same table."""
    motions = [
        Propagation(system(), State(STATE.q_ib, k * STATE.omega_bi_b), start_s)
        for k, start_s in ((0.5, 0.0), (1.0, 0.0), (1.5, 1234.5))
    ]
    for motion, states in zip(motions, propagate_all(motions, T_S), strict=True):
        assert isinstance(states, States)
        assert np.max(rotation.angle_between(states.q_ib, motion.at(T_S).q_ib)) < 1e-11


def test_comes_to_a_halt_where_the_table_ends():
    """With the table's own sentence, and the rows before, alone and in a batch."""
    orbit = TabledOrbit(Ending(KEPLER, 0.0108))
    end_s = orbit.pieces.stretches[0].end_s
    motion = Propagation(system(orbit), STATE)
    with pytest.raises(Halted, match=f'nothing is known of {end_s:g} s') as halted:
        motion.at(T_S)
    count = np.searchsorted(T_S, end_s, side='right')
    assert halted.value.reached_s == end_s
    expected = flown(Propagation(system(), STATE), T_S[:count])
    states = halted.value.states
    np.testing.assert_array_equal(np.hstack([states.q_ib, states.omega_bi_b]), expected)
    (together,) = propagate_all([motion], T_S)
    assert str(together) == str(halted.value)
    assert motion.at(end_s).q_ib.shape == (1, 4)


def test_no_closed_form_of_a_body_that_the_field_turns():
    """The reason is said; a body of three equal moments has one."""
    assert exact.recognise(system(), STATE) is None
    assert 'the orbit is not a circle' in str(exact.explain(system(), STATE))
    sphere = System(np.diag([3.0, 3.0, 3.0]), orbit=OBLATE)
    motion = exact.recognise(sphere, STATE)
    assert motion is not None
    states = Propagation(sphere, STATE).at(T_S)
    assert np.max(rotation.angle_between(states.q_ib, motion.at(T_S).q_ib)) < 1e-12
