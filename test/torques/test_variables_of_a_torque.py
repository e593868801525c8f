"""A torque with a variable of its own, as in docs/how-to/torque.md: a valve that lags."""

from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.linalg import expm

from satdyn_ros import Scenario, Simulation
from satdyn_ros.bag.columns import StateTable
from satdyn_ros.bag.read_run import RecordedRun
from satdyn_ros.bag.simulate import simulate
from satdyn_ros.bag.verify import verify
from satdyn_ros.torques import BodyTorque, Key


class Valve(BodyTorque):
    name = 'valve'
    keys = (
        Key('valve.gain', 'double', 0.3, 'N m s', ''),
        Key('valve.lag', 'double', 5.0, 's', ''),
    )
    states = ('flow',)
    initial = (0.0,)
    scales = (1e-3,)

    class Constants(NamedTuple):
        gain: float
        lag: float

    @staticmethod
    def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants, states):
        return -constants.gain * states[0], 0.0, 0.0

    @staticmethod
    def rates(t_s, r_i, v_i, q_ib, omega_bi_b, constants, states):
        return ((omega_bi_b[0] - states[0]) / constants.lag,)


def _plain(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
    return 0.0, 0.0, 0.0


VALUES: dict[str, Any] = {
    'body.inertia': [3.0, 2.0, 4.0],
    'orbit.type': 'fixed',
    'initial.attitude': [0.0, 0.0, 0.0, 1.0],
    'initial.angular_velocity': [0.01, 0.0, 0.0],
    'publish.topics': ['attitude', 'angular_velocity', 'valve_torque', 'valve_states'],
    'publish.rate': 10.0,
    'time.epoch_ns': 10**18,
}
SCENARIO = Scenario(VALUES, torques=[Valve])


def test_it_is_what_the_linear_equations_give():
    """Rate and flow of a body that turns about x, by the matrix exponential."""
    A = np.array([[0.0, -0.3 / 3.0], [1.0 / 5.0, -1.0 / 5.0]])
    states = SCENARIO.motion().at([0.0, 7.0, 31.0])
    for t_s, omega, flow in zip(
        states.t_s, states.omega_bi_b[:, 0], states.inner['valve.flow'], strict=True
    ):
        expected = expm(A * t_s) @ [0.01, 0.0]
        np.testing.assert_allclose([omega, flow], expected, rtol=0.0, atol=1e-14)
    assert {'valve_flow'} <= {*states.to_pandas().columns}


def test_it_is_recorded_verified_and_gone_on_with(tmp_path):
    """A reset sets it back, a snapshot has it."""
    for _ in simulate(SCENARIO, 10.0, tmp_path / 'bag'):
        pass
    assert verify(tmp_path / 'bag').same_bytes
    (block,) = StateTable(RecordedRun(tmp_path / 'bag'), ['t_s', 'valve_flow']).blocks()
    found = SCENARIO.motion().at(block['t_s']).inner['valve.flow']
    np.testing.assert_array_equal(block['valve_flow'], found)
    simulation = Simulation(SCENARIO)
    simulation.step(torque_b=(0.0, 0.0, 1e-3))
    simulation.step(torque_b=(0.0, 0.0, 2e-3))
    again = Simulation.from_snapshot(SCENARIO, simulation.snapshot(simulation.tick))
    _, samples = again.advance(1)
    assert samples.states.inner['valve.flow'][0] == simulation.sample.inner['valve.flow'] > 0.0
    simulation.reset()
    assert simulation.step().inner['valve.flow'] == 0.0


@pytest.mark.parametrize(
    ('changed', 'why'),
    [
        ({'scales': (1.0, 1.0)}, r'its scales are \(1.0, 1.0\); they must be 1 above 0'),
        ({'scales': (0.0,)}, r'its scales are \(0.0,\); they must be 1 above 0'),
        ({'initial': ()}, r'its initial is \(\); it must have 1 numbers'),
        ({'states': ('a b',)}, r"its states are \('a b',\); they must be different names"),
        ({'rates': None, 'torque': _plain}, r'has the states flow and no rates'),
        ({'rates': staticmethod(lambda *seen: (0.0, 0.0))}, r'its rates returns a tuple of 2; it'),
        ({'rates': staticmethod(lambda t_s: (0.0,))}, r'has a rates that is not a static method'),
    ],
)
def test_what_does_not_fit_is_one_sentence(changed, why):
    """It names the class."""
    keys = tuple(Key(f'changed.{leaf}', 'double', 1.0, '', '') for leaf in ('gain', 'lag'))
    own = {'name': 'changed', 'keys': keys, '__module__': __name__, **changed}
    kind: Any = type('Changed', (Valve,), own)
    values = {k: x for k, x in VALUES.items() if k != 'publish.topics'}
    with pytest.raises(ValueError, match=why) as error:
        Scenario(values, torques=[kind]).motion().at(1.0)
    assert 'Changed' in str(error.value)
