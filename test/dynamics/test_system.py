"""A system refuses a state that does not say how its rotors turn, and may be driven anew."""

import numpy as np
import pytest

from satdyn_ros import exact
from satdyn_ros.dynamics.constants import constants_of
from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.orbits import FixedDirection

BODY = np.diag([800.0, 900.0, 600.0])
Q_IB, OMEGA = np.array([0.0, 0.0, 0.0, 1.0]), np.array([1e-3, 2e-3, 3e-3])
WHEEL = Rotor('free', np.array([0.0, 0.0, 1.0]), inertia=0.5, name='wheel')
FLYWHEEL = Rotor('constant_momentum', momentum=0.1, name='flywheel')
FREE = FixedDirection(0.0)

INCOMPLETE: dict[str, tuple[tuple[Rotor, ...], tuple, str]] = {
    'neither': ((WHEEL,), (), 'rotor_speed of wheel is missing; a rotor of mode free needs it'),
    'no angle': (
        (WHEEL,),
        (1.0,),
        'rotor_angle of wheel is missing; a rotor of mode free needs it',
    ),
    'no speed': (
        (Rotor('motor', inertia=0.5),),
        (np.nan, 0.0),
        'rotor_speed of rotor is missing; a rotor of mode motor needs it',
    ),
    'of two rotors': (
        (FLYWHEEL, WHEEL),
        ([np.nan, 1.0], [0.0, np.nan]),
        'rotor_angle of wheel is missing; a rotor of mode free needs it',
    ),
    'one number for two': (
        (FLYWHEEL, WHEEL),
        (1.0, 0.0),
        'rotor_speed has the length 1; it must be 2, one per rotor',
    ),
}


@pytest.mark.parametrize('call', [Propagation, exact.Free, exact.recognise, exact.explain])
@pytest.mark.parametrize('case', INCOMPLETE)
def test_missing_rotor_values_are_named(case, call):
    """Propagation, closed form and recognition name the rotor value that the state lacks."""
    rotors, values, sentence = INCOMPLETE[case]
    with pytest.raises(ValueError, match=f'^{sentence}$'):
        call(System(BODY, rotors, FREE), State(Q_IB, OMEGA, *values))


@pytest.mark.parametrize('rotors', [(Rotor(),), (FLYWHEEL,), (FLYWHEEL, FLYWHEEL)])
def test_rotors_without_a_speed_need_no_values(rotors):
    """A state without rotor values is complete where no rotor has a speed of its own."""
    states = Propagation(System(BODY, rotors, FREE), State(Q_IB, OMEGA)).at([0.0, 10.0])
    assert np.isnan(states.rotor_speed).all()
    assert np.isfinite(states.q_ib).all()


def test_a_driven_system_moves_as_one_made_with_these_torques():
    """The constants that it shares with the system before are those of its equations."""
    motor = Rotor('motor', np.array([0.6, 0.0, 0.8]), inertia=0.5, friction=1e-3, name='motor')
    rotors, orbit = (FLYWHEEL, motor), FixedDirection(3e-6)
    torque_b, rotor_torque = np.array([1e-3, 0.0, -2e-3]), np.array([0.0, 4e-3])
    before = System(BODY, rotors, orbit)
    assert constants_of(
        before.driven(torque_b=torque_b, rotor_torque=rotor_torque)
    ) == constants_of(System(BODY, rotors, orbit, torque_b=torque_b, rotor_torque=rotor_torque))
    assert constants_of(
        before.driven(torque_b=torque_b).driven(torque_b=np.zeros(3))
    ) == constants_of(before)
