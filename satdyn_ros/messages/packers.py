"""
What packs the samples of a scenario into the messages of any of its topics.

Those of the sensors are in their own axes, at ticks of their own.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base.sparse import Rows, SparseMessages
from ..run.samples import Measured, Samples
from ..run.scenario import Scenario
from ..run.topics import TOPICS
from ..sensors import Sensor
from . import cdr, contents, schemas
from .incoming import Numbers

# REP-145: a covariance that begins with -1 marks what a message does not have.
_ABSENT = [-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]


class SensorPacker:
    """
    Packs the measurements of a sensor.

    Parameters
    ----------
    name : str
        of the sensor
    scenario : Scenario
        that has it

    Attributes
    ----------
    dtype : dtype
        the layout of its messages, as cdr.Message.dtype
    is_at_every_tick : bool
        whether it measures so often, as a gyro may
    """

    def __init__(self, name: str, scenario: Scenario):
        sensor = scenario.sensors[name]
        self._name = name
        self.is_at_every_tick = sensor.is_at_every_tick
        header = contents.header(scenario[f'sensors.{name}.frame_id'])
        content = {'header': header, **_content(sensor)}
        self._message = cdr.Message(sensor.message, content)
        self.dtype = self._message.dtype

    def rows(self, count: int) -> np.ndarray:
        """Return `count` messages (count,) that hold the constants."""
        return self._message.rows(count)

    def pack(self, samples: Samples, rows: np.ndarray | None = None) -> Rows:
        """
        Return the messages that samples have of the sensor, each stamped by its exposure.

        They are SparseMessages unless it measures at every tick.  rows: to be overwritten, as in
        cdr.Message.
        """
        measured = samples.measured[self._name]
        rows = self._message.pack(measured, rows)
        return rows if self.is_at_every_tick else SparseMessages(measured.indices, rows)


def _content(sensor: Sensor) -> dict[str, Any]:
    """Return the values, their covariance, and of all else that has one that it is absent."""
    content: dict[str, Any] = {sensor.measures: _values}
    for field in schemas.fields(sensor.message):
        if field.name == f'{sensor.measures}_covariance':
            content[field.name] = _diagonal(sensor.variances)
        elif field.name == 'variance':
            (content[field.name],) = sensor.variances
        elif field.name.endswith('_covariance'):
            content[field.name] = _ABSENT
    return content


def _values(measured: Measured) -> np.ndarray:
    return measured.values


def _diagonal(variances: Sequence[float]) -> list[float]:
    return np.diag(variances).ravel().tolist()


Packer = cdr.Message | SensorPacker


def packer(name: str, scenario: Scenario) -> Packer:
    """
    Return what packs samples for a topic: pack(samples) -> its messages as rows.

    name: as in the scenario.  ValueError: it has no such topic.
    """
    if name in scenario.sensors:
        return SensorPacker(name, scenario)
    return contents.message(scenario.topic_table[name], scenario.frames, scenario.system)


def tf_with_sensors(scenario: Scenario) -> Packer:
    """Return what packs /tf as it is in bags of the rules 0 and 1."""
    content = contents.tf_with_sensors(scenario.frames, scenario.system)
    return cdr.Message(TOPICS['tf'].type, content)


def geodetic_without_status(scenario: Scenario) -> Packer:
    """Return what packs geodetic as it is in bags of rules below 4."""
    topic = TOPICS['geodetic']
    return cdr.Message(topic.type, contents.geodetic_without_status(topic, scenario.frames))


def pack_tf_static(scenario: Scenario) -> bytes:
    """Return the message of /tf_static, stamped by the scenario's epoch."""
    stamp = Numbers(np.array([scenario.epoch_ns]), np.empty((1, 0)))
    packed = contents.message(TOPICS['tf_static'], scenario.frames, scenario.system)
    return packed.pack(stamp).tobytes()


def is_at_every_tick(topic: Packer) -> bool:
    """Whether a topic has a message at every tick; others are packed as SparseMessages."""
    return not isinstance(topic, SensorPacker) or topic.is_at_every_tick
