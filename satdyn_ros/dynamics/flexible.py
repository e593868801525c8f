"""
Flexible parts by their modes, in hybrid coordinates: panels, antennas, booms, and fuel.

With the frequency W of the body held against rotation and the damping ratio z, the potential
energy is sum W^2 eta^2 / 2, the spring W^2 eta and the friction 2 z W eta' (inner_mode.py).

Likins, Dynamics and Control of Flexible Space Vehicles, JPL 32-1329, 1970.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from ..base.key import Key
from ..base.sentences import Checks
from ..kernel.functions import sqrt
from .inner_mode import InnerMode


class ModeConstants(NamedTuple):
    """The constants of a flexible mode; stiffness [1/s^2]: W^2, damping [1/s]: 2 z W."""

    coupling: Any
    stiffness: float
    damping: float

    def spring(self, eta: Any) -> Any:
        """Return W^2 eta."""
        return self.stiffness * eta

    def friction(self, rate: Any) -> Any:
        """Return 2 z W eta'."""
        return self.damping * rate

    def frequency(self) -> Any:
        """Return W."""
        return sqrt(self.stiffness)


@dataclass(frozen=True, eq=False)
class Mode(InnerMode):
    """
    A mode of a flexible part.

    name; frequency [rad/s]: W, with the body held against rotation and free to translate; damping:
    the ratio z; coupling [sqrt(kg) m] (3,): d, body axes.
    """

    names = Key(
        'flexible.names',
        'string_array',
        (),
        '',
        'names of the modes of flexible parts, each described by flexible.NAME.frequency and '
        'so on; body.inertia includes them, locked',
    )
    keys = (
        Key(
            'frequency',
            'double',
            0.0,
            'rad/s',
            'natural frequency, with the body held against rotation and free to translate; above '
            '0',
            low=0.0,
            trade='rev/s',
        ),
        Key('damping', 'double', 0.0, '', 'damping ratio, relative to critical damping', low=0.0),
    )
    says = 'the modes of flexible parts'

    name: str
    frequency: float = 1.0
    damping: float = 0.0
    coupling: np.ndarray = field(default_factory=lambda: np.zeros(3))

    @property
    def constants(self) -> ModeConstants:
        """The constants in the equations."""
        W = self.frequency
        return ModeConstants(self.coupling, W * W, 2.0 * self.damping * W)

    @property
    def is_damped(self) -> bool:
        """Whether its motion loses energy."""
        return bool(np.count_nonzero(self.damping))

    def stretch(self, eta: Any) -> Any:
        """Return W eta."""
        return self.frequency * eta

    @classmethod
    def checks(cls, values: Mapping[str, Any]) -> Checks:
        """Check that modes swing."""
        for name in (f'{cls.group()}.{name}.frequency' for name in values[cls.names.name]):
            if (yield np.asarray(values[name]) == 0.0):
                raise ValueError(f'{name} is 0; it must be above 0 rad/s')
