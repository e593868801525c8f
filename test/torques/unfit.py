"""Torques that are none, each for one reason; two that are wrong where they are computed."""

import math
from typing import NamedTuple

import numpy as np

from satdyn_ros.torques import BodyTorque, Key


class Base(BodyTorque):
    class Constants(NamedTuple):
        pass


class Good(Base):
    @staticmethod
    def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        return 0.0 * t_s, 0.0, 0.0


class NoName(Good):
    pass


class NoConstants(BodyTorque):
    name = 'no_constants'
    torque = Good.torque


class PlainConstants(NoConstants):
    Constants = tuple


class NoTorque(Base):
    name = 'no_torque'


class Method(Base):
    name = 'method'

    def torque(self, t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        return 0.0, 0.0, 0.0


class FewArguments(Base):
    name = 'few_arguments'

    @staticmethod
    def torque(t_s, q_ib, constants):
        return 0.0, 0.0, 0.0


class FewForSigns(Good):
    name = 'few_for_signs'

    @staticmethod
    def signs(t_s):
        return (t_s,)


class TextKeys(Good):
    name = 'text_keys'
    keys = ('text_keys.size',)  # type: ignore[assignment]


class ForeignKey(Good):
    name = 'foreign_key'
    keys = (Key('size', 'double', 0.0, '', ''),)


class Topic(Good):
    name, topic = 'topic', 'a b'


class OfRaises(Good):
    name = 'of_raises'

    @classmethod
    def of(cls, values):
        return cls(values['size'])


class OfRefuses(Good):
    name = 'of_refuses'

    @classmethod
    def of(cls, values):
        return cls(math.sqrt(-1.0))


class OfNumber(Good):
    name = 'of_number'

    @classmethod
    def of(cls, values):
        return 5


class NoKey(Good):
    name = 'no_key'

    class Constants(NamedTuple):
        size: float


class Text(NoKey):
    name = 'text'
    keys = (Key('text.size', 'string', '5', '', ''),)


class Thing(NoKey):
    name = 'thing'

    @classmethod
    def of(cls, values):
        return cls(cls.Constants(None))  # type: ignore[arg-type]


class Stops(Good):
    name = 'stops'

    def stops(self):
        return np.zeros((2, 2))


# -- wrong where they are compiled ----------------------------------------------------------------


class Two(Base):
    name = 'two'

    @staticmethod
    def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        return 0.01 + 0.0 * t_s, 0.0 * t_s


class Array(Base):
    name = 'array'

    @staticmethod
    def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        return np.array([0.01, 0.0, t_s])


class Nothing(Base):
    name = 'nothing'

    @staticmethod
    def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        pass


class Product(Base):
    name = 'product'

    @staticmethod
    def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        return r_i * 2.0


class Import(Base):
    name = 'import_'

    @staticmethod
    def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        import numpy

        return numpy.sin(t_s), 0.0, 0.0


class Field(Base):
    name = 'field'

    @staticmethod
    def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        return constants.size, 0.0, 0.0


# -- wrong where they are computed ----------------------------------------------------------------


class NoNumber(Base):
    name = 'no_number'

    @staticmethod
    def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        return 1e-3 * math.sqrt(3.5 - t_s), 0.0, 0.0


class Chooses(Base):
    name = 'chooses'

    @staticmethod
    def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        if t_s > 1.0:
            return 0.0, 0.0, 0.0
        return 1e-3, 0.0, 0.0
