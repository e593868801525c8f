"""A kind of actuators in one file: a bias torque, of which small ones do nothing."""

from types import MappingProxyType
from typing import NamedTuple

from satdyn_ros.actuators.body_vector import ZERO, BodyVector
from satdyn_ros.base.key import Key
from satdyn_ros.torques.body_torque import BodyTorque


class BiasTorque(BodyTorque):
    """A torque that is constant in body axes."""

    name = 'bias'
    is_steady = True

    class Constants(NamedTuple):
        torque_b: tuple[float, float, float]

    @staticmethod
    def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        return constants.torque_b


class Bias(BodyVector):
    """A bias torque [N m] (3,), body axes; a component within bias.dead_band does not act."""

    topic, message = 'bias_command', 'geometry_msgs/msg/Vector3Stamped'
    says = 'bias torque in body axes [N m], of which bias.dead_band does not act'
    words = MappingProxyType({'bias': 'bias_b'})
    quantity = Key('bias', 'double_array', None, 'N m', '', lengths=(3,))
    field, record, limit = 'vector', 'bias_b', 'dead_band'
    acts_on = BiasTorque
    keys = (Key('bias.dead_band', 'double', 0.0, 'N m', 'what does not act', low=0.0),)

    def __init__(self, values, rotors):
        self._least = values['bias.dead_band']
        self.topics, self.none = (self.topic,), {self.topic: ZERO}

    def within(self, name, held):
        return tuple(x if abs(x) > self._least else 0.0 for x in held)

    def torque(self):
        return BiasTorque(BiasTorque.Constants(ZERO))

    def commanded(self, torque, acting):
        return BiasTorque(BiasTorque.Constants(acting[self.topic]))
