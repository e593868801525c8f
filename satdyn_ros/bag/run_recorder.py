"""Records what a simulation gives, block by block, as it goes."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from ..messages.packers import Packer, is_at_every_tick, packer
from ..rosbag2.tick_table import TickTable
from ..run.controlled import ControlledSimulation
from ..run.events import Event
from ..run.samples import Samples
from .write_run import Recording

# Enough ticks that only their bytes cost time, few enough for a few megabytes.
BLOCK_TICKS = 8192


class RunRecorder:
    """
    A new bag of a simulation.

    Parameters
    ----------
    directory : str or Path
        the bag
    simulation : ControlledSimulation
        whose run it is
    packers : dict
        of topics, where they are known already

    Attributes
    ----------
    most : ticks
        that may be taken at once

    Raises
    ------
    OSError, ValueError
        as Recording
    """

    most = BLOCK_TICKS

    def __init__(
        self,
        directory: str | Path,
        simulation: ControlledSimulation,
        packers: Mapping[str, Packer] = MappingProxyType({}),
    ):
        self._simulation = simulation
        self._recording = Recording(
            directory, simulation.scenario, simulation.topics, control=simulation.control
        )
        self._packers = dict(packers)
        # By topics those that were packed into before; their contents are in the bag.
        self._tables: dict[tuple[str, ...], TickTable] = {}

    def take(self, happened: Sequence[Event], samples: Samples) -> int:
        """
        Record events and the samples that follow them, the last ones of the simulation.

        Return how many are best recorded next.
        """
        simulation, recording, packers = self._simulation, self._recording, self._packers
        for event in happened:
            recording.event(event, simulation.ticks.stamp_ns(samples.first_tick))
        names = *simulation.topics, *samples.measured
        for name in names:
            if name not in packers:
                packers[name] = packer(name, simulation.scenario)
        every = tuple(name for name in names if is_at_every_tick(packers[name]))
        if every not in self._tables:
            constants = {name: packers[name].rows(1) for name in every}
            self._tables[every] = recording.table(self.most, constants)
        table = self._tables[every]
        for name, channel_id in zip(every, table.fields, strict=True):
            packers[name].pack(samples, table[: len(samples)].messages(channel_id))
        some: dict[str, Any] = {
            name: packers[name].pack(samples) for name in names if name not in every
        }
        return recording.ticks(
            samples.stamps_ns, table, some, lambda i: simulation.snapshot(samples.first_tick + i)
        )

    def close(self) -> None:
        """Complete the bag."""
        self._recording.close()
