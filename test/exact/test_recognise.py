"""Recognition: every closed form that exists, no other, and the reason where there is none."""

from dataclasses import fields, replace

import numpy as np
import pytest
from agreement import assert_agrees
from cases import bounded, newtonian
from draws import angles, attitudes, body_axes, inertia_in_body_axes, moments, powers_of_ten
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from satdyn_ros import exact
from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.exact.exact_motion import ExactMotion
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import FixedDirection, KeplerOrbit

X, Y, Z = np.eye(3)
TURNED = rotation.normalise([0.3, -0.5, 0.2, 0.9])
EXACT = bounded(newtonian(), 'bound_exact')
OTHERS = [name for name in newtonian() if name not in EXACT]


def in_axes(system, state, q_bp):
    """Return a system and state given in axes p, in axes b."""
    moments, rotor = np.diagonal(system.inertia), system.rotors[0]
    turned = System(
        inertia_in_body_axes(moments, q_bp),
        (Rotor(rotor.mode, rotation.rotate(q_bp, rotor.axis), rotor.momentum, rotor.inertia),),
        system.orbit,
        rotation.rotate(q_bp, system.weight_moment),
    )
    q_ib = rotation.multiply(state.q_ib, rotation.conjugate(q_bp))
    return turned, State(q_ib, rotation.rotate(q_bp, state.omega_bi_b))


@pytest.mark.parametrize('q_bp', [rotation.IDENTITY, TURNED], ids=['principal', 'turned'])
@pytest.mark.parametrize('name', EXACT)
def test_every_reference_case_with_a_closed_form_has_one(name, q_bp):
    """Proves recognition from system and state alone, in any body axes, within the bounds."""
    case = newtonian()[name]
    system, start = in_axes(case.system, case.start, q_bp)
    motion = exact.recognise(system, start)
    assert motion is not None, exact.explain(system, start)
    assert exact.explain(system, start) is None
    states = motion.at(case.t_s)
    q_ip = rotation.multiply(states.q_ib, q_bp)
    assert np.max(rotation.angle_between(q_ip, case.q_ib)) <= case.bound_exact


@pytest.mark.parametrize('name', OTHERS)
def test_reference_cases_without_a_closed_form_have_none(name):
    """Proves that nothing is recognised where the papers have nothing."""
    case = newtonian()[name]
    assert exact.recognise(case.system, case.start) is None
    assert exact.explain(case.system, case.start)


def swinging(**changes):
    """Return the satellite of Balli and Grioli that swings about the orbit normal, changed."""
    system = replace(System(np.diag([600.0, 900.0, 800.0]), orbit=KeplerOrbit()), **changes)
    orbit = system.orbit
    assert isinstance(orbit, KeplerOrbit)
    q_lb = rotation.about(Y, 0.3)
    q_ib = rotation.multiply(orbit.lvlh(0.0), q_lb)
    speed = (2.0, 0.0) if system.has_turning_rotor else (np.nan, np.nan)
    return system, State(q_ib, np.array([0.0, -orbit.mean_motion, 0.0]), *speed)


@pytest.mark.parametrize(
    'rotor',
    [
        Rotor(),
        Rotor('constant_momentum', Y, momentum=5.0),
        Rotor('constant_momentum', X, momentum=0.0),
        Rotor('free', Y, inertia=2.0),
        Rotor('motor', -Y, inertia=2.0),
    ],
    ids=['none', 'constant', 'without momentum', 'free', 'motor without torque'],
)
def test_rotors_that_leave_the_planar_motion(rotor):
    """Proves every mode of a rotor along the normal, and one that has no momentum."""
    assert isinstance(exact.recognise(*swinging(rotors=(rotor,))), exact.Planar)


@pytest.mark.parametrize(
    ('changes', 'reason'),
    [
        ({'torque_b': 1e-6 * X}, 'a torque is applied'),
        (
            {'rotors': (Rotor('motor', Y, inertia=2.0),), 'rotor_torque': 1e-6},
            'a torque is applied',
        ),
        ({'orbit': KeplerOrbit(eccentricity=1e-3)}, 'orbit.eccentricity is 0.001'),
        (
            {'rotors': (Rotor('constant_momentum', Z, momentum=5.0),)},
            'the rotor is not along the orbit normal',
        ),
        ({'rotors': (Rotor('free', X, inertia=2.0),)}, 'the rotor is not along the orbit normal'),
        (
            {'inertia': np.array([[600.0, 1.0, 0.0], [1.0, 900.0, 0.0], [0.0, 0.0, 800.0]])},
            'the orbit normal is not a principal axis',
        ),
    ],
)
def test_what_ends_the_planar_motion_is_said(changes, reason):
    """Proves that there is no longer a closed form, and that the reason is the change."""
    system, start = swinging(**changes)
    assert exact.recognise(system, start) is None
    assert (exact.explain(system, start) or '').startswith(reason)


def test_in_a_fixed_field_each_motion_has_its_reason():
    """Proves that the reason covers every motion that the field allows."""
    system = System(np.diag([1.0, 1.5, 2.0]), orbit=FixedDirection(1.0))
    start = State(TURNED, np.array([0.1, 0.2, 0.3]))
    assert exact.recognise(system, start) is None
    reason = exact.explain(system, start)
    assert reason is not None
    for words in ('planar motion: ', 'symmetric body: ', 'stationary motion: '):
        assert words in reason
    assert '\n' not in reason


def test_without_a_field_only_free_motions_have_reasons():
    """Proves that the reason for a torque-free gyrostat does not mention fields."""
    rotor = Rotor('constant_momentum', np.array([0.6, 0.0, 0.8]), 1.0)
    system = System(np.diag([1.0, 1.5, 2.0]), (rotor,), FixedDirection(0.0))
    start = State(TURNED, np.array([0.1, 0.2, 0.3]))
    assert exact.recognise(system, start) is None
    reason = exact.explain(system, start)
    assert reason is not None
    assert 'rotor.axis is not a principal axis' in reason
    assert 'gradient' not in reason


def test_the_simplest_motion_is_preferred():
    """Proves the order: what is steady is flown as steady, though it is planar too."""
    q_ib = KeplerOrbit().lvlh(0.0)
    start = State(q_ib, np.array([0.0, -KeplerOrbit().mean_motion, 0.0]))
    system = System(np.diag([700.0, 900.0, 600.0]), orbit=KeplerOrbit())
    assert isinstance(exact.recognise(system, start), exact.Steady)


def test_a_motion_begins_when_it_is_asked_to():
    """Proves start_s: the centre is where the orbit has it then."""
    system, _ = swinging()
    q_ib = rotation.multiply(system.orbit.lvlh(1234.5), rotation.about(Y, 0.3))
    start = State(q_ib, np.array([0.0, -system.orbit.mean_motion, 0.0]))
    motion = exact.recognise(system, start, 1234.5)
    assert isinstance(motion, exact.Planar)
    assert motion.period_s is not None
    assert motion.start_s == 1234.5
    # the longest axis swings about the vertical, from 0.3 rad above the track to as far beyond
    half = motion.at(motion.period_s / 2.0).q_lb[0]
    assert rotation.angle_between(half, rotation.about(Y, np.pi - 0.3)) < 1e-12


@st.composite
def scenarios(draw):
    """Draw a system and a start with as many symmetries as closed forms have, or fewer."""
    I, q_bp = draw(moments()), draw(body_axes())
    R_bp = rotation.matrix(q_bp)
    axes = st.sampled_from([*R_bp.T, *-R_bp.T])
    scale = np.max(I) * 1e-3
    is_fixed = draw(st.booleans())
    orbit = FixedDirection(draw(st.sampled_from([0.0, 3.6e-6]))) if is_fixed else KeplerOrbit()
    weight = np.zeros(3)
    if is_fixed and draw(st.booleans()):
        weight = draw(axes) * scale * 1e-3
    mode = draw(st.sampled_from(['none', 'none', 'constant_momentum', 'free']))
    axis = draw(axes)
    rotor = Rotor(mode, axis, 0.0, 0.0)
    if mode == 'constant_momentum':
        rotor = Rotor(mode, axis, momentum=float(scale * draw(powers_of_ten(-3.0, 0.0))))
    elif mode == 'free':
        rotor = Rotor(mode, axis, inertia=0.3 * np.min(I))
    system = System(inertia_in_body_axes(I, q_bp), (rotor,), orbit, weight)
    # not at rest, where a propagation would resolve rounding
    rate_axis, size = draw(axes), draw(st.sampled_from([1e-3, 3e-3]))
    upright = draw(st.sampled_from(['anyhow', 'rate along', 'rate across']))
    q_ib = draw(attitudes())
    if upright != 'anyhow':
        special = (
            orbit.normal if isinstance(orbit, KeplerOrbit) else Z if upright == 'rate along' else X
        )
        q_ib = rotation.multiply(
            rotation.about(special, draw(angles)), _shortest(rate_axis, special)
        )
    omega = size * rate_axis
    if draw(st.integers(0, 2)) == 0:
        omega = omega + 1e-3 * np.array([draw(st.floats(-1.0, 1.0)) for _ in range(3)])
    return system, State(q_ib, omega, *((1e-2, 0.0) if mode == 'free' else (np.nan, np.nan)))


def _shortest(a, b):
    """Return the quaternion of the shortest turn from the unit vector a to b."""
    cosine = a @ b
    if cosine < -0.999:
        half = np.cross(a, np.eye(3)[np.argmin(np.abs(a))])
        return np.append(half / np.linalg.norm(half), 0.0)
    return rotation.normalise(np.append(np.cross(a, b), 1.0 + cosine))


# most drawn systems have no closed form, and are passed over
@pytest.mark.long
@settings(max_examples=200)
@given(scenarios())
def test_what_is_recognised_is_what_propagates(scenario):
    """Proves that no motion is taken for another, whatever symmetries meet."""
    system, start = scenario
    motion = exact.recognise(system, start)
    assume(motion is not None)
    assert_agrees(motion, np.linspace(0.0, 2e4, 40), 1e-3 + np.linalg.norm(start.omega_bi_b))


class Pushed(System):
    """A system with a torque of a kind that no closed form knows."""

    @property
    def is_newtonian(self) -> bool:
        """Whether nothing acts but the field."""
        return False


@pytest.mark.parametrize('name', EXACT)
def test_a_torque_that_no_closed_form_knows_is_refused(name):
    """System.is_newtonian alone makes every closed form refuse what it would otherwise accept."""
    case = newtonian()[name]
    pushed = Pushed(**{field.name: getattr(case.system, field.name) for field in fields(System)})
    assert exact.recognise(case.system, case.start) is not None
    assert exact.recognise(pushed, case.start) is None
    assert exact.explain(pushed, case.start)
    for motion in ExactMotion.__subclasses__():
        with pytest.raises(ValueError, match='a torque is applied'):
            motion(pushed, case.start)


def test_the_rotor_with_friction_is_named():
    """Of several rotors the sentence names the one whose friction drives the body."""
    rotors = tuple(
        Rotor('free', inertia=1.0, friction=friction, name=name)
        for name, friction in (('ring', 0.0), ('damper', 0.1))
    )
    system = System(np.diag([80.0, 90.0, 60.0]), rotors)
    state = State(np.array([0.0, 0.0, 0.0, 1.0]), np.zeros(3), np.zeros(2), np.zeros(2))
    said = exact.explain(system, state)
    assert said == 'rotor.damper.friction is not zero: friction drives the body'


ELLIPSE = KeplerOrbit(semi_major_axis=1.2e7, eccentricity=0.4, inclination=0.9, true_anomaly=2.0)
ALONG_NORMAL = rotation.from_matrix(ELLIPSE.perifocal)
SPHERE, DISC = 2.0 * np.eye(3), np.diag([2.0, 2.0, 3.0])
WHEEL = Rotor('free', np.array([0.0, 0.6, 0.8]), inertia=0.05)
HELD = Rotor('constant_momentum', np.array([0.0, 0.6, 0.8]), 0.3)


@pytest.mark.parametrize(
    ('kind', 'system', 'start'),
    [
        (exact.Steady, System(SPHERE), State(ALONG_NORMAL, np.array([0.01, -0.02, 0.005]))),
        (exact.Steady, System(SPHERE), State(ALONG_NORMAL, np.zeros(3))),
        (exact.Steady, System(DISC), State(ALONG_NORMAL, np.array([0.0, 0.0, 0.01]))),
        (exact.Steady, System(DISC), State(ALONG_NORMAL, np.zeros(3))),
        (
            exact.Steady,
            System(SPHERE, (HELD,), torque_b=np.array([3e-5, 0.0, 0.0])),
            State(ALONG_NORMAL, np.array([0.0, 1.25e-4, 0.0])),
        ),
        (
            exact.Free,
            System(SPHERE, (HELD,)),
            State(ALONG_NORMAL, np.array([0.01, -0.02, 0.005])),
        ),
        (
            exact.Free,
            System(SPHERE, (WHEEL,)),
            State(ALONG_NORMAL, np.array([0.01, -0.02, 0.005]), 3.0, 0.0),
        ),
    ],
    ids=['sphere', 'sphere at rest', 'disc', 'disc at rest', 'torque', 'rotor', 'free rotor'],
)
def test_on_an_ellipse_a_closed_form_knows_the_work_of_the_orbit(kind, system, start):
    """Proves it against that of the propagation, over an orbit and from any position on it."""
    system, start_s = replace(system, orbit=ELLIPSE), 1234.5
    motion = exact.recognise(system, start, start_s)
    assert isinstance(motion, kind)
    t_s = np.linspace(0.0, 2.0 * np.pi / ELLIPSE.mean_motion, 100)
    # No step is chosen for its work, which swings faster than the orbit turns: finer ones.
    work = Propagation(system, start, start_s, 1e-16).at(t_s).work
    assert np.ptp(work) > 1e-7
    np.testing.assert_allclose(motion.at(t_s).work, work, rtol=0.0, atol=1e-12 * np.ptp(work))
