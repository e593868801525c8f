"""
The satellite as an entity of a simulator, as simulation_interfaces (REP 410) sees one.

There a pose and a twist are in the axes of one frame; here the body rate is in body axes.
"""

import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..dynamics.equations import rates
from ..dynamics.motion import States
from ..dynamics.system import System
from ..dynamics.variables import Variables, initial_values
from ..integrate.propagation import Propagation
from ..kernel import rotation
from .samples import Samples
from .scenario import Scenario

# The bits of the scope of a reset; 0 is all of them.
_TIME, _STATE = 1, 2
# f'(0) h of f(0), f(h), ... f(4 h), to the fourth order (Abramowitz and Stegun 25.3, one-sided),
# and h by the time in which the position turns by one radian.
_DERIVATIVE = np.array([-25.0, 48.0, -36.0, 16.0, -3.0]) / 12.0
_STEP_RAD = 1e-3


@dataclass(frozen=True, eq=False)
class EntityState:
    """
    Where an entity is and how it moves, all in inertial axes.

    Attributes
    ----------
    position : (3,), m
        from the origin
    q_ib : (4,), x, y, z, w
        attitude, body to inertial
    velocity : (3,), m/s
        of the position
    rate : (3,), rad/s
        omega_bi_i
    """

    position: np.ndarray
    q_ib: np.ndarray
    velocity: np.ndarray
    rate: np.ndarray

    @classmethod
    def of(cls, states: States, row: int) -> 'EntityState':
        """Return the state in a row."""
        q_ib = states.q_ib[row]
        rate = rotation.rotate(q_ib, states.omega_bi_b[row])
        return cls(states.r_i[row], q_ib, states.v_i[row], rate)

    def request(self) -> dict[str, Any]:
        """Return the initial conditions with this attitude and this rate."""
        omega_bi_b = rotation.rotate(rotation.conjugate(self.q_ib), self.rate)
        return {
            'initial.frame': 'inertial',
            'initial.attitude': self.q_ib.tolist(),
            'initial.angular_velocity': omega_bi_b.tolist(),
        }


def accelerations(system: System, states: States, row: int) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the derivatives of v_i [m/s^2] and omega_bi_i [rad/s^2], (3,) each, in inertial axes.

    system: with the torques that act.  The second is that of the equations of motion; the first is
    taken of the orbit, whatever its model, and zero where the direction is fixed.
    """
    orbit_s, q_ib = float(states.orbit_s[row]), states.q_ib[row]
    here = Propagation(system, states[row], orbit_s)
    y = initial_values(system, states[row])
    if system.integrates_anomaly:
        f = states.orbit.anomaly(orbit_s)
        y[Variables.of(system).anomaly] = np.cos(f), np.sin(f)
    omega_dot_b = rates(orbit_s, tuple(y.tolist()), here.constants)[Variables.of(system).rate]
    # d/dt of q omega_b q* is q omega_b' q*: omega x omega is zero.
    angular = rotation.rotate(q_ib, np.array(omega_dot_b))
    if not states.orbit.has_lvlh:
        return np.zeros(3), angular
    r_i, v_i = states.r_i[row], states.v_i[row]
    h_s = _STEP_RAD * float(np.linalg.norm(r_i) / np.linalg.norm(v_i))
    # Backward where that is: a table of the orbit may end just ahead.
    h_s = -h_s if orbit_s > 4.0 * h_s else h_s
    _, velocities = states.orbit.position_velocity(orbit_s + h_s * np.arange(5))
    return _DERIVATIVE @ velocities / h_s, angular


def restarted(conditions: Scenario, samples: Samples, row: int) -> Samples:
    """Return the one row of a motion that restarts from initial conditions at that of samples."""
    orbit_s = float(samples.states.orbit_s[row])
    acting = conditions.equipment.restarted(samples.acting, orbit_s)
    system = conditions.equipment.driven(conditions.system, acting)
    states = Propagation(system, conditions.state_at(orbit_s), orbit_s).at(0.0)
    stamps_ns = samples.stamps_ns[row : row + 1]
    return Samples(samples.first_tick + row, stamps_ns, states, system, acting=acting)


def touches(position: np.ndarray, centre: np.ndarray, radius: float) -> bool:
    """Return whether an entity, a point at position (3,) [m], is in a sphere; ValueError: none."""
    if not (np.all(np.isfinite(centre)) and 0.0 <= radius < np.inf):
        raise ValueError(
            f'the sphere has the radius {radius:g} m and the centre {centre.tolist()}; both must '
            'be finite and the radius at least 0'
        )
    return bool(np.linalg.norm(position - centre) <= radius)


def matching(name: str, pattern: str) -> list[str]:
    """Return the names of entities that a regular expression finds; there is only one entity."""
    try:
        return [name] if re.search(pattern, name) else []
    except re.error as error:
        raise ValueError(f'the filter {pattern!r} is not a regular expression: {error}') from None


def why_not_reset(scope: int) -> str:
    """Return in one sentence why a scope cannot be reset, '': it can."""
    if scope == _STATE:
        return ''
    if scope == 0 or scope & _TIME:
        return 'the time never restarts; the scope SCOPE_STATE restarts the motion'
    return f'the scope {scope} cannot be reset; allowed: SCOPE_STATE'
