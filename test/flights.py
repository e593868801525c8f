"""Bags to test with: flights recorded as the node and offline runs record them."""

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from commands import motor_command, torque_command
from mcap.reader import make_reader
from mcap.records import Channel, Message, Metadata
from mcap.summary import Summary

from satdyn_ros.actuators import Command
from satdyn_ros.bag.comparison import Difference
from satdyn_ros.bag.write_run import Recording
from satdyn_ros.dynamics.system import System
from satdyn_ros.messages.contents import message
from satdyn_ros.orbits import KeplerOrbit
from satdyn_ros.rosbag2.mcap_file import McapFile
from satdyn_ros.rosbag2.scan import Block
from satdyn_ros.run.events import Request, Reset, Topics
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import Simulation
from satdyn_ros.run.topics import TOPICS

EPOCH_NS = 1_700_000_000_000_000_000


def offered(system):
    """Return the names of the topics of the state that a system has."""
    return tuple(
        name
        for name, topic in TOPICS.items()
        if topic.role == 'state' and not topic.lacking(system)
    )


TOPIC_NAMES = offered(System(np.eye(3), orbit=KeplerOrbit()))

# Every state topic has values, and the period of a tick is no whole number of nanoseconds.
GYROSTAT = Scenario.from_dict(
    {
        'rotor': {'mode': 'motor', 'inertia': 0.5, 'speed': 20.0},
        'orbit': {'type': 'kepler', 'eccentricity': 0.1, 'inclination': 0.9},
        'initial': {'angular_velocity': [0.01, -0.02, 0.015]},
        'publish': {'rate': 30.0, 'topics': list(TOPIC_NAMES)},
        'torque': {'timeout': 0.0},
        'time': {'epoch_ns': EPOCH_NS},
    }
)
# One of each kind; two share a tick, a torque times out, and one changes what is published.
EVENTS = (
    torque_command(20, (0.1, -0.2, 0.3), until_tick=45),
    motor_command(20, {'rotor': 0.01}),
    Request(60, {'initial.angular_velocity': [0.0, 0.1, 0.0]}),
    torque_command(60, (0.0, 0.0, 0.05)),
    Topics(80, ('attitude', 'rotor')),
    Reset(100),
)


def record(directory, scenario=GYROSTAT, ticks=150, events=EVENTS, block=64, flush=False) -> Path:
    """Record the first ticks of a run in blocks, each flushed if wanted; return the directory."""
    recording = Recording(directory, scenario, scenario.topics)
    for _ in written(recording, Simulation(scenario, events), ticks, block):
        if flush:
            recording.flush()
    recording.close()
    return Path(directory)


def written(recording, simulation, ticks, block=64):
    """Record a run in blocks and yield after each how many ticks have happened."""
    scenario = simulation.scenario
    packers = {}
    while simulation.next_tick < ticks:
        applied, samples = simulation.advance(min(block, ticks - simulation.next_tick))
        for event in applied:
            recording.event(event, int(samples.stamps_ns[0]))
        for name in simulation.topics:
            if name not in packers:
                packers[name] = message(TOPICS[name], scenario.frames, scenario.system)
        rows = {name: packers[name].pack(samples) for name in simulation.topics}
        first = samples.first_tick
        recording.samples(
            samples.stamps_ns, rows, lambda row, first=first: simulation.snapshot(first + row)
        )
        yield simulation.next_tick


def fly(directory, progress):
    """
    Record without an end, events all through, in files of about 100 kB, and flush at times.

    progress: a pipe that is sent the number of ticks after each flush.
    """
    scenario = GYROSTAT.with_values(
        {'publish.topics': ('attitude', 'imu'), 'record.max_size_bytes': 100_000}
    )
    often = [event for event in EVENTS if not isinstance(event, Topics)]
    events = [later(event, 150 * k) for k in range(2000) for event in often]
    recording = Recording(directory, scenario, scenario.topics)
    flushed_s = time.monotonic()
    for ticks in written(recording, Simulation(scenario, events), 10**9, block=20):
        if time.monotonic() - flushed_s > 0.1:
            recording.flush()
            progress.send(ticks)
            flushed_s = time.monotonic()


def later(event, ticks):
    """Return an event, and where it ends, moved by some ticks."""
    if isinstance(event, Command) and event.topic == 'torque' and event.until_tick is not None:
        event = replace(event, until_tick=event.until_tick + ticks)
    return replace(event, tick=event.tick + ticks)


def sequence(bag) -> list[tuple[str, int, bytes]]:
    """Return a bag's messages (topic, log time, data) in their order, read by the mcap library."""
    from mcap.stream_reader import StreamReader

    messages = []
    for path in sorted(Path(bag).glob('*.mcap'), key=lambda path: (len(path.name), path.name)):
        topics = {}
        for record in StreamReader(str(path), validate_crcs=True).records:
            if isinstance(record, Channel):
                topics[record.id] = record.topic
            elif isinstance(record, Message):
                messages.append((topics[record.channel_id], record.log_time, record.data))
    return messages


def summary(path) -> Summary:
    """Return the summary of a file of a bag, read by the mcap library."""
    with open(path, 'rb') as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    return summary


def difference(verdict) -> Difference:
    """Return where the bag of a verdict first differs; AssertionError: it is true."""
    assert not verdict.is_true
    assert verdict.difference is not None
    return verdict.difference


def rewritten(records, path, changed=lambda record: record.metadata) -> McapFile:
    """
    Write what a file holds to another, sound in every checksum; the file is not finished yet.

    changed(record): what a metadata record is to say.
    """
    header, *rest = records
    file = McapFile(path, header)
    for record in rest:
        if isinstance(record, Block):
            assert record.chunk is not None
            file.write_chunk(record.contents, record.chunk.compression, record.chunk.data)
        elif isinstance(record, Metadata):
            file.write_metadata(record.name, changed(record))
    return file
