"""Scenario and events to samples at ticks: no ROS and no clock of its own."""

from dataclasses import dataclass

import numpy as np

from .dynamics.motion import States
from .dynamics.system import System


@dataclass(frozen=True, eq=False)
class Samples:
    """
    What happens at consecutive ticks, all under one event.

    first_tick: the tick of row 0; stamps_ns (N,) int64; states: the rows' states; system: body,
    field and the torques that act.
    """

    first_tick: int
    stamps_ns: np.ndarray
    states: States
    system: System

    def __len__(self) -> int:
        return len(self.stamps_ns)
