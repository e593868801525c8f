"""What a torque on the body is: one class, from which all else follows."""

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from ..base.key import Key
from ..kernel.compile import inlined
from ..kernel.unroll import fold_by_type
from ..kernel.vector import add


class BodyTorque:
    """
    A torque on the body; each kind is a subclass.

    name: the beginning of its keys, of its topic and of its columns.  keys: what a scenario says
    of it.  Constants: a NamedTuple of floats, tuples of floats and arrays, from which the torque
    is computed.  is_steady: whether it depends on attitude and rate alone, as seen from axes that
    turn with a circular orbit.

    torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants) -> (x, y, z) [N m], body axes, is compiled:
    t_s are seconds from tick 0, r_i [m] and v_i [m/s] the place on the orbit, zero without one.
    It is computed for many motions side by side as well, where its arguments are SIMD vectors: it
    may use arithmetic, comparisons, min, max and the functions of math, and chooses by
    kernel.simd.select where another function would by if.

    >>> class Push(BodyTorque):
    ...     name = 'push'
    ...     class Constants(NamedTuple):
    ...         size: float
    ...     @staticmethod
    ...     def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
    ...         return constants.size, 0.0, 0.0
    >>> Push(Push.Constants(0.1)).name
    'push'
    """

    name: ClassVar[str]
    keys: ClassVar[tuple[Key, ...]] = ()
    is_steady: ClassVar[bool] = False
    Constants: ClassVar[Any]

    def __init__(self, constants: Any):
        self.constants = constants

    def __init_subclass__(cls) -> None:
        _ADDED[cls.Constants] = _adding(cls.torque)

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> 'BodyTorque | None':
        """
        Return the torque of a scenario's values by their names; None: it does not act.

        By default each field of Constants is the key of its name, after the name of the torque.
        """
        given = (values[f'{cls.name}.{field}'] for field in cls.Constants._fields)
        return cls(cls.Constants(*given))

    @staticmethod
    def torque(
        t_s: float,
        r_i: tuple[float, ...],
        v_i: tuple[float, ...],
        q_ib: tuple[float, ...],
        omega_bi_b: tuple[float, ...],
        constants: Any,
    ) -> tuple[float, ...]:
        """Return the torque [N m] in body axes."""
        raise NotImplementedError

    def stops(self) -> np.ndarray:
        """Return the times [s] from tick 0 at which it is not smooth, where steps end, (K,)."""
        return np.zeros(0)


# By the class of their constants, compiled functions that add a torque to a total.
_ADDED: dict[type, Any] = {}


def _adding(torque):
    body = inlined(torque)

    @inlined
    def added(total, t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        return add(total, body(t_s, r_i, v_i, q_ib, omega_bi_b, constants))

    return added


add_torques = fold_by_type(lambda constants: _ADDED[constants])
