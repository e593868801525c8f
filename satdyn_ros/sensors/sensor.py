"""What a sensor is: one class, from which all else follows."""

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from ..base.key import Key
from ..dynamics.motion import States
from .measurements import Measurements

# What a scenario says of any sensor.
COMMON = (
    Key(
        'mounting',
        'double_array',
        (0.0, 0.0, 0.0, 1.0),
        '',
        'unit quaternion x, y, z, w from sensor to body axes',
        lengths=(4,),
    ),
    Key('frame_id', 'string', '', '', 'frame id of the sensor'),
    Key(
        'divisor',
        'integer',
        1,
        '',
        'ticks from one sample to the next, counted from tick 0',
        low=1,
        high=10**9,
    ),
)


class NoMemory:
    """What a sensor remembers that takes each sample anew."""

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> 'NoMemory':
        """Return the memory that to_plain gave."""
        return cls()

    def to_plain(self) -> dict[str, Any]:
        """Return the memory as plain data."""
        return {}

    def without_noise(self) -> 'NoMemory':
        """Return the memory without what is noise."""
        return self

    def perfect(self) -> 'NoMemory':
        """Return the memory without errors."""
        return self

    def restarted(self) -> 'NoMemory':
        """Return the memory after the motion has restarted."""
        return self


class Sensor:
    """
    A sensor; each kind is a subclass, a frozen dataclass in a file of its own.

    Attributes
    ----------
    kind : str
        as in sensors.NAME.type
    keys : tuple of Key
        what a scenario says of one beside COMMON, by their last words, which are the names of its
        fields
    with_orbit, with_sun : tuple of str
        those keys that need an orbit, and those that need the Sun
    needs : str
        the key of the environment without which there is no such sensor, empty: none; what its
        truth() gives then comes from there
    message : str
        the type of its messages
    measures : str
        the field of them that its values fill, whose covariance, where there is one, has the
        variances; what else has a covariance is absent
    columns : tuple of str
        of its values in tables, behind its name; none: it is in no table
    says : str
        the content of its topic
    unit, per_si : str, float
        that of its panel, and how many of it are in the SI unit
    memory : object
        what it remembers before the first sample
    deviates : int
        how many normal deviates a sample takes
    seed, stream : int
        of its noise
    divisor : ticks
        from sample to sample
    mounting : (4,), x, y, z, w
        quaternion from sensor to body axes
    resolution : float
        of its values, 0: they are not rounded
    latency : ticks
        from what it measures to its message
    """

    kind: ClassVar[str]
    keys: ClassVar[tuple[Key, ...]] = ()
    with_orbit: ClassVar[tuple[str, ...]] = ()
    with_sun: ClassVar[tuple[str, ...]] = ()
    needs: ClassVar[str] = ''
    message: ClassVar[str]
    measures: ClassVar[str]
    columns: ClassVar[tuple[str, ...]] = ()
    says: ClassVar[str]
    unit: ClassVar[str]
    per_si: ClassVar[float] = 1.0
    memory: ClassVar[Any] = NoMemory()
    deviates: ClassVar[int] = 3

    seed: int
    stream: int
    divisor: int
    mounting: np.ndarray
    resolution: float = 0.0
    latency: int = 0

    @property
    def cone(self) -> float:
        """The half-angle about its z axis [rad] in which it sees, or is blinded; 0: none."""
        return 0.0

    def __init_subclass__(cls) -> None:
        """Let scenarios have the kind."""
        KINDS[cls.kind] = cls

    @classmethod
    def of(cls, options: Mapping[str, Any], interval_s: float) -> 'Sensor':
        """Return the sensor of its fields by name, with interval_s from sample to sample."""
        return cls(**options)

    @property
    def is_at_every_tick(self) -> bool:
        """Whether it has a message at every tick without exception."""
        return False

    @property
    def counts_turns(self) -> bool:
        """Whether it needs turn_b of the states."""
        return False

    @property
    def variances(self) -> tuple[float, ...]:
        """The variances of a sample about or along each axis."""
        raise NotImplementedError

    def allan_deviation(self, tau_s: float) -> float | None:
        """Return the Allan deviation of its samples over tau_s, in their unit; None: no sense."""
        return None

    def truth(self, states: States, rows: slice = slice(None)) -> np.ndarray:
        """Return what it would give without any error at rows of states, where it `needs`."""
        raise NotImplementedError

    def error(self, values: np.ndarray, true: np.ndarray) -> np.ndarray:
        """Return measurements minus their truth, (M, 3), or (M, 1) of what has a z axis alone."""
        return values - true

    def without_noise(self) -> 'Sensor':
        """Return the sensor with its systematic errors alone."""
        raise NotImplementedError

    def perfect(self) -> 'Sensor':
        """Return the sensor without any error."""
        raise NotImplementedError

    def measure(self, ticks: range, states: States, memory: Any) -> tuple[Measurements, Any]:
        """
        Return what it measures, and its new memory.

        Parameters
        ----------
        ticks : range
            consecutive, those of the rows of states
        states : States
            the truth
        memory : object
            after the tick before them
        """
        raise NotImplementedError

    def read(
        self, states: States, rows: Any, deviates: np.ndarray, biases: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray | None, np.ndarray]:
        """
        Return samples that do not follow each other, whether there is each, and their biases.

        Parameters
        ----------
        states : States
            the truth
        rows : (N,) int
            those that are measured
        deviates : (N, D)
            standard normal
        biases : (N, 3), sensor axes
            of the samples before, nan: there was none

        Returns
        -------
        values : (N, ...)
            the samples
        is_there : (N,) bool, or None
            None: there are all
        biases : (N, 3)
            of the samples
        """
        raise NotImplementedError


# By their names.
KINDS: dict[str, type[Sensor]] = {}
