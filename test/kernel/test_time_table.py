"""Tables are the functions that they were made of, in one motion and in many side by side."""

import math
from typing import NamedTuple

import numpy as np
import pytest

from satdyn_ros.dynamics.motion import States
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.integrate.batch import propagate_all
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.kernel.time_table import Table, interpolate, table_of
from satdyn_ros.torques import BodyTorque

PIECE_S = 60.0


def functions(t_s):
    return np.stack([np.sin(0.01 * t_s), np.exp(-1e-3 * t_s), 3.0 + 0.0 * t_s], axis=-1)


TABLE = table_of(functions, -30.0, PIECE_S, 40)


def test_a_table_is_its_functions():
    """At times drawn at random, to rounding; of a column as of each time."""
    t_s = np.random.default_rng(2).uniform(-30.0, 2370.0, 500)
    found = [[interpolate(TABLE, i, t) for i in range(3)] for t in t_s.tolist()]
    np.testing.assert_allclose(found, functions(t_s), rtol=0.0, atol=3e-14)
    columns = [interpolate(TABLE, i, t_s) for i in range(3)]
    np.testing.assert_array_equal(np.transpose(found), columns)


def test_beyond_a_table_its_end_pieces_go_on():
    """Before it, after it, and at a time that is no number."""
    before, after = (interpolate(TABLE, 2, t_s) for t_s in (-31.0, 2371.0))
    assert before == pytest.approx(3.0, rel=1e-12)
    assert after == pytest.approx(3.0, rel=1e-12)
    assert math.isnan(interpolate(TABLE, 2, math.nan))


class Tabled(BodyTorque):
    """A torque that swings, by a table."""

    name = 'tabled'

    class Constants(NamedTuple):
        size: float
        table: Table

    @staticmethod
    def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        swing = constants.size * interpolate(constants.table, 0, t_s)
        return swing * q_ib[3], 0.0, swing * interpolate(constants.table, 1, t_s)


class Direct(BodyTorque):
    """The same by its functions."""

    name = 'direct'

    class Constants(NamedTuple):
        size: float

    @staticmethod
    def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        swing = constants.size * math.sin(0.01 * t_s)
        return swing * q_ib[3], 0.0, swing * math.exp(-1e-3 * t_s)


def test_a_torque_of_a_table_flies_as_that_of_its_functions():
    """One motion, and many that began at other times; steps end where pieces do."""
    t_s = np.linspace(0.0, 1000.0, 11)
    state = State(np.array([0.0, 0.0, 0.0, 1.0]), np.array([0.01, 0.02, 0.0]))
    inertia = np.diag([3.0, 2.0, 4.0])
    tabled, direct = (
        [
            Propagation(System(inertia, torques=(torque(1e-3 * (1 + i)),)), state, 100.0 * i)
            for i in range(10)
        ]
        for torque in (
            lambda size: Tabled(Tabled.Constants(size, TABLE)),
            lambda size: Direct(Direct.Constants(size)),
        )
    )
    assert tabled[0].stop_times_s[:2].tolist() == [30.0, 90.0]
    for beside, alone, right in zip(propagate_all(tabled, t_s), tabled, direct, strict=True):
        assert isinstance(beside, States)
        true = right.at(t_s).q_ib
        # The error of a thousand steps at 1e-13, grown by the turns.
        assert np.max(rotation.angle_between(alone.at(t_s).q_ib, true)) < 1e-10
        assert np.max(rotation.angle_between(beside.q_ib, true)) < 1e-10
