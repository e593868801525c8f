"""Free rotation in closed form against 28-digit states, published periods and propagation."""

import numpy as np
import pytest
from agreement import assert_agrees
from cases import rigid
from hypothesis import given, settings
from hypothesis import strategies as st

from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.exact import recognise
from satdyn_ros.exact.free import Free
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import FixedDirection, KeplerOrbit

SOME = rotation.normalise([0.2, -0.4, 0.3, 0.8])
TIMES_S = np.array([0.0, 1.0, 30.0, 100.0, 300.0, 1e4])
CASES = {name: case for name, case in rigid().items() if name.startswith(('free', 'gyrostat'))}


@pytest.mark.parametrize('name', CASES)
def test_reference_case(name):
    """Each case stays within its bound in attitude and ten times it, relative, in rate."""
    case = CASES[name]
    states = Free(case.system, case.start).at(case.t_s)
    assert rotation.angle_between(states.q_ib, case.q_ib).max() < case.bound_exact
    rate = np.linalg.norm(case.omega_bi_b, axis=1).max()
    error = np.linalg.norm(states.omega_bi_b - case.omega_bi_b, axis=1).max()
    assert error < 10.0 * case.bound_exact * rate


@pytest.mark.parametrize('name', [name for name, c in CASES.items() if 'T2' in c.raw['derived']])
def test_periods(name):
    """T1, T2 and chi0 of (46.11) are those that 28-digit quadrature gives."""
    case, derived = CASES[name], CASES[name].raw['derived']
    motion = Free(case.system, case.start)
    # The near-separatrix case knows its distance from it to twelve digits.
    for key in ('T1', 'T2', 'chi0'):
        assert getattr(motion, key) == pytest.approx(float(derived[key]), rel=2e-12)


def test_rates_return_after_their_period():
    """After period_s the body rates are what they were, with and without a rotor."""
    for name in ('free_tri_e3_family', 'gyrostat_tri_rotor_axis3', 'gyrostat_tri_rotor_mid_axis2'):
        case = CASES[name]
        motion = Free(case.system, case.start)
        assert motion.period_s is not None
        states = motion.at([0.0, motion.period_s, motion.period_s / 2.0])
        np.testing.assert_allclose(states.omega_bi_b[1], states.omega_bi_b[0], atol=1e-12)
        assert np.max(np.abs(states.omega_bi_b[2] - states.omega_bi_b[0])) > 1e-3


def test_three_motions():
    """Taking out the mean precession and spin leaves an attitude with the period of the rates."""
    case = CASES['free_tri_e3_family']
    motion = Free(case.system, case.start)
    t_s = np.linspace(1.0, 5.0, 9)

    def rest(t_s):
        states = motion.at(t_s)
        momentum = rotation.rotate(states.q_ib, states.omega_bi_b @ case.system.inertia)
        axis = momentum[0] / np.linalg.norm(momentum[0])
        precession = rotation.about(axis, -motion.Om_P * t_s)
        spin = rotation.about([0.0, 0.0, 1.0], -motion.Om_S * t_s)
        return rotation.multiply(rotation.multiply(precession, states.q_ib), spin)

    # T1 / 2 already brings nutation and phases back.
    apart = rotation.angle_between(rest(t_s), rest(t_s + motion.T1 / 2.0))
    assert apart.max() < 1e-13


@pytest.mark.parametrize('aside', [0.0, 1e-17, 1e-15, 1e-12])
@pytest.mark.parametrize('first', [(0, 1, 2), (1, 2, 0), (2, 0, 1)])
def test_about_the_middle_axis(first, aside):
    """Proves that momentum and energy stay next to the saddle, whatever rounding makes of it."""
    order = list(first)
    for turn in ([0.0, 0.0, 0.0], [0.0, 0.0, 0.5], [0.2, -0.3, 0.9]):
        R = rotation.matrix(rotation.normalise([*turn, 1.0]))
        inertia = R @ np.diag(np.array([1.3, 1.5, 2.1])[order]) @ R.T
        omega = R @ np.array([aside, 1.0, aside**2])[order]
        states = Free(System(inertia, orbit=FixedDirection()), State(SOME, omega)).at(TIMES_S)
        H = rotation.rotate(states.q_ib, states.omega_bi_b @ inertia)
        np.testing.assert_allclose(H, np.tile(H[0], (len(TIMES_S), 1)), atol=1e-12)
        energies = np.sum(states.omega_bi_b @ inertia * states.omega_bi_b, axis=1)
        # the spin at a flip has the digits of the start's departure, 1e-16 of 1e-12
        np.testing.assert_allclose(energies, 1.5, rtol=1e-3 if aside == 1e-12 else 1e-12)


@pytest.mark.parametrize(('sign_1', 'sign_3'), [(1, 1), (-1, 1), (1, -1), (-1, -1)])
def test_along_the_separatrix(sign_1, sign_3):
    """
    Proves O_1, O_3 ~ sech(k t) and O_2 ~ tanh(k t) from their turning point, then the saddle.

    L^2 = 2 E I2 to the last digit: u has a double root between the ends of its range.
    """
    I1, I2, I3 = I = np.array([0.875, 0.9, 1.5])
    O1, O3 = 0.3 * sign_1, 0.3 * np.sqrt(I1 * (I2 - I1) / (I3 * (I3 - I2))) * sign_3
    motion = Free(System(np.diag(I), orbit=FixedDirection()), State(SOME, np.array([O1, 0, O3])))
    assert motion.period_s is None
    O2 = np.sign(O1 * O3) * np.sqrt((I1 * O1**2 + I3 * O3**2) / I2)
    k = abs((I3 - I1) / I2 * O1 * O3 / O2)
    t_s = np.array([0.0, 0.5, 2.0, 5.0, 60.0]) / k
    truth = np.stack([O1 / np.cosh(k * t_s), O2 * np.tanh(k * t_s), O3 / np.cosh(k * t_s)], axis=1)
    states = motion.at(t_s)
    np.testing.assert_allclose(states.omega_bi_b, truth, atol=1e-15)
    numeric = Propagation(motion.system, motion.state, 0.0, 1e-14).at(t_s[:4])
    # rounding of the start, 1e-16, has grown by exp(5)
    assert np.max(rotation.angle_between(states.q_ib[:4], numeric.q_ib)) <= 1e-12
    # the integral of u is what a rotor about that axis would count: sech again, k t within pi/2
    swept = motion.flow.nutation.integral(t_s)
    axis = np.argmax(np.abs(motion._R_bp[:, 2]))
    gd = (I * [O1, 0.0, O3])[axis] / motion.L / k * np.arctan(np.sinh(np.minimum(k * t_s, 40.0)))
    np.testing.assert_allclose(np.abs(swept), np.abs(gd), rtol=1e-12)


@st.composite
def scenarios(draw):
    """Draw a body of any order of moments, axes and rotor, and a start in any regime."""
    number = st.floats(-1.0, 1.0).map(lambda x: round(x, 4))
    low, high = draw(st.floats(0.3, 1.0)), draw(st.floats(1.0, 2.0))
    third = draw(
        st.sampled_from([low, high, 1.0 + 1e-6]) | st.floats(high - low + 0.1, low + high)
    )
    moments = np.array(draw(st.permutations([low, high, third])))
    total = np.sum(moments) / 2.0
    if np.max(moments) >= total:
        moments = moments + (2.0 * np.max(moments) - 2.0 * total) + 0.1
    q_bp = rotation.normalise([draw(number), draw(number), draw(number), 1.0])
    R = rotation.matrix(q_bp) if draw(st.booleans()) else np.eye(3)
    axis = R[:, draw(st.integers(0, 2))]
    mode = draw(st.sampled_from(['none', 'constant_momentum', 'free']))
    rotor = {
        'none': Rotor(),
        'constant_momentum': Rotor('constant_momentum', axis, momentum=3.0 * draw(number)),
        'free': Rotor('free', axis, inertia=0.05),
    }[mode]
    omega = np.array([draw(number), draw(number), draw(number)])
    q_ib = rotation.normalise([draw(number), draw(number), draw(number), 1.0])
    speed = 20.0 * draw(number) if mode == 'free' else np.nan
    system = System(R @ np.diag(moments) @ R.T, (rotor,), FixedDirection())
    return system, State(q_ib, R @ omega, speed, 0.0 if mode == 'free' else np.nan)


@pytest.mark.long
@settings(max_examples=200)
@given(scenarios())
def test_agrees_with_propagation(scenario):
    """200 drawn bodies and gyrostats in every regime, over ten periods of the rates."""
    system, start = scenario
    rate = np.linalg.norm(start.omega_bi_b)
    if rate < 1e-3 or Free.why_not(system, start):
        return
    motion = Free(system, start)
    span_s = 10.0 * min(motion.period_s or np.inf, 100.0 / rate)
    assert_agrees(motion, np.linspace(0.0, span_s, 41), rate)


@pytest.mark.long
def test_a_sphere_in_orbit_is_free():
    """The gravity gradient does nothing to a sphere, which is recognised with its rotor."""
    rotor = Rotor('free', np.array([0.6, 0.0, 0.8]), inertia=2.0)
    system = System(50.0 * np.eye(3), (rotor,), KeplerOrbit(eccentricity=0.2))
    start = State(rotation.IDENTITY, np.array([0.1, 0.2, -0.1]), 5.0, 0.3)
    motion = recognise(system, start, 100.0)
    assert isinstance(motion, Free)
    t_s = np.linspace(0.0, 200.0, 21)
    truth, states = Propagation(system, start, 100.0, 1e-14).at(t_s), motion.at(t_s)
    assert rotation.angle_between(states.q_ib, truth.q_ib).max() < 1e-11
    np.testing.assert_allclose(states.rotor_angle, truth.rotor_angle, atol=1e-9)


@pytest.mark.parametrize(
    ('change', 'sentence'),
    [
        ({'torque_b': np.array([0.0, 0.0, 1.0])}, 'a torque is applied'),
        ({'weight_moment': np.array([0.0, 0.0, 1.0])}, 'body.weight_moment is not zero'),
        ({'orbit': FixedDirection(1.0)}, 'the gravity gradient acts on the body'),
        ({'orbit': KeplerOrbit()}, 'the gravity gradient acts on the body'),
        (
            {'rotors': (Rotor('constant_momentum', np.array([0.6, 0.8, 0.0]), momentum=1.0),)},
            'rotor.axis is not a principal axis',
        ),
    ],
)
def test_refused(change, sentence):
    """What is not free rotation is refused with its reason."""
    system = System(**{'inertia': np.diag([1.0, 2.0, 2.5])} | change)
    start = State(rotation.IDENTITY, np.array([0.1, 0.2, 0.3]))
    assert sentence in (Free.why_not(system, start) or '')
    with pytest.raises(ValueError, match=sentence):
        Free(system, start)


def test_a_book_on_its_middle_axis_needs_a_push():
    """
    Exactly about the middle axis the body spins on for ever; a push of a tenth turns it later.

    A quarter of T1, in which it turns over, grows by ln 10 over the rate at which small departures
    grow, 0.151 rad/s: what docs/how-to/teach.md says.
    """
    body = System(np.diag([600.0, 900.0, 1100.0]))
    exactly = Free(body, State(rotation.IDENTITY, np.array([0.0, 0.5, 0.0])))
    np.testing.assert_allclose(exactly.at([1e4]).omega_bi_b, [[0.0, 0.5, 0.0]], atol=1e-15)
    pushed = [
        Free(body, State(rotation.IDENTITY, np.array([push, 0.5, 0.0]))) for push in (1e-6, 1e-7)
    ]
    over = pushed[0].at(pushed[0].T1 / 2.0).omega_bi_b[0]
    assert over[1] == pytest.approx(-0.5, rel=1e-9)
    growth = 0.5 * np.sqrt(300.0 * 200.0 / (600.0 * 1100.0))
    assert growth == pytest.approx(0.151, abs=5e-4)
    later = (pushed[1].T1 - pushed[0].T1) / 4.0
    assert later == pytest.approx(np.log(10.0) / growth, rel=1e-9)
