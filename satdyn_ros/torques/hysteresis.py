"""
Rods of soft magnetic material, whose hysteresis in the Earth's field damps the motion.

A rod along a is in the field H = a . B / mu_0.  Of its loop the middle curve has L = H, and those
of a field that rises and falls have L = H -+ Hc, where L = tan(pi b / (2 Bs)) / k is what the flux
density b in the rod says, k = tan(pi Br / (2 Bs)) / Hc.  From any point in the loop L goes by

    L' = (q0 + (1 - q0) |x|^p) H',    x = (H - L +- Hc) / (2 Hc), + where H' >= 0

so that on either curve, where |x| = 1, it goes along with H.  The torque is (V / mu_0) b a x B.
Corners are where H' changes its sign.  No eddy currents, no field of the magnet or of another rod.

Flatley and Henretty, A magnetic hysteresis model, NASA GSFC flight mechanics symposium, 1995.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..kernel.functions import atan, exp, log, select
from ..kernel.time_table import NO_TABLE, Table, interpolate_vector
from ..kernel.vector import add, cross, dot, scale, to_body
from ..orbits.along_orbit import AlongOrbit
from ..orbits.pieces import Pieces
from .environment_torque import EnvironmentTorque, PartQuantity, PartsTopic
from .rods import KEYS_OF_A_ROD, ROD_NAMES, Rod, checks_of_rods, rods_of

# The magnetic constant [N/A^2] (CODATA 2022): that of a library would change with its version.
MU_0 = 1.25663706127e-6


class RodConstants(NamedTuple):
    """
    The constants of a rod.

    Attributes
    ----------
    axis : (3,), body axes
        unit vector
    size : A m^2/T
        V / mu_0
    level : T
        2 Bs / pi
    steepness : m/A
        k
    coercive_force : A/m
        Hc
    per_width : m/A
        1 / (2 Hc)
    minor_slope : float
        q0
    powers : tuple of float
        the exponent, none: 2
    """

    axis: tuple[float, ...]
    size: float
    level: float
    steepness: float
    coercive_force: float
    per_width: float
    minor_slope: float
    powers: tuple[float, ...]

    @classmethod
    def of(cls, rod: Rod) -> 'RodConstants':
        """Return those of a rod."""
        return cls(
            axis=tuple(rod.axis),
            size=rod.volume / MU_0,
            level=2.0 * rod.saturation / math.pi,
            steepness=math.tan(0.5 * math.pi * rod.remanence / rod.saturation)
            / rod.coercive_force,
            coercive_force=rod.coercive_force,
            per_width=0.5 / rod.coercive_force,
            minor_slope=rod.minor_slope,
            powers=() if rod.exponent == 2.0 else (rod.exponent,),
        )


class Hysteresis(EnvironmentTorque):
    """
    The torque (V / mu_0) b a x B of hysteresis rods in the field B along the orbit.

    Parameters
    ----------
    rods : sequence of Rod
        in their order
    field : Pieces
        B [T], inertial axes, with its derivatives

    Attributes
    ----------
    states : sequence of str
        names of the variables, L [A/m] of each rod
    """

    name = 'hysteresis'
    title = 'torque of hysteresis rods'
    needs = 'environment.magnetic_field'
    keys = (ROD_NAMES,)
    of_each = KEYS_OF_A_ROD
    checks = staticmethod(checks_of_rods)
    parts = PartsTopic(
        'hysteresis',
        'of hysteresis rods: the flux density in them as position [T] and the field along them as '
        'effort [A/m]; with hysteresis.names',
        'flux density in rods',
        'T',
        (
            PartQuantity(
                'position',
                'flux_density_t',
                lambda torque, states: torque.flux_densities(states.inner),
            ),
            PartQuantity(
                'effort',
                'field_a_m',
                lambda torque, states: torque.fields(states.magnetic_field_b),
            ),
        ),
    )

    class Constants(NamedTuple):
        """field: B along the orbit [T], inertial axes, and its derivative [T/s]."""

        rods: tuple[RodConstants, ...]
        field: Table

    def __init__(self, rods: Sequence[Rod], field: Pieces):
        constants = self.Constants(tuple(map(RodConstants.of, rods)), NO_TABLE)
        super().__init__(constants, {'field': field})
        self.states = tuple(rod.name for rod in rods)

    @classmethod
    def along(cls, values: Mapping[str, Any], environment: AlongOrbit) -> 'Hysteresis':
        """Return the torque of the rods that a scenario describes."""
        return cls(rods_of(values), environment.magnetic_field_and_rate)

    @staticmethod
    def initial(
        t_s: float,
        r_i: tuple[float, ...],
        v_i: tuple[float, ...],
        q_ib: tuple[float, ...],
        omega_bi_b: tuple[float, ...],
        constants: Any,
    ) -> tuple[float, ...]:
        """Return L = H: on the middle curve."""
        B = to_body(q_ib, interpolate_vector(constants.field, 0, t_s))
        return tuple(_along(rod, B) for rod in constants.rods)

    @staticmethod
    def scales(constants: Any) -> tuple[float, ...]:
        """Return a hundred times Hc of each rod, which forgets errors as its field turns."""
        return tuple(100.0 * rod.coercive_force for rod in constants.rods)

    @staticmethod
    def torque(
        t_s: float,
        r_i: tuple[float, ...],
        v_i: tuple[float, ...],
        q_ib: tuple[float, ...],
        omega_bi_b: tuple[float, ...],
        constants: Any,
        states: tuple[float, ...],
    ) -> tuple[float, ...]:
        """Return sum (V / mu_0) b a x B."""
        B = to_body(q_ib, interpolate_vector(constants.field, 0, t_s))
        dipole: tuple[Any, ...] = (0.0, 0.0, 0.0)
        for rod, L in zip(constants.rods, states, strict=True):
            dipole = add(dipole, scale(rod.size * _flux_density(rod, L), rod.axis))
        return cross(dipole, B)

    @staticmethod
    def rates(
        t_s: float,
        r_i: tuple[float, ...],
        v_i: tuple[float, ...],
        q_ib: tuple[float, ...],
        omega_bi_b: tuple[float, ...],
        constants: Any,
        states: tuple[float, ...],
    ) -> tuple[float, ...]:
        """Return L' of each rod [A/m/s]."""
        B = to_body(q_ib, interpolate_vector(constants.field, 0, t_s))
        B_dot = _field_rate(t_s, q_ib, omega_bi_b, constants)
        found = []
        for rod, L in zip(constants.rods, states, strict=True):
            H, H_dot = _along(rod, B), _along(rod, B_dot)
            side = select(H_dot >= 0.0, rod.coercive_force, -rod.coercive_force)
            x = rod.per_width * (H - L + side)
            growth = x * x
            for power in rod.powers:
                growth = exp(power * log(abs(x)))
            found.append((rod.minor_slope + (1.0 - rod.minor_slope) * growth) * H_dot)
        return tuple(found)

    @staticmethod
    def signs(
        t_s: float,
        r_i: tuple[float, ...],
        v_i: tuple[float, ...],
        q_ib: tuple[float, ...],
        omega_bi_b: tuple[float, ...],
        constants: Any,
        states: tuple[float, ...],
    ) -> tuple[float, ...]:
        """Return H' of each rod: where it changes its sign, the curve is another."""
        B_dot = _field_rate(t_s, q_ib, omega_bi_b, constants)
        return tuple(_along(rod, B_dot) for rod in constants.rods)

    def flux_densities(self, inner: Any) -> np.ndarray:
        """Return b [T] (N, n) of the rods, of inner coordinates (N,) by their names."""
        # What a live page hears has none.
        L = (np.atleast_1d(inner.get(name, np.nan)) for name in self.inner_names)
        return np.stack([*map(_flux_density, self.constants.rods, L)], axis=-1)

    def curve(self, i: int, side: float, H: np.ndarray) -> np.ndarray:
        """Return b [T] (N,) on a curve of the large loop of rod i; side: 1: where H grows."""
        rod = self.constants.rods[i]
        return _flux_density(rod, H - side * rod.coercive_force)

    def fields(self, B_b: np.ndarray) -> np.ndarray:
        """Return H [A/m] (N, n) along the rods in fields (N, 3) [T], body axes."""
        return np.stack([_along(rod, tuple(B_b.T)) for rod in self.constants.rods], axis=-1)


def _field_rate(t_s, q_ib, omega_bi_b, constants):
    """Return the derivative of the field in body axes [T/s]."""
    B = to_body(q_ib, interpolate_vector(constants.field, 0, t_s))
    B_i_dot = interpolate_vector(constants.field, 3, t_s)
    return add(cross(B, omega_bi_b), to_body(q_ib, B_i_dot))


def _along(rod, B):
    return dot(rod.axis, B) * (1.0 / MU_0)


def _flux_density(rod, L):
    return rod.level * atan(rod.steepness * L)
