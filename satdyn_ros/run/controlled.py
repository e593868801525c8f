"""A simulation in which a controller commands at ticks of its own."""

import copy
from collections.abc import Iterable

from ..actuators import Command
from .controllers import Controller, Seen, failure, name_of, period_of, sees_truth
from .events import Event, Request, Reset
from .rules import RULES
from .run_state import RunState
from .samples import Samples
from .scenario import Scenario
from .simulation import Simulation


class ControlledSimulation(Simulation):
    """
    A Simulation that may have a controller, as of controllers.py.

    At each tick of its own, whatever else acts there has acted, it sees the sample and commands.
    A command acts from that tick on, until the next one for the same.  ValueError: its period_s is
    no multiple of the ticks' interval.  ControllerFailed: it raised, or commands what is not
    allowed.
    """

    def __init__(
        self,
        scenario: Scenario,
        events: Iterable[Event] = (),
        rules: int = RULES,
        controller: Controller | None = None,
    ):
        super().__init__(scenario, events, rules)
        self.controller: Controller | None = None
        # As it was before the last samples.
        self._earlier: Controller | None = None
        if controller is not None:
            self.control_by(controller)

    def control_by(self, controller: Controller) -> None:
        """Let a controller command from the next tick on; ValueError: as of its period_s."""
        self._period = period_of(controller, self.scenario)
        self.controller = controller
        self._reset(self._here.conditions)
        self._earlier = copy.deepcopy(controller)

    @property
    def control(self) -> dict[str, object]:
        """What a bag says of the controller, by which it needs not be run; empty: none."""
        if self.controller is None:
            return {}
        return {'name': name_of(self.controller), 'needs_truth': self._needs_truth}

    @property
    def _needs_truth(self):
        return self.controller is not None and sees_truth(self.controller)

    def advance(self, count: int) -> tuple[list[Event], Samples]:
        """As Simulation.advance, and none beyond the next tick of the controller."""
        self._earlier = copy.deepcopy(self.controller)
        return super().advance(count)

    def rewind(self, tick: int) -> None:
        """As Simulation.rewind; what the controller commanded there is to be asked for anew."""
        is_first = self._block is not None and tick == self._block.first_tick < self.next_tick
        super().rewind(tick)
        if is_first:
            self.controller = self._earlier

    def _reset(self, conditions):
        reset = getattr(self.controller, 'reset', None)
        if reset is not None:
            self._guarded(self.tick, reset, conditions, self.scenario['sensors.seed'])

    def _own_tick(self, tick: int) -> int | None:
        if self.controller is None:
            return None
        return tick + self._period - tick % self._period

    def _own_commands(self, run: RunState, tick: int, happened: list[Event]) -> list[Command]:
        if self.controller is None:
            return []
        if any(isinstance(event, Request | Reset) for event in happened):
            self._reset(run.conditions)
        if tick % self._period or run.halted:
            return []
        samples, _ = self._samples(run, tick, run.segment.states(tick, tick + 1))
        sample = self._sample_of(run.conditions, samples, 0)
        return self._guarded(tick, self._asked, run, sample)

    def _asked(self, run, sample):
        assert self.controller is not None
        seen = sample if self._needs_truth else Seen(sample)
        held = self._held(self.controller.command(seen) or {})
        new = {name: x for name, x in held.items() if run.acting[name] != x or name in run.until}
        return [Command(sample.tick, topic, value) for topic, value in self._commanded(new)]

    def _guarded(self, tick, function, *arguments):
        assert self.controller is not None
        try:
            return function(*arguments)
        except Exception as error:
            raise failure(self.controller, error, self.ticks.seconds(max(tick, 0))) from error

    def _new_stepper(self):
        return None if self.controller is not None else super()._new_stepper()
