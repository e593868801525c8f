"""A run without ROS and without a clock: scenario and events to a bag, as fast as it goes."""

import math
import time
from collections.abc import Generator, Sequence
from fractions import Fraction
from pathlib import Path

import numpy as np

from ..dynamics import rotation
from ..dynamics.orbit import KeplerOrbit
from ..exchange.aem_reader import attitude_at
from ..interruption import uninterrupted
from ..messages.packers import is_at_every_tick, packer
from ..rosbag2.tick_table import TickTable
from ..run.events import Event, Request, RotorCommand, Topics, Torque
from ..run.requests import requested, try_out
from ..run.scenario import Scenario
from ..run.simulation import RunHalted, Simulation
from ..run.ticks import LAST_STAMP_NS, Ticks
from .recorded_run import RecordedRun
from .recording import Recording

# Enough ticks that only their bytes cost time, few enough for a few megabytes.
BLOCK_TICKS = 8192


def simulate(
    scenario: Scenario,
    duration_s: str | float,
    directory: str | Path,
    events: Sequence[Event] = (),
) -> Generator[int, None, None]:
    """
    Record the ticks k with k / rate < duration_s into a new bag and yield how many are done.

    The bag is complete when the iteration ends, even if it is closed half way.  An epoch of 0 is
    the wall clock's full second.  An interruptible context is not interrupted while the bag is
    written.  ValueError: an event that the scenario does not allow, or a state from which no
    motion can start.  OSError: as BagWriter.  RunHalted: the run came to a halt; the bag has the
    ticks before.
    """
    scenario = with_epoch(scenario)
    changes = [event.names for event in events if isinstance(event, Topics)]
    names = [scenario.topics, *changes, tuple(scenario.sensors)]
    packers = {
        name: packer(name, scenario)
        for name in dict.fromkeys(name for some in names for name in some)
    }
    _check(events, scenario)
    try_out(scenario, 0)
    simulation = Simulation(scenario, events)
    count = tick_count(scenario, duration_s)
    recording: Recording | None = None
    block = BLOCK_TICKS
    tables: dict[tuple[str, ...], TickTable] = {}
    try:
        with uninterrupted():
            recording = Recording(directory, simulation.scenario, scenario.topics)
        while simulation.next_tick < count and not simulation.halted:
            applied, samples = simulation.advance(min(block, count - simulation.next_tick))
            with uninterrupted():
                block = _record(simulation, applied, samples, packers, tables, recording)
            yield simulation.next_tick
    finally:
        if recording is not None:
            with uninterrupted():
                recording.close()
    if simulation.halted:
        raise RunHalted(f'{simulation.halted}; {directory} has {simulation.next_tick} ticks')


def _record(simulation, applied, samples, packers, tables, recording):
    """
    Record events and the samples that follow them; return how many are best recorded next.

    tables: by topics those that were packed into before; their contents are in the bag.
    """
    for event in applied:
        recording.event(event, simulation.ticks.stamp_ns(samples.first_tick))
    names = *simulation.topics, *samples.measured
    every = tuple(name for name in names if is_at_every_tick(packers[name]))
    if every not in tables:
        constants = {name: packers[name].rows(1) for name in every}
        tables[every] = recording.table(BLOCK_TICKS, constants)
    table = tables[every]
    for name, channel_id in zip(every, table.places, strict=True):
        packers[name].pack(samples, table[: len(samples)].messages(channel_id))
    some = {name: packers[name].pack(samples) for name in names if name not in every}
    return recording.ticks(
        samples.stamps_ns, table, some, lambda i: simulation.snapshot(samples.first_tick + i)
    )


def tick_count(scenario: Scenario, duration_s: str | float) -> int:
    """
    Return how many ticks k >= 0 have k / rate < duration_s [s], a number or its decimal text.

    ValueError: it is not a number above 0, or ends after the last stamp of ROS.
    """
    try:
        duration = Fraction(str(duration_s))
    except (ValueError, ZeroDivisionError):
        duration = Fraction(0)
    if duration <= 0:
        raise ValueError(f'the duration is {duration_s}; it must be a number above 0 s')
    count = math.ceil(duration * scenario.rate)
    ticks = Ticks(scenario.rate, scenario.epoch_ns)
    if ticks.stamp_ns(count - 1) > LAST_STAMP_NS:
        raise ValueError(
            f'the duration is {duration_s} s, which ends after the last stamp of ROS, '
            f'{LAST_STAMP_NS // 10**9} s'
        )
    return count


def with_epoch(scenario: Scenario) -> Scenario:
    """Return the scenario with an epoch of 0 resolved: the wall clock's full second."""
    if scenario.epoch_ns:
        return scenario
    return scenario.with_values({'time.epoch_ns': round(time.time()) * 10**9})


def begun_in_bag(scenario: Scenario, bag: str | Path, at_s: str | float) -> Scenario:
    """
    Return the scenario started where the run in a bag is at_s seconds after that run's tick 0.

    The bag gives the attitude, the rates, the orbit, which continues, and the stamp of the new
    tick 0.  Torques that act there do not continue.  ValueError: the bag has no such instant.
    """
    run = RecordedRun(bag)
    first, last = _span(run)
    tick = _tick_at(run.ticks, at_s)
    if not first <= tick <= last:
        begin_s, end_s = run.ticks.seconds(first), run.ticks.seconds(last)
        raise ValueError(
            f'{bag} has no state at {at_s} s; it goes from {begin_s:g} to {end_s:g} s'
        )
    simulation = run.simulation()
    while simulation.tick < tick:
        _, samples = simulation.advance(min(BLOCK_TICKS, tick + 1 - simulation.next_tick))
        if len(samples) == 0:
            raise ValueError(f'the run in {bag} goes no further: {simulation.halted}')
    state = simulation.state
    values = {name: value for name, value in run.scenario.values.items() if name[:6] == 'orbit.'}
    values |= {
        'initial.frame': 'inertial',
        'initial.attitude': state.q_ib,
        'initial.angular_velocity': state.omega_bi_b,
        'time.epoch_ns': run.ticks.stamp_ns(tick),
    }
    orbit = run.scenario.system.orbit
    if isinstance(orbit, KeplerOrbit):
        anomaly = orbit.anomaly(run.ticks.seconds(tick))
        values['orbit.true_anomaly'] = math.remainder(anomaly, math.tau)
    speeds = dict(zip(run.scenario['rotor.names'] or ('',), state.rotor_speed, strict=True))
    before = {rotor.name: rotor for rotor in simulation.conditions.system.rotors}
    for rotor in scenario.system.rotors:
        earlier, prefix = before.get(rotor.name), f'rotor.{rotor.name}'.rstrip('.')
        if earlier is None:
            continue
        if rotor.turns_freely and earlier.turns_freely:
            values[f'{prefix}.speed'] = speeds[rotor.name]
        if rotor.mode == earlier.mode == 'constant_momentum':
            values[f'{prefix}.momentum'] = earlier.momentum
    return scenario.with_values(values)


def begun_in_aem(scenario: Scenario, path: str | Path, epoch: str) -> Scenario:
    """
    Return the scenario started with the attitude, and rate, of an AEM's row at an epoch (UTC).

    Without rates in the file the scenario's initial.angular_velocity is used, relative to the
    frame that the scenario names.  The epoch is the stamp of tick 0 unless time.epoch_ns is set.
    ValueError: see attitude_at.
    """
    attitude = attitude_at(path, epoch)
    omega_bi_b = attitude.omega_bi_b
    if omega_bi_b is None:
        omega_bi_b = np.array(scenario['initial.angular_velocity'])
        if scenario['initial.frame'] == 'lvlh':
            lvlh_rate_i = scenario.system.orbit.lvlh_rate(0.0)
            omega_bi_b += rotation.rotate(rotation.conjugate(attitude.q_ib), lvlh_rate_i)
    return scenario.with_values(
        {
            'initial.frame': 'inertial',
            'initial.attitude': attitude.q_ib,
            'initial.angular_velocity': omega_bi_b,
            'time.epoch_ns': scenario.epoch_ns or attitude.stamp_ns,
        }
    )


def _span(run):
    """Return the first and the last tick that a run has in its bag."""
    if run.snapshot is None:
        raise ValueError(f'{run.bag.path} has no samples')
    return run.first_tick, run.last_tick()


def _tick_at(ticks, at_s):
    try:
        return ticks.ceil(at_s)
    except (ValueError, ZeroDivisionError):
        raise ValueError(f'the instant is {at_s}; it must be a number of seconds') from None


def _check(events, scenario):
    """Refuse an event that is not allowed before anything is written."""
    for event in events:
        try:
            match event:
                case Request():
                    scenario = requested(scenario, event.values)
                case Torque() | RotorCommand():
                    torques = (
                        tuple(event.torques.values())
                        if isinstance(event, RotorCommand)
                        else event.torque_b
                    )
                    if scenario['motion.method'] == 'exact' and np.any(torques):
                        raise ValueError(
                            'motion.method is exact, and no closed form allows an applied torque'
                        )
        except ValueError as error:
            kind = type(event).__name__
            raise ValueError(f'the event {kind} at tick {event.tick}: {error}') from None
