"""A simulation that can record itself, as `from satdyn_ros import Simulation` has it."""

import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ..base.interruption import uninterrupted
from ..run.controlled import ControlledSimulation
from ..run.controllers import Controller
from ..run.events import Event
from ..run.rules import RULES
from ..run.samples import Samples
from ..run.scenario import Scenario


class RecordableSimulation(ControlledSimulation):
    """
    A run, tick by tick, that may have a controller and write a bag.

    The bag has each tick from which the run has gone on, and verifies without the program that
    gave the commands.

    Parameters
    ----------
    scenario : Scenario
        the scenario
    events : events
        what happens at later ticks, in order
    rules : int
        of the bag that is run again
    record : str or Path
        directory of a new bag, which close(), or the end of a with statement, completes
    controller : object
        closes the loop, see run/controllers.py

    Raises
    ------
    OSError, ValueError
        as for BagWriter

    Examples
    --------
    >>> with Simulation(scenario, record='bags/x') as simulation:  # doctest: +SKIP
    ...     simulation.step(torque_b=(0, 0, 0.01))
    """

    def __init__(
        self,
        scenario: Scenario,
        events: Iterable[Event] = (),
        rules: int = RULES,
        record: str | Path | None = None,
        controller: Controller | None = None,
    ):
        # A bag has stamps.
        stamped = scenario if record is None else scenario.with_epoch(time.time_ns())
        super().__init__(stamped, events, rules, controller)
        self._recorder: Any = None
        # What may be rewound yet.
        self._waiting: tuple[list[Event], Samples] | None = None
        if record is not None:
            # Whoever writes no bag need not wait for what does.
            from .run_recorder import RunRecorder

            self._recorder = RunRecorder(record, self)

    def __repr__(self) -> str:
        return super().__repr__().replace(type(self).__name__, 'Simulation')

    def __enter__(self) -> 'RecordableSimulation':
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Complete the bag, if there is one; the run may continue without it."""
        if self._recorder is not None:
            self._write()
            with uninterrupted():
                self._recorder.close()
            self._recorder = None

    def advance(self, count: int) -> tuple[list[Event], Samples]:
        """Return the events of the next tick and the samples from it on, as Simulation.advance."""
        if self._recorder is None:
            return super().advance(count)
        self._write()
        self._waiting = super().advance(count)
        return self._waiting

    def rewind(self, tick: int) -> None:
        """Go back to a tick of the last samples, as Simulation.rewind."""
        super().rewind(tick)
        if self._waiting is not None:
            happened, samples = self._waiting
            count = tick - samples.first_tick
            self._waiting = (happened, samples.rows(0, count)) if count else None

    def _write(self):
        """Write what has happened for good."""
        if self._waiting is None:
            return
        (happened, samples), self._waiting = self._waiting, None
        with uninterrupted():
            for first in range(0, max(len(samples), 1), self._recorder.most):
                self._recorder.take(happened, samples.rows(first, first + self._recorder.most))
                happened = []

    def _new_stepper(self):
        return None if self._recorder is not None else super()._new_stepper()
