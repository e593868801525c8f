"""
Regular precession: omega = mu f + nu e, both rates and the angle between the axes constant.

The body turns at mu about its axis f, which turns at nu about the fixed e: the cone of the
instantaneous axis in the body rolls on that in space (textbook, section 43).
"""

from dataclasses import dataclass

import numpy as np

from ..dynamics import inertia
from ..dynamics.inertia import ROUNDING
from ..dynamics.system import State, System
from ..dynamics.torque import angular_momentum
from ..kernel import rotation
from .equilibria import imbalance


@dataclass(frozen=True, eq=False)
class RegularPrecession:
    """
    A regular precession by its rates and its nutation.

    Attributes
    ----------
    axis_b : (3,), body axes
        of the spin
    axis_i : (3,), inertial axes
        of the precession
    spin : rad/s
        mu, about axis_b
    precession : rad/s
        nu, of axis_b about axis_i
    nutation : rad
        0 to pi
    """

    axis_b: np.ndarray
    axis_i: np.ndarray
    spin: float
    precession: float
    nutation: float

    @property
    def sense(self) -> str | None:
        """Return 'progressive' or 'retrograde' as mu nu cos(nutation) is > 0 or < 0, or None."""
        product = self.spin * self.precession * np.cos(self.nutation)
        if product == 0.0:
            return None
        return 'progressive' if product > 0.0 else 'retrograde'

    @property
    def body_cone(self) -> float:
        """Return the half-angle of the instantaneous axis about axis_b [rad], 0 to pi/2."""
        across = abs(self.precession) * np.sin(self.nutation)
        return float(np.arctan2(across, abs(self._along_body_axis)))

    @property
    def space_cone(self) -> float:
        """Return the half-angle of the instantaneous axis about axis_i [rad], 0 to pi/2."""
        across = abs(self.spin) * np.sin(self.nutation)
        return float(np.arctan2(across, abs(self._along_fixed_axis)))

    @property
    def cones(self) -> str:
        """
        Return how the cones lie: which rolls on the outside or inside of which.

        'external', 'body cone inside', 'space cone inside', or 'plane' where one is a plane.  A
        retrograde precession alone does not make one internal.
        """
        fixed = self.precession * self._along_fixed_axis
        moving = self.spin * self._along_body_axis
        if fixed == 0.0 or moving == 0.0:
            return 'plane'
        if fixed < 0.0:
            return 'body cone inside'
        return 'space cone inside' if moving < 0.0 else 'external'

    @property
    def _along_body_axis(self):
        return self.spin + self.precession * np.cos(self.nutation)

    @property
    def _along_fixed_axis(self):
        return self.precession + self.spin * np.cos(self.nutation)


def regular_precession(
    system: System, state: State, orbit_s: float = 0.0
) -> RegularPrecession | None:
    """
    Return the regular precession that starts in a state, None for any other motion.

    f is the symmetry axis of body, rotor and weight.  e is the angular momentum where the field
    exerts no torque on the body in any attitude, the direction of a fixed field, or the normal of
    a circular orbit, where nu is the orbital rate (the hyperbolic and conical equilibria).  With f
    and e aligned the whole rate counts as spin.

    Parameters
    ----------
    system : System
        what moves
    state : State
        its state
    orbit_s : s
        time from tick 0
    """
    f = symmetry_axis(system, state)
    e = _fixed_axis(system, state, orbit_s)
    if f is None or e is None or not system.is_newtonian:
        return None
    omega, size = state.omega_bi_b, np.linalg.norm(state.omega_bi_b)
    along, across = e @ f, np.cross(e, f)
    axis_i = rotation.rotate(state.q_ib, e)
    square = across @ across
    nutation = float(np.arctan2(np.sqrt(square), along))
    if square <= ROUNDING**2:
        steady = np.linalg.norm(np.cross(omega, f)) <= ROUNDING * size
        return RegularPrecession(f, axis_i, float(omega @ f), 0.0, nutation) if steady else None
    # omega = mu f + nu e + (rate of nutation) e x f
    nu = (omega - (omega @ f) * f) @ (e - along * f) / square
    mu = omega @ f - along * nu
    if abs(omega @ across) > ROUNDING * size * np.sqrt(square):
        return None
    if system.orbit.is_keplerian and feels_field(system):
        rate = system.orbit.mean_motion
        if abs(nu - rate) > ROUNDING * rate:
            return None
    # e x f stays, so that omega' is mu e' = mu nu e x f in body axes.
    K = system.carrier_inertia
    needed = K @ (mu * nu * across)
    H = angular_momentum(system, omega, state.rotor_speed)
    gradient = abs(float(system.orbit.gradient_at(orbit_s))) * np.max(system.inertia)
    torques = np.linalg.norm(H) * size + gradient + np.linalg.norm(system.weight_moment)
    if np.linalg.norm(imbalance(system, state, orbit_s) - needed) > ROUNDING * torques:
        return None
    return RegularPrecession(f, axis_i, float(mu), float(nu), nutation)


def symmetry_axis(system: System, state: State) -> np.ndarray | None:
    """Return the axis (3,) about which body, rotors and weight are symmetric, or None."""
    vectors = (system.weight_moment, system.rotor_momentum(state))
    return inertia.symmetry_axis((system.inertia, system.carrier_inertia), vectors)


def _fixed_axis(system, state, orbit_s):
    """Return the axis (3,) about which the surroundings are symmetric, in body axes, or None."""
    if not feels_field(system):
        H = angular_momentum(system, state.omega_bi_b, state.rotor_speed)
        return H / np.linalg.norm(H) if np.any(H) else None
    to_body = rotation.conjugate(state.q_ib)
    if not system.orbit.has_lvlh:
        return rotation.rotate(to_body, system.orbit.direction(orbit_s))
    is_circle = system.orbit.is_keplerian and not system.orbit.is_eccentric
    if is_circle and not np.any(system.weight_moment):
        return rotation.rotate(to_body, system.orbit.normal)
    return None


def feels_field(system: System) -> bool:
    """Whether weight or gravity gradient exert a torque in any attitude."""
    I = system.inertia
    spherical = np.max(np.abs(I - np.trace(I) / 3.0 * np.eye(3))) <= ROUNDING * np.max(I)
    gradient = float(system.orbit.gradient_at(0.0)) != 0.0
    return bool(np.any(system.weight_moment)) or (gradient and not spherical)
