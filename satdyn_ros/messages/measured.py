"""The messages of the sensors: sensor_msgs/Imu in their own axes, at ticks of their own."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..run.scenario import Scenario
from ..run.simulation import Measured, Samples
from ..sensors import Gyro, StarTracker
from ..sensors.suite import Sensor
from . import cdr, contents
from .rows import SomeRows
from .topics import TOPICS

# REP-145: a covariance that begins with -1 marks what a message does not have.
_ABSENT = [-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]


class SensorPacker:
    """
    What packs the measurements of a sensor.

    dtype: the layout of its messages, as cdr.Message.dtype.
    """

    def __init__(self, name: str, scenario: Scenario):
        self._name = name
        header = contents.header(scenario[f'sensors.{name}.frame_id'])
        content = {'header': header, **_content(scenario.sensors[name])}
        self._message = cdr.Message(TOPICS[name].type, content)
        self.dtype = self._message.dtype

    def pack(self, samples: Samples) -> SomeRows:
        """Return the messages that samples have of the sensor, each stamped by its exposure."""
        measured = samples.measured[self._name]
        return SomeRows(measured.places, self._message.pack(measured))


def _content(sensor: Sensor) -> dict[str, Any]:
    match sensor:
        case Gyro():
            return {
                'orientation_covariance': _ABSENT,
                'angular_velocity': _values,
                'angular_velocity_covariance': _diagonal([sensor.variance] * 3),
                'linear_acceleration_covariance': _ABSENT,
            }
        case StarTracker():
            return {
                'orientation': _values,
                'orientation_covariance': _diagonal(sensor.variances),
                'angular_velocity_covariance': _ABSENT,
                'linear_acceleration_covariance': _ABSENT,
            }


def _values(measured: Measured) -> np.ndarray:
    return measured.values


def _diagonal(variances: Sequence[float]) -> list[float]:
    return np.diag(variances).ravel().tolist()
