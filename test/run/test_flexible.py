"""Flexible parts: hybrid coordinates against the reference, and what is known of them."""

import numpy as np
import pytest
from actuated import cases, check, flown

from satdyn_ros import Scenario, Simulation
from satdyn_ros.dynamics import variables
from satdyn_ros.dynamics.integrals import first_integrals, relative_drift
from satdyn_ros.dynamics.motion import States
from satdyn_ros.dynamics.torque import angular_momentum
from satdyn_ros.integrate import step_code
from satdyn_ros.integrate.batch import propagate_all
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.run.describe import describe

CASES = cases('flexible.json')
TWO = CASES['flex_two_free']


def changed(scenario, **changes):
    """Return the scenario of a case with some keys changed, '__' for each dot."""
    values = {name.replace('__', '.'): x for name, x in changes.items()}
    return Scenario.from_dict(scenario).with_values(values)


@pytest.mark.parametrize('name', CASES)
def test_reference(name):
    """Attitude, rates, wheel and modes within the bound of each case."""
    _, samples = flown(CASES[name])
    check(CASES[name], samples)


def test_the_order_of_the_parts_is_of_no_matter(monkeypatch):
    """With the parts of the variables in other orders all cases are met as before."""
    *inner, work, anomaly = variables.ORDER
    monkeypatch.setattr(step_code, '_known', {})
    for order in ((anomaly, work, *reversed(inner)), (*inner[2:], work, anomaly, *inner[:2])):
        step_code._known.clear()
        monkeypatch.setattr(variables, 'ORDER', order)
        for raw in (*CASES.values(), cases('hysteresis.json')['rods_magnet_3u']):
            check(raw, flown(raw)[1])


def test_in_lanes_the_modes_have_the_bits_that_they_have_alone():
    """Nine motions of which eight go side by side."""
    t_s = np.linspace(0.0, 40.0, 9)
    scenarios = [
        changed(TWO['scenario'], flexible__left__frequency=1.3 + 0.1 * n) for n in range(9)
    ]
    together = propagate_all([scenario.motion() for scenario in scenarios], t_s)
    for states, scenario in zip(together, scenarios, strict=True):
        alone = scenario.motion().at(t_s)
        assert isinstance(states, States)
        assert states.q_ib.tobytes() == alone.q_ib.tobytes()
        for name, values in alone.inner.items():
            assert states.inner[name].tobytes() == values.tobytes()


def test_energy_and_momentum_are_conserved():
    """Without damping both are watched, and H stays where it is in inertial axes."""
    scenario = Scenario.from_dict(TWO['scenario'])
    states = scenario.motion().at(np.linspace(0.0, 120.0, 121))
    integrals = first_integrals(scenario.system, states)
    assert {'energy', 'momentum', 'area'} <= integrals.keys()
    assert not {'fourth', 'axial_rate'} & integrals.keys()
    for drift in relative_drift(scenario.system, states).values():
        assert np.max(np.abs(drift)) < 1e-11
    H_b = angular_momentum(scenario.system, states.omega_bi_b, states.rotor_speed, states.inner)
    H_i = rotation.rotate(states.q_ib, H_b)
    assert np.max(np.abs(H_i - H_i[0])) < 1e-11 * np.linalg.norm(H_i[0])


def test_damping_is_work():
    """The energy of damped modes falls by as much as the work says."""
    scenario = Scenario.from_dict(CASES['flex_damped_torques']['scenario'])
    states = scenario.motion().at(np.linspace(0.0, 60.0, 61))
    assert states.work[-1] < 0.0
    drift = relative_drift(scenario.system, states)
    assert np.max(np.abs(drift['energy_balance'])) < 1e-11


def test_a_wheel_at_its_limit_swings_with_the_body():
    """Held there, its torque is that of the body's omega', which modes shake: the work adds up."""
    scenario = changed(
        CASES['flex_wheel']['scenario'],
        rotor__rw__max_speed=50.5,
        flexible__panel__displacement=0.05,
    )
    system = scenario.system.driven(rotor_torque=np.array([0.02, 0.0]))
    states = Propagation(system, scenario.initial_state).at(np.linspace(0.0, 20.0, 201))
    assert states.rotor_torque is not None
    held = states.t_s > 1.0
    np.testing.assert_allclose(states.rotor_speed[held, 0], 50.5, rtol=1e-12)
    assert np.ptp(states.rotor_torque[held, 0]) > 1e-5
    drift = relative_drift(system, states)['energy_balance']
    assert np.max(np.abs(drift)) < 1e-11


def test_free_frequency_of_one_mode():
    """A free body swings at W / sqrt(1 - d^2 / I); the program and describe agree."""
    raw = CASES['flex_step_one_axis']['scenario']
    expected = 2.0 / np.sqrt(1.0 - 1.6**2 / 8.0)
    scenario = changed(raw, flexible__panel__displacement=0.01)
    (free,) = describe(scenario)['flexible']['free_rad_s']
    assert free == pytest.approx(expected, rel=1e-14)
    half_s = np.pi / expected
    eta = scenario.motion().at(half_s * np.arange(9)).inner['flexible.panel.displacement']
    np.testing.assert_allclose(eta, 0.01 * (-1.0) ** np.arange(9), atol=1e-12)


def test_describe_tells_what_samples_do_not_see():
    """A mode beyond half the rate of the samples is named."""
    slow = changed(TWO['scenario'], publish__rate=1.0)
    flexible = describe(slow)['flexible']
    assert flexible['unseen_rad_s'] == [x for x in flexible['free_rad_s'] if x >= np.pi]
    assert len(flexible['unseen_rad_s']) == 1
    assert describe(Scenario())['flexible'] is None
    assert 'flexible parts left, right' in describe(slow)['why_not']


def test_a_reset_sets_the_modes_back():
    """So does a request, whatever it asks for; both leave the rate that the keys say."""
    simulation = Simulation(Scenario.from_dict(TWO['scenario']))
    begin = simulation.advance(1)[1].states.inner
    simulation.advance(50)
    simulation.reset()
    assert simulation.advance(1)[1].states.inner == begin
    simulation.advance(50)
    simulation.request({'initial.angular_velocity': [0.0, 0.0, 0.1]})
    inner = simulation.advance(1)[1].states.inner
    assert {name: x.item() for name, x in inner.items()} == pytest.approx(
        {name: x.item() for name, x in begin.items()}, rel=1e-15
    )


def test_a_snapshot_goes_on_with_the_same_bits():
    """The swing of the modes is in it."""
    simulation = Simulation(Scenario.from_dict(TWO['scenario']))
    simulation.advance(30)
    simulation.begin_from(simulation.state)
    simulation.advance(20)
    again = Simulation.from_snapshot(
        Scenario.from_dict(TWO['scenario']), simulation.snapshot(simulation.tick)
    )
    a, b = simulation.advance(10)[1].states, again.advance(11)[1].states
    assert a.q_ib.tobytes() == b.q_ib[1:].tobytes()


@pytest.mark.parametrize(
    ('changes', 'sentence'),
    [
        (
            {'flexible__left__coupling': (0.0, 6.0, 0.0)},
            r'flexible.left.coupling is \[0.0, 6.0, 0.0\], of length 6; in this direction it must '
            r'be below 5.\d+ sqrt\(kg\) m, the most that body.inertia allows',
        ),
        (
            {'flexible__right__coupling': (0.0, 9.0, 0.0)},
            r'flexible.right.coupling is .* the most that body.inertia and the modes before it '
            'allow$',
        ),
        ({'flexible__left__frequency': 0.0}, r'flexible.left.frequency is 0; it must be'),
        ({'flexible__left__damping': -0.1}, r'flexible.left.damping is -0.1; it must be'),
        ({'flexible__names': ['left', 'left']}, r'flexible.names has left twice'),
        ({'flexible__names': ['my panel']}, r"flexible.names has 'my panel'; a name has letters"),
        ({'flexible__names': ['left']}, r'flexible.right.\w+ is given, but flexible.names has no'),
        ({'motion__method': 'exact'}, r'closed forms do not know the flexible parts left, right'),
        ({'publish__topics': ['flexible'], 'flexible__names': []}, 'flexible'),
    ],
)
def test_bad_input_is_one_sentence(changes, sentence):
    """It says what was given, what is allowed and which key."""
    with pytest.raises(ValueError, match=sentence) as error:
        changed(TWO['scenario'], **changes)
    assert '\n' not in str(error.value)


def test_a_mode_without_frequency_is_refused():
    """It has no default."""
    given = {'flexible': {'names': ['panel'], 'panel': {'coupling': [0.0, 1.0, 0.0]}}}
    with pytest.raises(ValueError, match=r'^flexible.panel.frequency is 0; it must be above 0 '):
        Scenario.from_dict(given)
