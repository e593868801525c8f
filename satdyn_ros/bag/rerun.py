"""Runs a recorded run again: the messages that its scenario and events should give."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from ..actuators import Command, kind_of
from ..base.sparse import dense_and_sparse
from ..dynamics.system import State
from ..kernel import rotation
from ..messages.incoming import pack_command
from ..messages.packers import Packer
from ..rosbag2.chunk_builder import ChunkBuilder
from ..rosbag2.tick_table import TickTable
from ..run.events import Event, Request, Reset
from ..run.samples import Samples
from ..run.simulation import Simulation
from .read_run import RecordedRun

_TICKS = 4096
_DIAGONAL = np.array([1.0, 1.0, 1.0]) / np.sqrt(3.0)


class Records(NamedTuple):
    """
    Messages as in a chunk.

    Attributes
    ----------
    data : (N,) uint8
        the bytes
    starts_anew : bool
        whether a restart replaces the state before
    """

    data: np.ndarray
    starts_anew: bool


def rerun(
    run: RecordedRun,
    perturbation_rad: float = 0.0,
    observe: Callable[[Simulation, list[Event], Samples], None] | None = None,
) -> Iterator[Records]:
    """
    Yield the messages of a run, until it halts or its bag ends, as the bag should hold them.

    Parameters
    ----------
    run : RecordedRun
        the bag
    perturbation_rad : rad
        how far the states at the start of motions are turned, and by what fraction their rates are
        changed, so that the distance of two runs shows how errors grow
    observe : function or None
        called with the simulation, and all events and samples
    """
    is_exact = run.scenario['motion.method'] == 'exact'
    # A start beside that of a closed form may have none.
    simulation = run.simulation('auto' if perturbation_rad and is_exact else None)
    starts_anew = True
    already_applied = run.events_at_begin
    chunk = ChunkBuilder()
    packers: dict[str, Packer] = {}
    ends = sorted({*run.happened.begins, run.end_tick}) if run.latched else [run.end_tick]
    while simulation.next_tick < run.end_tick:
        next_tick = simulation.next_tick
        end = next(tick for tick in ends if tick > next_tick)
        applied, samples = simulation.advance(min(_TICKS, end - next_tick))
        starts_anew |= any(isinstance(event, Request | Reset) for event in applied)
        if perturbation_rad and starts_anew:
            simulation.begin_from(_perturbed(simulation.motion.state, perturbation_rad))
            _, samples = simulation.advance(len(samples))
        if observe is not None:
            observe(simulation, applied, samples)
        for event in [*already_applied, *applied]:
            _add_input(chunk, run, event)
        if simulation.halted:
            yield Records(chunk.take(), starts_anew)
            return
        already_applied = []
        _add_latched(chunk, run, samples.first_tick)
        rows = {}
        for name in (*simulation.topics, *run.scenario.sensors):
            if name not in packers:
                packers[name] = run.packer(name)
            rows[run.channel_id(name)] = packers[name].pack(samples)
        full, some = dense_and_sparse(rows)
        table = TickTable.of(len(samples), full)
        table.stamp(samples.stamps_ns)
        done = 0
        while rows and done < len(samples):
            rest = {channel_id: messages[done:] for channel_id, messages in some.items()}
            done += chunk.add_ticks(samples.stamps_ns[done:], table[done:], rest)
            yield Records(chunk.take(), starts_anew)
            starts_anew = False
        if not rows:
            yield Records(chunk.take(), starts_anew)
            starts_anew = False


def _add_latched(chunk, run, tick):
    """Add what is published once, where a file begins."""
    if tick in run.happened.begins:
        for name, data in run.latched.items():
            chunk.add_message(run.channel_id(name), run.ticks.stamp_ns(tick), data)


def _add_input(chunk, run, event):
    if not isinstance(event, Command):
        return
    stamp_ns, topic = run.ticks.stamp_ns(event.tick), event.topic
    if topic not in run.names:
        (topic,) = run.names.keys() & kind_of(topic).earlier
    data = pack_command(stamp_ns, event, run.scenario.frames, topic)
    chunk.add_message(run.channel_id(topic), stamp_ns, data)


def _perturbed(state, angle_rad):
    """Return a state that is turned slightly, and slightly faster."""
    faster = 1.0 + angle_rad
    return State(
        rotation.multiply(state.q_ib, rotation.about(_DIAGONAL, angle_rad)),
        state.omega_bi_b * faster,
        state.rotor_speed * faster,
        state.rotor_angle,
        state.inner,
    )
