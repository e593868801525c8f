"""
What a mode of a part that moves inside the body is: one class, from which all else follows.

With the modal coordinate eta and the coupling d, the kinetic energy is (omega . I omega) / 2 +
sum (omega . d) eta' + sum eta'^2 / 2.  The momentum pi = eta' + d . omega is integrated, as that
of a rotor is:

    pi' = -spring(eta) - friction(eta'),    eta' = pi - d . omega

The body then moves as one with the inertia I - sum d d^T and the momentum sum pi d.  A rotor is
the mode without a spring, with d = sqrt(J) a.  Changes of the inertia with eta and centrifugal
stiffening are left out, and so is what thrusters and gravity do to eta.

Likins, Dynamics and Control of Flexible Space Vehicles, JPL 32-1329, 1970.
"""

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from ..base.key import Key
from ..base.sentences import Checks
from ..kernel.rows import dot

# Of any mode, after what a kind says of its own.
_COUPLING = Key(
    'coupling',
    'double_array',
    (0.0, 0.0, 0.0),
    'sqrt(kg) m',
    'rotational participation about the mass centre, body axes',
    lengths=(3,),
)
_INITIAL = (
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
    *_, name, leaf = words = inner.split('.')
    is_of_a_mode = len(words) == 3 and leaf in _UNITS
    return f'{name}_{leaf}_{_UNITS[leaf]}' if is_of_a_mode else '_'.join(words)


class InnerMode:
    """
    A mode; each kind is a subclass, a frozen dataclass in a file beside this one.

    Attributes
    ----------
    names : Key
        names those of a scenario
    keys : tuple of Key
        what it says of one beside what all have, by their last words: the names of its fields
    says : str
        what the modes are of
    name : str
        as in names
    coupling : (3,), sqrt(kg) m, body axes
        d
    frequency : rad/s
        of small swings, with the body held against rotation and free to translate
    """

    names: ClassVar[Key]
    keys: ClassVar[tuple[Key, ...]] = ()
    says: ClassVar[str]
    name: str
    coupling: np.ndarray
    frequency: Any

    @property
    def constants(self) -> Any:
        """
        What the equations need: a NamedTuple with coupling and three functions.

        They are of floats, symbols and columns: spring(eta) and friction(rate) [sqrt(kg) m/s^2],
        and frequency() [rad/s], by which errors of eta are compared to those of its rate.
        """
        raise NotImplementedError

    @property
    def is_damped(self) -> bool:
        """Whether its motion loses energy."""
        raise NotImplementedError

    def stretch(self, eta: Any) -> Any:
        """Return the root of twice the energy in the spring [sqrt(J)]."""
        raise NotImplementedError

    @classmethod
    def checks(cls, values: Mapping[str, Any]) -> Checks:
        """Check what the values of a scenario may not be together."""
        yield from ()

    @classmethod
    def group(cls) -> str:
        """Return the first word of the keys."""
        return cls.names.name.partition('.')[0]

    @classmethod
    def of_each(cls) -> tuple[Key, ...]:
        """Return the keys that describe one, by their last words."""
        return *cls.keys, _COUPLING, *_INITIAL

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> list['InnerMode']:
        """Return the modes of this kind that a scenario's values describe."""
        kind: Any = cls
        found = []
        for name in values[cls.names.name]:
            prefix = f'{cls.group()}.{name}'
            own = {key.name: values[f'{prefix}.{key.name}'] for key in cls.keys}
            coupling = np.array(values[f'{prefix}.coupling'])
            found.append(kind(name=name, coupling=coupling, **own))
        return found

    @property
    def displacement_name(self) -> str:
        """Return the name of eta [sqrt(kg) m] among the inner coordinates, that of its key."""
        return f'{self.group()}.{self.name}.displacement'

    @property
    def rate_name(self) -> str:
        """Return the name of eta' [sqrt(kg) m/s] among the inner coordinates, that of its key."""
        return f'{self.group()}.{self.name}.rate'

    def along(self, omega_bi_b: np.ndarray) -> np.ndarray:
        """Return d . omega of body rates (..., 3), which pi has beside eta'."""
        return dot(np.asarray(omega_bi_b, float), self.coupling)
