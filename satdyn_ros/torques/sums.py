"""
What the equations take from all torques at once.

torques: a tuple of Constants, whose types say which torques they are.  seen: what a torque is a
function of beside its constants, (t_s, r_i, v_i, q_ib, omega_bi_b), and then the variables of all
torques that have any, one behind the other.
"""

from collections.abc import Iterator
from typing import Any

from ..kernel.vector import Vector, add
from .body_torque import KIND_OF, scales_of
from .central_torque import CentralTorque
from .own_function import function_of


def _functions(
    torques: tuple[Any, ...], name: str, is_central: bool | None = None
) -> Iterator[tuple[Any, Any]]:
    """Yield a function of the torques that have it, or of the central or others, and constants."""
    for constants in torques:
        kind = KIND_OF[type(constants)]
        is_asked = is_central is None or issubclass(kind, CentralTorque) == is_central
        if is_asked and getattr(kind, name) is not None:
            yield function_of(kind, name), constants


def _found(
    torques: tuple[Any, ...], name: str, seen: tuple[Any, ...], is_central: bool | None = None
) -> Iterator[Any]:
    """Yield what a function returns of those torques that have it, or of some of them."""
    *seen_by_all, variables = seen
    end = 0
    for constants in torques:
        kind = KIND_OF[type(constants)]
        begin, end = end, end + (0 if kind.rates is None else len(scales_of(constants)))
        is_asked = is_central is None or issubclass(kind, CentralTorque) == is_central
        if is_asked and getattr(kind, name) is not None:
            own = () if kind.rates is None else (variables[begin:end],)
            yield function_of(kind, name)(*seen_by_all, constants, *own)


def rates_of_states(torques: tuple[Any, ...], seen: tuple[Any, ...]) -> Vector:
    """Return the rates of the variables of all torques, one behind the other."""
    found: list[Any] = []
    own = [constants for constants in torques if KIND_OF[type(constants)].rates is not None]
    for constants, rates in zip(own, _found(torques, 'rates', seen), strict=True):
        count = len(scales_of(constants))
        if len(rates) != count:
            raise ValueError(
                f'the torque {KIND_OF[type(constants)].full_name()}: its rates returns a tuple of '
                f'{len(rates)}; it must return a tuple of {count} numbers'
            )
        found += rates
    return tuple(found)


def sum_of_torques(torques: tuple[Any, ...], seen: tuple[Any, ...]) -> Vector:
    """Return the torque [N m] of all but the central ones."""
    total: Vector = (0.0, 0.0, 0.0)
    for torque in _found(torques, 'torque', seen, False):
        total = add(total, torque)
    return total


def sum_of_forces(torques: tuple[Any, ...], seen: tuple[Any, ...]) -> Vector:
    """Return the force [N] of those that have one."""
    total: Vector = (0.0, 0.0, 0.0)
    for force in _found(torques, 'force', seen):
        total = add(total, force)
    return total


def sum_of_potentials(torques: tuple[Any, ...], seen: tuple[Any, ...]) -> Any:
    """Return the potential [J] of those that have one."""
    total: Any = 0.0
    for potential in _found(torques, 'potential', seen):
        total = total + potential
    return total


def sum_of_fields(torques: tuple[Any, ...], c_b: Vector, gradient: Any) -> Vector:
    """Return the field [N m] of the central torques."""
    total: Vector = (0.0, 0.0, 0.0)
    for field, constants in _functions(torques, 'field', True):
        total = add(total, field(c_b, gradient, constants))
    return total


def sum_of_orbit_powers(
    torques: tuple[Any, ...],
    c_b: Vector,
    along_b: Vector,
    gradient: Any,
    turn_rate: Any,
    growth_rate: Any,
) -> Any:
    """Return what the orbit does on the central torques [W]."""
    total: Any = 0.0
    for power, constants in _functions(torques, 'orbit_power', True):
        total = total + power(c_b, along_b, gradient, turn_rate, growth_rate, constants)
    return total


def signs_of(torques: tuple[Any, ...], seen: tuple[Any, ...]) -> Vector:
    """Return the signs of all torques, which are zero at their corners, one behind the other."""
    return tuple(sign for signs in _found(torques, 'signs', seen) for sign in signs)
