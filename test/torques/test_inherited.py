"""Torques that take part of another's: each flies its own function, whatever was defined last."""

import sys
from typing import Any, NamedTuple

import numpy as np
import pytest

from satdyn_ros import Scenario
from satdyn_ros.bag.simulate import simulate
from satdyn_ros.bag.verify import verify
from satdyn_ros.dynamics.motion import States
from satdyn_ros.dynamics.system import State
from satdyn_ros.dynamics.torque import own_potential, own_torque
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.orbits import FixedDirection
from satdyn_ros.orbits.pieces import Pieces, Stretch
from satdyn_ros.run.describe import describe
from satdyn_ros.torques.aerodynamic import Aerodynamic
from satdyn_ros.torques.body_torque import BodyTorque, torque_of
from satdyn_ros.torques.magnetic import Magnetic
from satdyn_ros.torques.plates import Plate

AT_REST = States(
    np.zeros(1),
    np.array([[0.0, 0.0, 0.0, 1.0]]),
    np.zeros((1, 3)),
    np.full((1, 1), np.nan),
    np.full((1, 1), np.nan),
    np.zeros(1),
    FixedDirection(),
    np.zeros(1),
)


class Shared(NamedTuple):
    """Of two torques, neither of which inherits from the other."""

    size: float


class Push(BodyTorque):
    name = 'push'
    Constants = Shared

    @classmethod
    def of(cls, values):
        return cls(Shared(0.01))

    @staticmethod
    def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        return constants.size, 0.0, 0.0

    @staticmethod
    def potential(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        return constants.size


class Pull(Push):
    name = 'pull'
    potential = None  # type: ignore[assignment]

    @staticmethod
    def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        return -constants.size, 0.0, 0.0


class Lift(BodyTorque):
    name = 'lift'
    Constants = Shared

    @staticmethod
    def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        return 0.0, 0.0, constants.size


class Same(Push):
    """All of another's, with another name."""

    name = 'same'


def turned(sign):
    """Return a torque whose function takes a number from around it, and whose names are alike."""

    class Turned(BodyTorque):
        name = 'turned'
        Constants = Shared

        @staticmethod
        def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
            return 0.0, sign * constants.size, 0.0

    return Turned


FIRST, SECOND = turned(1.0), turned(-1.0)


@pytest.mark.parametrize(
    ('kind', 'torque_b'),
    [
        (Push, [0.01, 0.0, 0.0]),
        (Pull, [-0.01, 0.0, 0.0]),
        (Lift, [0.0, 0.0, 0.01]),
        (Same, [0.01, 0.0, 0.0]),
        (FIRST, [0.0, 0.01, 0.0]),
        (SECOND, [0.0, -0.01, 0.0]),
    ],
)
def test_each_has_its_own_function(kind, torque_b):
    """By inheritance, by assignment, and under the same names; constants made by either class."""
    for constants in (kind.Constants(0.01), Shared(0.01)):
        torque = kind(constants)
        assert own_torque((torque,), AT_REST)[0].tolist() == torque_b
        assert torque.constants == (0.01,)


def test_two_act_together():
    """Of four with the same constants, two of one kind, the sum."""
    torques = Push(Shared(1.0)), Pull(Shared(0.5)), Lift(Shared(2.0)), Push(Shared(0.25))
    assert own_torque(torques, AT_REST)[0].tolist() == [0.75, 0.0, 2.0]


def test_a_potential_that_is_taken_back_does_not_count():
    """Only of the one that has it."""
    torques = Push(Shared(3.0)), Pull(Shared(5.0)), Same(Shared(0.5))
    assert own_potential(torques, AT_REST).tolist() == [3.5]


def test_shipped_torques_stay_as_they_are():
    """One that inherits from the drag flies its own function, and drag flies drag's."""

    class MyDrag(Aerodynamic):
        name = 'my_drag'

        @staticmethod
        def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
            return 1.0, 2.0, 3.0

    class MyMagnet(Magnetic):
        name = 'my_magnet'
        keys = ()  # type: ignore[assignment]

    def uniform(*values):
        coefficients = np.zeros((len(values), 16))
        coefficients[:, 0] = values
        return Pieces(lambda piece: coefficients, [Stretch(0.0, 500.0)])

    # p x F, of a plate of 2 m^2 with its centre at y, in a flow along x: by hand.
    plate = Plate(2.0, (1.0, 0.0, 0.0), (0.0, 0.5, 0.0), 2.0)
    air = [plate], uniform(100.0, 0.0, 0.0), uniform(np.log(1e-6))
    by_hand = [0.0, 0.0, 0.5 * 0.5 * 1e-6 * 2.0 * 2.0 * 100.0**2]
    assert own_torque((MyDrag(*air),), AT_REST)[0].tolist() == [1.0, 2.0, 3.0]
    assert own_torque((Aerodynamic(*air),), AT_REST)[0] == pytest.approx(by_hand, rel=1e-14)
    assert type(MyMagnet((0.0, 0.0, 1.0), uniform(0.0)).commanded((1.0, 0.0, 0.0))) is MyMagnet


def test_what_flies_is_what_the_bag_names(tmp_path):
    """0.01 N m for 10 s about an axis of 3 kg m^2, though a torque of -0.01 N m came after it."""
    values = {
        'body.inertia': [3.0, 2.0, 4.0],
        'orbit.type': 'fixed',
        'initial.attitude': [0.0, 0.0, 0.0, 1.0],
        'publish.rate': 1.0,
        'time.epoch_ns': 10**18,
    }
    scenario = Scenario(values, [Push])
    assert describe(scenario)['why_not'] == 'closed forms do not know the torque push'
    states = Propagation(scenario.system, State(AT_REST.q_ib[0], np.zeros(3))).at([10.0])
    assert states.omega_bi_b[0] == pytest.approx([0.01 / 3.0 * 10.0, 0.0, 0.0], rel=1e-12)
    for _ in simulate(scenario, '5', tmp_path / 'bag'):
        pass
    assert verify(tmp_path / 'bag').same_bytes


def test_a_torque_of_another_kind_is_refused():
    """Its function would fly under a name and a hash that are not its own."""

    class Lent(Push):
        name = 'lent'

        @classmethod
        def of(cls, values):
            return Push(Shared(1.0))

    with pytest.raises(ValueError, match=r'Lent cannot be made: its of returns .*Push'):
        torque_of(Lent, {})


def test_constants_of_other_fields_are_refused():
    """Their numbers would be taken for others."""

    class Other(NamedTuple):
        length: float

    with pytest.raises(TypeError, match=r"they must have \('size',\)"):
        Pull(Other(1.0))


HELPER = 'from numba import njit\n@njit\ndef size(t_s):\n    return {} + 0.0 * t_s\n'


def test_its_source_is_that_of_what_it_calls(tmp_path, monkeypatch):
    """A module of its own, and of the class that it inherits from, but none of this package."""
    (tmp_path / 'base_torque.py').write_text(
        'from satdyn_ros.torques import BodyTorque\n'
        'from far_helper import size\n'
        'class Base(BodyTorque):\n'
        '    Constants = __import__("collections").namedtuple("Constants", "")\n'
        '    @staticmethod\n'
        '    def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):\n'
        '        return size(t_s), 0.0, 0.0\n'
    )
    (tmp_path / 'far_helper.py').write_text(HELPER.format(0.5))
    (tmp_path / 'heir.py').write_text(
        'from base_torque import Base\nclass Heir(Base):\n    name = "heir"\n'
    )
    monkeypatch.syspath_prepend(tmp_path)
    heir: Any = __import__('heir').Heir
    texts = [(tmp_path / f'{name}.py').read_text() for name in ('heir', 'base_torque')]
    assert heir.source() == '\n'.join([*texts, (tmp_path / 'far_helper.py').read_text()])
    before = heir.version()
    for name in ('heir', 'base_torque', 'far_helper'):
        del sys.modules[name]
    (tmp_path / 'far_helper.py').write_text(HELPER.format(0.75))
    again: Any = __import__('heir').Heir
    assert again.version() != before
    assert own_torque((again(again.Constants()),), AT_REST)[0, 0] == 0.75
    assert own_torque((heir(heir.Constants()),), AT_REST)[0, 0] == 0.5
