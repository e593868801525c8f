"""All sensors of a run, and what they remember from tick to tick."""

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from ..dynamics.motion import States
from .measurements import Measurements
from .sensor import Sensor


@dataclass(frozen=True, eq=False)
class Suite:
    """
    Sensors by name, with the memory of each after some tick; it never changes.

    >>> from satdyn_ros.sensors import Gyro
    >>> suite = Suite.of({'gyro': Gyro(seed=1, interval_s=0.01)})
    >>> suite.to_plain()
    {'gyro': {'bias': None, 'q_ib': None}}
    """

    sensors: Mapping[str, Sensor]
    memories: Mapping[str, Any]

    @classmethod
    def of(cls, sensors: Mapping[str, Sensor]) -> 'Suite':
        """Return the suite before the first tick."""
        if sensors:
            import_module('scipy.special')  # Before the first tick, for which noise.py needs it.
        return cls(sensors, {name: sensor.memory for name, sensor in sensors.items()})

    @property
    def counts_turns(self) -> bool:
        """Whether any of the sensors needs turn_b of the states."""
        return any(sensor.counts_turns for sensor in self.sensors.values())

    def measure(self, ticks: range, states: States) -> tuple[dict[str, Measurements], 'Suite']:
        """
        Return what each sensor gives at consecutive ticks, and the suite after them.

        states: one row for each tick.
        """
        found = {
            name: sensor.measure(ticks, states, self.memories[name])
            for name, sensor in self.sensors.items()
        }
        after = Suite(self.sensors, {name: memory for name, (_, memory) in found.items()})
        return {name: measurements for name, (measurements, _) in found.items()}, after

    def restarted(self) -> 'Suite':
        """Return the suite after the motion has restarted at a request or a reset."""
        return Suite(self.sensors, {name: m.restarted() for name, m in self.memories.items()})

    def turned(self, turn_b: np.ndarray) -> 'Suite':
        """Return the suite after a turn (3,) [rad], body axes, without a tick at its end."""
        memories = {
            name: memory.turned(turn_b) if self.sensors[name].counts_turns else memory
            for name, memory in self.memories.items()
        }
        return Suite(self.sensors, memories)

    def without_noise(self) -> 'Suite':
        """Return the suite with the systematic errors alone, without waiting exposures."""
        return Suite(
            {name: sensor.without_noise() for name, sensor in self.sensors.items()},
            {name: memory.without_noise() for name, memory in self.memories.items()},
        )

    def perfect(self) -> 'Suite':
        """Return the suite without any error, and without waiting exposures."""
        return Suite(
            {name: sensor.perfect() for name, sensor in self.sensors.items()},
            {name: memory.perfect() for name, memory in self.memories.items()},
        )

    def to_plain(self) -> dict[str, Any]:
        """Return the memories as plain data, by the sensors' names."""
        return {name: memory.to_plain() for name, memory in self.memories.items()}

    def with_memories(self, plain: Mapping[str, Any]) -> 'Suite':
        """Return the suite with the memories that to_plain gave."""
        memories = {
            name: type(self.memories[name]).from_plain(plain[name]) for name in self.sensors
        }
        return Suite(self.sensors, memories)
