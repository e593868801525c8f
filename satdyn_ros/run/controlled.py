"""A simulation in which a controller commands at ticks of its own."""

import copy
from collections.abc import Iterable

from ..actuators import Command
from .controllers import Controller, Seen, failure, name_of, period_of, sees_truth
from .events import Event, Request, Reset
from .rules import RULES
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
        # As it was before it commanded at the first tick of the last samples, and what it did.
        self._earlier: Controller | None = None
        self._own: list[Command] = []
        if controller is not None:
            self.control_by(controller)

    def control_by(self, controller: Controller) -> None:
        """Let a controller command from the next tick on; ValueError: as of its period_s."""
        self._period = period_of(controller, self.scenario)
        self.controller = controller
        self._reset()

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
        if self.controller is None:
            return super().advance(count)
        first, to_next = self.next_tick, self._period - self.next_tick % self._period
        is_own = to_next == self._period
        self._earlier, self._own = copy.deepcopy(self.controller), []
        happened, samples = super().advance(1 if is_own else min(count, to_next))
        if any(isinstance(event, Request | Reset) for event in happened):
            self._reset()
        if not (is_own and len(samples)):
            return happened, samples
        self._own = self._commands()
        if not self._own:
            return happened, samples
        super().rewind(first)
        for command in self._own:
            self.schedule(command)
        return super().advance(min(count, to_next))

    def rewind(self, tick: int) -> None:
        """As Simulation.rewind; what the controller commanded there is to be asked for anew."""
        is_first = self._block is not None and tick == self._block.first_tick < self.next_tick
        super().rewind(tick)
        if is_first and self._earlier is not None:
            self.controller = self._earlier
            for command in self._own:
                self._pending.remove(command)
            self._own = []

    def _reset(self):
        reset = getattr(self.controller, 'reset', None)
        if reset is not None:
            self._guarded(reset, self._run.conditions, self.scenario['sensors.seed'])

    def _commands(self):
        """Return what the controller commands at the last tick and is not yet in force."""
        sample = self.sample
        return self._guarded(self._asked, sample if self._needs_truth else Seen(sample))

    def _asked(self, seen):
        assert self.controller is not None
        held = self._held(self.controller.command(seen) or {})
        acting, until = self._run.acting, self._run.until
        new = {name: x for name, x in held.items() if acting[name] != x or name in until}
        return [Command(self.tick, topic, value) for topic, value in self._commanded(new)]

    def _guarded(self, function, *arguments):
        assert self.controller is not None
        try:
            return function(*arguments)
        except Exception as error:
            raise failure(self.controller, error, self.ticks.seconds(max(self.tick, 0))) from error

    def _new_stepper(self):
        return None if self.controller is not None else super()._new_stepper()
