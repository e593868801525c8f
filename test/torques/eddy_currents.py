"""A torque of the environment in one file: of the currents that turning in the field induces."""

from typing import Any, NamedTuple

from satdyn_ros.base.key import Key
from satdyn_ros.kernel.time_table import NO_TABLE, interpolate_vector
from satdyn_ros.kernel.vector import cross, scale, to_body
from satdyn_ros.torques.environment_torque import EnvironmentTorque


class EddyCurrents(EnvironmentTorque):
    """The torque k (omega x B) x B of a conducting shell; the field itself counts as steady."""

    name = 'eddy_currents'
    title = 'torque of eddy currents'
    needs = 'environment.magnetic_field'
    keys = (Key('body.eddy_currents', 'double', 0.0, '', 'k [A m^2 s/T]', low=0.0),)

    class Constants(NamedTuple):
        k: float
        field: Any

    @classmethod
    def along(cls, values, environment):
        constants = cls.Constants(values['body.eddy_currents'], NO_TABLE)
        return cls(constants, {'field': environment.magnetic_field})

    @staticmethod
    def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        B = to_body(q_ib, interpolate_vector(constants.field, 0, t_s))
        return cross(scale(constants.k, cross(omega_bi_b, B)), B)
