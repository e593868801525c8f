"""A run without ROS and without a clock: scenario and events to a bag, as fast as it goes."""

import math
import time
from collections.abc import Generator, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

from ..actuators import Command
from ..base.interruption import uninterrupted
from ..messages.packers import packer
from ..orbits.pieces import latest_at
from ..run.controlled import ControlledSimulation
from ..run.controllers import Controller
from ..run.events import Derived, Event, Request, Topics, name_of
from ..run.requests import requested, try_out
from ..run.scenario import Scenario
from ..run.simulation import RunHalted
from ..run.ticks import LAST_STAMP_NS, Ticks
from .run_recorder import RunRecorder


class Untrue(RuntimeError):  # noqa: N818
    """The end of a run in which something should have happened and did not; one sentence."""


def simulate(
    scenario: Scenario,
    duration_s: str | float,
    directory: str | Path,
    events: Sequence[Event] = (),
    begin: Mapping[str, Any] | None = None,
    controller: Controller | None = None,
) -> Generator[int, None, None]:
    """
    Record the ticks k with k / rate < duration_s into a new bag and yield how many are done.

    The bag is complete when the iteration ends, even if it is closed half way.  An epoch of 0 is
    the wall clock.  An interruptible context is not interrupted while the bag is written.

    Parameters
    ----------
    scenario : Scenario
        what flies
    duration_s : s
        a number above 0, or its decimal text
    directory : str or Path
        the new bag
    events : sequence of Event
        what happens, each at its tick
    begin : mapping or None
        Simulation.snapshot of the tick from which the run continues and k counts; None: tick 0
    controller : Controller or None
        what closes the loop

    Raises
    ------
    ValueError
        an event that the scenario does not allow, or a state from which no motion can start
    OSError
        as BagWriter
    RunHalted
        the run came to a halt; the bag has the ticks before
    ControllerFailed
        likewise, by its controller
    Untrue
        a derived one of the events did not happen
    """
    scenario = scenario.with_epoch(time.time_ns())
    first, conditions = 0, scenario
    if begin is not None:
        first, conditions = begin['tick'], scenario.with_values(begin['conditions'])
    # Before anything is written, it is known that all of it can be.
    packers = _packers(scenario, events, begin)
    _check(events, conditions, first)
    end = first + tick_count(scenario, duration_s, first)
    simulation = _ready(scenario, events, begin, end)
    if controller is not None:
        simulation.control_by(controller)
    happened = yield from _record(simulation, packers, directory, end)
    if simulation.halted:
        count = simulation.next_tick - first
        raise RunHalted(f'{simulation.halted}; {directory} has {count} ticks')
    _check_all_happened(events, happened, end)


def tick_count(scenario: Scenario, duration_s: str | float, first: int = 0) -> int:
    """
    Return how many ticks k >= 0 have k / rate < duration_s.

    Parameters
    ----------
    scenario : Scenario
        what flies
    duration_s : s
        a number or its decimal text
    first : int
        the tick from which the run begins

    Raises
    ------
    ValueError
        it is not a number above 0, or the run ends after the last stamp of ROS, or after what is
        known of the orbit
    """
    try:
        duration = Fraction(str(duration_s))
    except (ValueError, ZeroDivisionError):
        duration = Fraction(0)
    if duration <= 0:
        raise ValueError(f'the duration is {duration_s}; it must be a number above 0 s')
    count = math.ceil(duration * scenario.rate)
    ticks, last = Ticks(scenario.rate, scenario.epoch_ns), first + count - 1
    if ticks.stamp_ns(last) > LAST_STAMP_NS:
        raise ValueError(
            f'the duration is {duration_s} s, which ends after the last stamp of ROS, '
            f'{LAST_STAMP_NS // 10**9} s'
        )
    orbit = scenario.system.orbit
    known_until_s = orbit.known_until(ticks.seconds(first))
    if ticks.seconds(last) > latest_at(known_until_s):
        sentence = orbit.outside(known_until_s)
        raise ValueError(f'the duration is {duration_s} s, and {sentence}')
    return count


def _packers(scenario, events, begin):
    """Return the packer of each topic that the run has at some tick, by name."""
    topics = scenario.topics if begin is None else begin['topics']
    changes = [event.names for event in events if isinstance(event, Topics)]
    names = dict.fromkeys(name for some in (topics, *changes) for name in some)
    return {name: packer(name, scenario) for name in names}


def _ready(scenario, events, begin, end):
    """Return the run before its first tick, from a state from which a motion can start."""
    if begin is not None:
        return ControlledSimulation.from_snapshot(scenario, begin, events)
    try_out(scenario, 0, end - 1)
    return ControlledSimulation(scenario, events)


def _record(simulation, packers, directory, end):
    """Record the ticks up to one, yield how many are done, and return the derived events."""
    first, block = simulation.next_tick, RunRecorder.most
    derived: set[Event] = set()
    recorder: RunRecorder | None = None
    try:
        with uninterrupted():
            recorder = RunRecorder(directory, simulation, packers)
        while simulation.next_tick < end and not simulation.halted:
            happened, samples = simulation.advance(min(block, end - simulation.next_tick))
            derived |= {event for event in happened if isinstance(event, Derived)}
            with uninterrupted():
                block = recorder.take(happened, samples)
            yield simulation.next_tick - first
    finally:
        if recorder is not None:
            with uninterrupted():
                recorder.close()
    return derived


def _check_all_happened(events, happened, end):
    """Raise Untrue for the first of the derived events before a tick that did not happen."""
    missing = {e for e in events if isinstance(e, Derived) and e.tick < end} - happened
    if missing:
        event = min(missing, key=lambda event: event.tick)
        raise Untrue(f'the event {name_of(event)} at tick {event.tick} did not happen')


def _check(events, scenario, first):
    """Refuse an event that is not allowed before anything is written."""
    for event in events:
        try:
            if event.tick < first:
                raise ValueError(f'the run continues at tick {first}; no event may come before')
            match event:
                case Request():
                    scenario = requested(scenario, event.values)
                case Command():
                    _check_command(event, scenario)
        except ValueError as error:
            what = f'the event {name_of(event)} at tick {event.tick}'
            raise ValueError(f'{what}: {error}') from None


def _check_command(event: Command, scenario: Scenario) -> None:
    """Raise ValueError for a command that the scenario does not allow."""
    equipment = scenario.equipment
    actuator = equipment.of_topic.get(event.topic)
    if actuator is None:
        raise ValueError(f'its topic is {event.topic}; allowed: {", ".join(equipment.topics)}')
    actuator.check(event.topic, event.value)
    system = equipment.commanded_alone(scenario.system, event.topic, event.value)
    if scenario['motion.method'] == 'exact' and system.takes_work:
        raise ValueError('motion.method is exact, and no closed form allows an applied torque')
