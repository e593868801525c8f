"""Hysteresis rods: orbits and straight paths of the field against the reference."""

import json
from collections import Counter

import numpy as np
import pytest
from actuated import REFERENCE, cases, check, flown
from plain_walk import PlainWalk

from satdyn_ros import Scenario, Simulation
from satdyn_ros.dynamics.motion import States
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.integrate.batch import propagate_all
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits.pieces import Pieces, Stretch, fitted
from satdyn_ros.torques.hysteresis import MU_0, Hysteresis, Rod

CASES = cases('hysteresis.json')
PATHS = json.loads((REFERENCE / 'hysteresis.json').read_text())['rod_paths']
LEG_S = 10.0


def path(raw, H):
    """Return the motion of a body that hardly moves while the field along x goes from H to H."""
    leaves = 'coercive_force', 'remanence', 'saturation', 'minor_slope', 'exponent'
    rod = Rod('rod', (1.0, 0.0, 0.0), 1e-9, *(raw[leaf] for leaf in leaves))

    def field(t_s):
        B = MU_0 * np.interp(t_s, LEG_S * np.arange(len(H)), H)
        return np.stack([B, 0.0 * B, 0.0 * B], -1)

    stretches = [Stretch(LEG_S * i, LEG_S, LEG_S * i, LEG_S * (i + 1)) for i in range(len(H) - 1)]
    pieces = Pieces(fitted(field), stretches)
    torque = Hysteresis([rod], pieces.with_derivatives())
    system = System(1e9 * np.eye(3), torques=(torque,))
    return torque, Propagation(system, State(rotation.IDENTITY, np.zeros(3)))


@pytest.mark.parametrize('name', CASES)
def test_reference(name):
    """Attitude, rates and flux densities within the bounds, fields and torques as they are."""
    raw = CASES[name]
    scenario, samples = flown(raw)
    check(raw, samples)
    topics = scenario.topic_table
    b, H = topics['hysteresis'].shows
    true = [
        [row['hysteresis'][rod] for rod in topics['hysteresis'].joints] for row in raw['states']
    ]
    found = [b.of(each)[0] for each in samples]
    np.testing.assert_allclose(found, true, rtol=0.0, atol=raw['bound'] * np.max(np.abs(true)))
    for quantity, name_there in ((H, 'H'), (topics['hysteresis_torque'].shows[0], '')):
        given = [row[name_there or 'hysteresis_torque'] for row in raw['fields']]
        true = [[*row.values()] if isinstance(row, dict) else row for row in given]
        found = [quantity.of(each)[0] for each in samples]
        # The field of the table is good to 1e-10 of its size.
        atol = 10.0 * raw['bound'] * np.max(np.abs(true))
        np.testing.assert_allclose(found, true, rtol=0.0, atol=atol)


@pytest.mark.parametrize('raw', PATHS, ids=lambda raw: f'{raw["coercive_force"]} A/m')
def test_straight_paths(raw):
    """From value to value of the field the rod goes as the reference says."""
    torque, motion = path(raw, raw['H'])
    states = motion.at(LEG_S * np.arange(len(raw['H'])))
    found = torque.flux_densities(states.inner)[:, 0]
    np.testing.assert_allclose(found, raw['b'], rtol=0.0, atol=1e-11 * raw['saturation'])


@pytest.mark.parametrize('raw', PATHS[:2], ids=lambda raw: f'{raw["coercive_force"]} A/m')
def test_losses(raw):
    """The area of a steady loop is that of the reference, and grows towards 4 Bs Hc."""
    for loop in raw['loops']:
        A = loop['amplitude']
        torque, motion = path(raw, [0.0, A, -A, A, -A, A, -A, A])
        t_s = LEG_S * np.linspace(5.0, 7.0, 40_001)
        b = torque.flux_densities(motion.at(t_s).inner)[:, 0]
        H = np.interp(t_s, LEG_S * np.arange(8), [0.0, A, -A, A, -A, A, -A, A])
        area = abs(np.trapezoid(H, b))
        assert area == pytest.approx(loop['area'], rel=1e-5)
        share = area / (4.0 * raw['saturation'] * raw['coercive_force'])
        assert share == pytest.approx(loop['area_over_4_Bs_Hc'], rel=1e-5)


def test_the_curves_of_the_loop_are_kept():
    """On the right-hand curve, x = 1, L stays behind a field that grows by Hc."""
    raw = PATHS[0]
    _, motion = path(raw, [0.0, -1e4, 1e4])
    t_s = LEG_S * np.linspace(1.9, 2.0, 5)
    L = motion.at(t_s).inner['hysteresis.rod']
    H = -1e4 + 2e4 * (t_s - LEG_S) / LEG_S
    np.testing.assert_allclose(H - L, raw['coercive_force'], rtol=1e-9)


@pytest.mark.long
@pytest.mark.parametrize('name', CASES)
def test_steps_end_at_corners(name):
    """At all of the reference, most of which are foreseen: no attempt is rejected."""
    raw = CASES[name]
    motion = Scenario.from_dict(raw['scenario']).motion()
    walk, end_s, ends_s = PlainWalk(motion.system, motion.state, 0.0), raw['states'][-1]['t'], []
    while walk.t < end_s:
        walk.step()
        ends_s.append(walk.t)
    true_s = [t_s for corners in raw['corners'].values() for t_s in corners if t_s < end_s]
    assert max(min(abs(t_s - end) for end in ends_s) for t_s in true_s) < 1e-5
    print(len(ends_s), 'steps,', len(true_s), 'corners, rejected:', walk.met['corners'])
    assert walk.met['corners'] <= 0.5 * len(true_s)


def test_in_lanes_the_bits_are_those_alone():
    """Of nine bodies that begin with other rates."""
    scenario = Scenario.from_dict(CASES['rods_magnet_3u']['scenario'])
    rates = [(0.002, -0.003, 0.002 * n) for n in range(9)]
    each = [scenario.with_values({'initial.angular_velocity': rate}) for rate in rates]
    t_s = np.linspace(0.0, 1000.0, 11)
    for states, one in zip(propagate_all([s.motion() for s in each], t_s), each, strict=True):
        alone = one.motion().at(t_s)
        assert isinstance(states, States)
        assert states.q_ib.tobytes() == alone.q_ib.tobytes()
        assert states.inner['hysteresis.rods_x'].tobytes() == (
            alone.inner['hysteresis.rods_x'].tobytes()
        )


def test_a_reset_begins_on_the_middle_curve():
    """In the field of then."""
    simulation = Simulation(Scenario.from_dict(CASES['rods_magnet_3u']['scenario']))
    simulation.advance(400)
    simulation.reset()
    _, samples = simulation.advance(1)
    H = simulation.scenario.topic_table['hysteresis'].shows[1].of(samples)[0]
    L = [samples.states.inner[f'hysteresis.{name}'][0] for name in ('rods_x', 'rods_y')]
    np.testing.assert_allclose(L, H, rtol=1e-14)


ROD = {'axis': [1.0, 0.0, 0.0], 'volume': 1e-7, 'coercive_force': 12.0, 'remanence': 0.004}


@pytest.mark.parametrize(
    ('given', 'sentence'),
    [
        ({'saturation': 0.004}, r'remanence is 0.004 and hysteresis.a.saturation 0.004; the rem'),
        ({'coercive_force': 0.0}, r'coercive_force is 0; it must be above 0 A/m'),
        ({'volume': -1e-7}, r'volume is -1e-07; it must be a number at least 0 m\^3'),
        ({'axis': [0.0, 0.0, 0.0]}, r'axis is \[0.0, 0.0, 0.0\]; it must not be zero'),
        ({'exponent': 0.0}, r'exponent is 0.0; it must be a number above 0'),
        ({'minor_slope': 1.5}, r'minor_slope is 1.5; it must be'),
        ({'length': 1.0}, r'length is not a parameter of a scenario; hysteresis.a has axis'),
    ],
)
def test_bad_input_is_one_sentence(given, sentence):
    """It names the key of the rod."""
    rod = {**ROD, 'saturation': 0.025, **given}
    with pytest.raises(ValueError, match=rf'^hysteresis.a.{sentence}'):
        Scenario.from_dict({'hysteresis': {'names': ['a'], 'a': rod}})


def test_names_are_given_once_and_a_field_is_there():
    """Two rods of a name are refused, rods without a field are reported."""
    with pytest.raises(ValueError, match=r'^hysteresis.names has a twice'):
        Scenario({'hysteresis.names': ['a', 'a']})
    scenario = Scenario.from_dict({'hysteresis': {'names': ['a'], 'a': ROD | {'saturation': 1.0}}})
    (warning,) = scenario.warnings_about(['hysteresis.names'])
    assert 'without environment.magnetic_field it has no effect' in warning
    assert Counter(type(torque) for torque in scenario.system.torques)[Hysteresis] == 0
