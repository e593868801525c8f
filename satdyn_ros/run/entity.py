"""
The satellite as an entity of a simulator, as simulation_interfaces (REP 410) sees one.

There a pose and a twist are in the axes of one frame; here the body rate is in body axes.
"""

import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..dynamics.motion import States
from ..kernel import rotation

# The bits of the scope of a reset; 0 is all of them.
_TIME, _STATE = 1, 2


@dataclass(frozen=True, eq=False)
class EntityState:
    """
    Where an entity is and how it moves, all in inertial axes.

    position (3,) [m]; q_ib (4,); velocity (3,) [m/s]; rate (3,) [rad/s], omega_bi_i.
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


def matching(name: str, pattern: str) -> list[str]:
    """Return the names of entities, of which there is one, that a regular expression finds."""
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
    return f'nothing of the scope {scope} can be reset; allowed: SCOPE_STATE'
