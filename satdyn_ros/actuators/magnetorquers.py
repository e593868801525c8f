"""Magnetorquers: a dipole along each body axis, which the field along the orbit turns."""

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar

import numpy as np

from ..base.key import Key
from ..dynamics.rotor import Rotor
from ..torques.magnetic import Magnetic
from .body_vector import ZERO, BodyVector


class Magnetorquers(BodyVector):
    """The dipole of the magnetorquers [A m^2] (3,), body axes, at most max_dipole along each."""

    topic = 'magnetorquer_command'
    message = 'geometry_msgs/msg/Vector3Stamped'
    says = (
        'dipole of the magnetorquers in body axes [A m^2], cut to magnetorquer.max_dipole along '
        'each axis, held until the next one or the timeout; only with magnetorquers'
    )
    words: ClassVar[Mapping[str, str]] = {'magnetorquer': 'dipole_b'}
    quantity = Key('magnetorquer', 'double_array', None, 'A m^2', '', lengths=(3,))
    field, record, limit = 'vector', 'dipole_b', 'max_dipole'
    acts_on = Magnetic
    keys = (
        Key(
            'magnetorquer.max_dipole',
            'double_array',
            ZERO,
            'A m^2',
            'largest dipole of the magnetorquers along each body axis; 0: none along that axis; '
            'larger commands are cut to it',
            lengths=(3,),
            low=0.0,
        ),
    )

    def __init__(self, values: Mapping[str, Any], rotors: tuple[Rotor, ...]):
        self._most = values['magnetorquer.max_dipole']
        self.is_fitted = any(self._most)
        self.topics = (self.topic,) if self.is_fitted else ()
        self.none = dict.fromkeys(self.topics, ZERO)

    @classmethod
    def without_effect(cls, values: Mapping[str, Any]) -> Iterator[str]:
        """Yield a sentence on each coupling of a sensor with magnetorquers that are not there."""
        (most,) = cls.keys
        for name in [f'sensors.{name}.torquer_coupling' for name in values['sensors.names']]:
            if any(values.get(name, ())) and not any(values[most.name]):
                yield f'{name} is given, but without {most.name} it has no effect'

    def given(self, word: str, given: Any) -> dict[str, Any]:
        """Return by topic the checked values of a word; ValueError: as of Actuator.given."""
        self._refuse_unfitted(given)
        return super().given(word, given)

    def _refuse_unfitted(self, given):
        if not self.is_fitted:
            raise ValueError(
                f'magnetorquer is {given} and magnetorquer.max_dipole is 0 along all axes; it '
                'must be above 0 along one'
            )

    def columns(self, word: str, given: Any, count: int) -> dict[str, Any]:
        """Return what is held of dipoles (M, 3); ValueError: as of Actuator.columns."""
        self._refuse_unfitted('given')
        return super().columns(word, given, count)

    def within(self, name: str, held: Any) -> Any:
        """Return what acts of what is held under a name."""
        # A zero has no sign: -0.0 would be another command.
        pairs = zip(held, self._most, strict=True)
        if isinstance(held[0], np.ndarray):
            return tuple(np.clip(x, -m, m) + 0.0 for x, m in pairs)
        return tuple(max(-m, min(x, m)) + 0.0 for x, m in pairs)

    def commanded(self, torque: Magnetic, acting: Mapping[str, Any]) -> Magnetic:
        """Return the magnetic torque with the dipole that acts."""
        return torque.commanded(acting[self.topic])

    def report(self, acting: Mapping[str, Any]) -> dict[str, Any]:
        """Return what acts in words."""
        return {'dipole that acts [A m^2]': acting[self.topic]} if self.is_fitted else {}
