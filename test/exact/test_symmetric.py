"""The symmetric body against 30-digit integrations, published numbers and propagation."""

import numpy as np
import pytest
from agreement import assert_agrees
from cases import bounded, newtonian, rigid
from draws import attitudes, body_axes, inertia_in_body_axes, powers_of_ten, signs
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from satdyn_ros.dynamics import rotation
from satdyn_ros.dynamics.orbit import FixedDirection
from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.exact.symmetric import Symmetric

OTHERS = ('B1', 'B2', 'B6', 'B8')
CASES = {
    name: case
    for cases in (rigid(), newtonian())
    for name, case in ((name, cases[name]) for name in bounded(cases, 'bound_exact'))
    if name.startswith(('pal1', 'B', 'A5', 'free_axi', 'free_spherical', 'gyrostat_axi'))
    and name.split('_')[0] not in OTHERS
}
Z = np.array([0.0, 0.0, 1.0])
SPIN = np.array([0.3, -0.2, 1.1])
TILTED = np.array([0.1, 0.5, 0.7, 0.5])


def motion_of(case):
    """Return the motion of a case, by its potential where no system has that."""
    if case.system is not None:
        return Symmetric(case.system, case.start)
    body, field = case.raw['body'], case.raw['field']
    values = (float(x) for x in (body['A'], body['C'], 0, field['H1'], field['H2']))
    return Symmetric.in_potential(*values, case.start)


@pytest.mark.parametrize('name', CASES)
def test_reference_cases(name):
    """Proves attitude and rate of every symmetric case at all listed times."""
    case = CASES[name]
    states = motion_of(case).at(case.t_s)
    assert np.max(rotation.angle_between(states.q_ib, case.q_ib)) <= case.bound_exact
    off = np.linalg.norm(states.omega_bi_b - case.omega_bi_b, axis=-1)
    assert np.all(off <= 10.0 * case.bound_exact * np.linalg.norm(case.omega_bi_b, axis=-1))


@pytest.mark.parametrize('name', [name for name in CASES if name.startswith('pal1')])
def test_reference_constants(name):
    """Proves period, mean rates, roots, area and energy integrals by their 30 digits."""
    case = CASES[name]
    motion, derived = motion_of(case), case.raw['derived']
    # a period near the separatrix has the digits of 1 - k^2 = 5e-11 only
    rel = 1e-9 if name == 'pal1_near_separatrix' else 1e-13
    if 'period_theta' in derived:
        assert motion.period_s == pytest.approx(float(derived['period_theta']), rel=rel)
    if 'mean_precession_rate' in derived:
        for value, key in ((motion.Om_P, 'mean_precession_rate'), (motion.Om_S, 'mean_spin_rate')):
            assert value == pytest.approx(float(derived[key]), rel=rel, abs=1e-14)
    if 'g' in derived:
        assert motion.g == pytest.approx(float(derived['g']), rel=1e-14, abs=1e-15)
        roots = [float(root) for root in derived['roots_real']]
        roots += [complex(float(re), float(im)) for re, im in derived['roots_complex']]
        found = [min(motion.roots, key=lambda root, near=near: abs(root - near)) for near in roots]
        # roots that are near each other have half the digits
        assert np.array(found) == pytest.approx(np.array(roots), abs=1e-7)
    energy = float(case.raw['first_integrals']['energy_T_minus_U'])
    axial = motion.C * motion.r0**2 / 2.0
    assert motion.h_prime + axial == pytest.approx(energy, rel=1e-13)


@st.composite
def tops(draw):
    """Draw a symmetric body, any axes and rotor, its field and a start, beside a pole at times."""
    A = draw(powers_of_ten(-1.0, 2.0))
    C = A * draw(st.one_of(st.floats(0.1, 0.95), st.floats(1.05, 1.9), st.just(1.0)))
    q_bp = draw(body_axes())
    axis = rotation.matrix(q_bp)[:, 2]
    rate = draw(powers_of_ten(-1.5, 0.5))
    mode = draw(st.sampled_from(['none', 'constant_momentum', 'free', 'motor']))
    J, momentum, speed = 0.0, 0.0, np.nan
    if mode == 'constant_momentum':
        momentum = A * draw(st.floats(-2.0, 2.0)) * rate
    elif mode != 'none':
        J, speed = 0.3 * C, draw(st.floats(-5.0, 5.0)) * rate
    rotor = Rotor(mode, draw(signs) * axis, momentum, J)
    strength = draw(st.one_of(st.just(0.0), powers_of_ten(-1.0, 1.0))) * rate**2
    weight = draw(st.one_of(st.just(0.0), powers_of_ten(-1.0, 1.0))) * rate**2
    system = System(
        inertia_in_body_axes([A, A, C], q_bp),
        rotor,
        FixedDirection(draw(signs) * strength),
        draw(signs) * weight * A * axis,
    )
    q_ip = draw(attitudes())
    pole = draw(st.sampled_from(['', '', '', 'up', 'down', 'on']))
    if pole:
        q_ip = q_ip * np.where([pole == 'down'] * 2 + [pole != 'down'] * 2, 1.0, 1e-6)
        if pole == 'on':
            q_ip[:2] = 0.0
        aside = np.array([0.0, 1e-3 * (pole == 'down'), 0.0, pole != 'down'])
        q_ip = rotation.normalise(q_ip + aside)
    omega_p = rate * np.array([draw(st.floats(-1.0, 1.0)) for _ in range(3)])
    start = State(
        rotation.multiply(q_ip, rotation.conjugate(q_bp)),
        rotation.rotate(q_bp, omega_p),
        speed,
        0.4 if J else np.nan,
    )
    return system, start, rate * (1.0 + np.sqrt(abs(strength)) / rate)


@settings(
    max_examples=200,
    derandomize=True,
    deadline=None,
    suppress_health_check=[HealthCheck.filter_too_much],
)
@given(tops())
def test_agrees_with_propagation(top):
    """Proves attitude, rate and the rotor's angle over ten periods of bodies of any kind."""
    system, start, rate = top
    assert Symmetric.why_not(system, start) is None
    motion = Symmetric(system, start)
    # a nearly asymptotic motion has no ten periods that a propagation could follow
    longest = 40.0 * np.pi / rate
    period = min(motion.period_s or longest, longest)
    assert_agrees(motion, np.linspace(0.0, 10.0 * period, 60), rate)
