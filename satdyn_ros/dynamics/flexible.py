"""
Flexible parts by their modes, in hybrid coordinates: panels, antennas, booms, and fuel.

With the modal coordinate eta, the coupling d and the frequency W of the body held against
rotation, the kinetic energy is (omega . I omega) / 2 + sum (omega . d) eta' + sum eta'^2 / 2 and
the potential energy sum W^2 eta^2 / 2.  The momentum pi = eta' + d . omega is integrated, as that
of a rotor is:

    pi' = -W^2 eta - 2 z W eta',    eta' = pi - d . omega

The body then moves as one with the inertia I - sum d d^T and the momentum sum pi d.  A rotor is
the mode without a spring, with d = sqrt(J) a.  Linear in eta: changes of the inertia and
centrifugal stiffening are left out, and so is what thrusters and gravity do to eta.

Likins, Dynamics and Control of Flexible Space Vehicles, JPL 32-1329, 1970.
"""

from dataclasses import dataclass, field

import numpy as np

from ..base.key import Key
from ..kernel.rows import dot

MODE_NAMES = Key(
    'flexible.names',
    'string_array',
    (),
    '',
    'names of the modes of flexible parts, each described by flexible.NAME.frequency and '
    'so on; body.inertia includes them, locked',
    is_optional=True,
)
# Of a mode; they follow its name.
KEYS_OF_A_MODE = (
    Key(
        'frequency',
        'double',
        0.0,
        'rad/s',
        'natural frequency, with the body held against rotation and free to translate; above 0',
        low=0.0,
        trade='rev/s',
    ),
    Key('damping', 'double', 0.0, '', 'damping ratio, relative to critical damping', low=0.0),
    Key(
        'coupling',
        'double_array',
        (0.0, 0.0, 0.0),
        'sqrt(kg) m',
        'rotational participation about the mass centre, body axes',
        lengths=(3,),
    ),
    Key('displacement', 'double', 0.0, 'sqrt(kg) m', 'initial modal displacement'),
    Key('rate', 'double', 0.0, 'sqrt(kg) m/s', 'initial rate of the modal displacement'),
)

_UNITS = {'displacement': 'sqrt_kg_m', 'rate': 'sqrt_kg_m_s'}


def column_of(inner: str) -> str:
    """
    Return the column of tables for an inner coordinate.

    >>> column_of('flexible.panel.rate')
    'panel_rate_sqrt_kg_m_s'
    """
    if not inner.startswith('flexible.'):
        return inner.replace('.', '_')
    _, name, leaf = inner.split('.')
    return f'{name}_{leaf}_{_UNITS[leaf]}'


@dataclass(frozen=True, eq=False)
class Mode:
    """
    A mode of a flexible part.

    name; frequency [rad/s]: W, with the body held against rotation and free to translate; damping:
    the ratio z; coupling [sqrt(kg) m] (3,): d, body axes.
    """

    name: str
    frequency: float = 1.0
    damping: float = 0.0
    coupling: np.ndarray = field(default_factory=lambda: np.zeros(3))

    @property
    def displacement_name(self) -> str:
        """Return the name of eta [sqrt(kg) m] among the inner coordinates."""
        return f'flexible.{self.name}.displacement'

    @property
    def rate_name(self) -> str:
        """Return the name of eta' [sqrt(kg) m/s] among the inner coordinates."""
        return f'flexible.{self.name}.rate'

    @property
    def is_damped(self) -> bool:
        """Whether its motion loses energy."""
        return bool(np.count_nonzero(self.damping))

    def along(self, omega_bi_b: np.ndarray) -> np.ndarray:
        """Return d . omega of body rates (..., 3), which pi has beside eta'."""
        return dot(np.asarray(omega_bi_b, float), self.coupling)
