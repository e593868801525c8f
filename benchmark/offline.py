"""Scenario to bag without pacing, beside what a user writes with mcap or the Foxglove SDK."""

import tempfile
import time
import zlib
from collections import defaultdict
from pathlib import Path

import numpy as np
import zstandard
from common import QUICK, Claim, medians, milliseconds, printed_mb, show
from copies import SENSORS, copying

from satdyn_ros.bag.run_recorder import BLOCK_TICKS
from satdyn_ros.bag.simulate import simulate
from satdyn_ros.messages import contents
from satdyn_ros.messages.packers import packer
from satdyn_ros.messages.schemas import schema_text
from satdyn_ros.rosbag2.chunk import Contents
from satdyn_ros.rosbag2.chunk_builder import ChunkBuilder
from satdyn_ros.rosbag2.compression import compressor
from satdyn_ros.rosbag2.mcap_file import message_indexes
from satdyn_ros.rosbag2.tick_table import TickTable
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import Simulation
from satdyn_ros.run.topics import TOPICS

RATE_HZ, DAY_S = 10.0, 3600.0 if QUICK else 86400.0
# The peers are so slow that they get a twelfth of a day; their time is taken twelve times.
PART = 12
SCENARIO = Scenario.from_dict(
    {
        'publish': {'rate': RATE_HZ, 'topics': ['attitude', 'imu']},
        'time': {'epoch_ns': 10**18},
        'rotor': {'mode': 'constant_momentum', 'momentum': -5.0},
    }
)
TYPES = {
    'attitude': 'geometry_msgs/msg/QuaternionStamped',
    'imu': 'sensor_msgs/msg/Imu',
}


def written(write):
    """Return a contender that writes to a new folder and returns the CPU seconds of that alone."""

    def run():
        with tempfile.TemporaryDirectory() as name:
            begin = time.process_time()
            write(Path(name))
            return time.process_time() - begin

    return run


def ours(directory, duration_s=DAY_S):
    """Simulate and record."""
    for _ in simulate(SCENARIO, duration_s, directory / 'ours'):
        pass


# Long enough that opening and closing a bag do not show.
SENSED_S = 3.0 if QUICK else 300.0
SENSED = Scenario.from_dict(
    {
        'publish': {'rate': 1000.0, 'topics': ['attitude', 'imu']},
        'time': {'epoch_ns': 10**18},
        'sensors': SENSORS,
    }
)


def sensed(directory):
    """Record a run with a gyro at each tick and a star tracker at each hundredth."""
    for _ in simulate(SENSED, SENSED_S, directory / 'sensed'):
        pass


def copied(directory):
    """Record the same run with two further topics of this size and rate."""
    with copying():
        sensed(directory)


def states(duration_s):
    """Return the stamps and states that the peers write: they get ours for nothing."""
    _, samples = Simulation(SCENARIO).advance(int(duration_s * RATE_HZ))
    return samples.stamps_ns.tolist(), samples.states


def messages(duration_s):
    """Yield topic, stamp and serialised message, filled field by field as with rclpy."""
    from geometry_msgs.msg import QuaternionStamped
    from rclpy.serialization import serialize_message
    from sensor_msgs.msg import Imu

    stamps, table = states(duration_s)
    for stamp, q, omega in zip(
        stamps, table.q_ib.tolist(), table.omega_bi_b.tolist(), strict=True
    ):
        attitude, imu = QuaternionStamped(), Imu()
        for message, frame, quaternion in (
            (attitude, 'inertial', attitude.quaternion),
            (imu, 'base_link', imu.orientation),
        ):
            message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, 10**9)
            message.header.frame_id = frame
            quaternion.x, quaternion.y, quaternion.z, quaternion.w = q
        rate = imu.angular_velocity
        rate.x, rate.y, rate.z = omega
        yield 'attitude', stamp, serialize_message(attitude)
        yield 'imu', stamp, serialize_message(imu)


def mcap_writer(directory):
    """Write a part of a day with mcap.Writer and rclpy's serialisation."""
    from mcap.writer import CompressionType, Writer

    with open(directory / 'mcap.mcap', 'xb') as file:
        writer = Writer(file, compression=CompressionType.ZSTD)
        writer.start('ros2', 'benchmark')
        channels = {
            topic: writer.register_channel(
                f'/{topic}',
                'cdr',
                writer.register_schema(name, 'ros2msg', schema_text(name).encode()),
            )
            for topic, name in TYPES.items()
        }
        for topic, stamp, data in messages(DAY_S / PART):
            writer.add_message(channels[topic], stamp, data, stamp)
        writer.finish()


def foxglove(directory):
    """Write a part of a day with the Foxglove SDK from ready bytes, its best case."""
    import foxglove as sdk
    from foxglove import Channel, Schema

    path = directory / 'foxglove.mcap'
    blocks = ready(DAY_S / PART)
    context = sdk.Context()
    with sdk.open_mcap(str(path), context=context):
        channels = {
            topic: Channel(
                f'/{topic}',
                message_encoding='cdr',
                schema=Schema(name=name, encoding='ros2msg', data=schema_text(name).encode()),
                context=context,
            )
            for topic, name in TYPES.items()
        }
        stamps, rows = blocks
        for i, stamp in enumerate(stamps):
            for topic, channel in channels.items():
                channel.log(rows[topic][i], log_time=stamp)


def ready(duration_s):
    """Return stamps and each topic's messages as bytes."""
    _, samples = Simulation(SCENARIO).advance(int(duration_s * RATE_HZ))
    rows = {}
    for topic in TYPES:
        table = contents.message(TOPICS[topic], SCENARIO.frames, SCENARIO.system).pack(samples)
        data, size = table.tobytes(), table.dtype.itemsize
        rows[topic] = [data[i : i + size] for i in range(0, len(data), size)]
    return samples.stamps_ns.tolist(), rows


def floor(compress):
    """Compress, sum and write the bytes of a day's chunks: what nobody can save."""

    def write(directory):
        with open(directory / 'floor', 'xb') as file:
            for chunk in CHUNKS:
                zlib.crc32(chunk)
                file.write(compress(np.frombuffer(chunk, np.uint8)))

    return write


def chunks(bag):
    """Return the uncompressed chunks of a bag."""
    from mcap.records import Chunk
    from mcap.stream_reader import StreamReader

    with open(next(bag.glob('*.mcap')), 'rb') as file:
        return [
            zstandard.ZstdDecompressor().decompress(record.data, record.uncompressed_size)
            for record in StreamReader(file, emit_chunks=True).records
            if isinstance(record, Chunk)
        ]


def parts() -> str:
    """Return a table of the CPU time of what the recording of a day is made of."""
    seconds: defaultdict[str, float] = defaultdict(float)

    def timed(name, run, *arguments):
        begin = time.process_time()
        result = run(*arguments)
        seconds[name] += time.process_time() - begin
        return result

    simulation, chunk = Simulation(SCENARIO), ChunkBuilder()
    compress = compressor('zstd')
    packers = [packer(name, SCENARIO) for name in TYPES]
    constants = {i: topic.rows(1) for i, topic in enumerate(packers)}
    table, block = TickTable.of(BLOCK_TICKS, constants), BLOCK_TICKS
    with tempfile.TemporaryFile(buffering=0) as file:
        while simulation.next_tick < DAY_S * RATE_HZ:
            _, samples = timed('propagation', simulation.advance, block)
            for i, topic in enumerate(packers):
                rows = table[: len(samples)].messages(i)
                timed('packing of messages', topic.pack, samples, rows)
            timed('laying out in chunks', table[: len(samples)].stamp, samples.stamps_ns)
            done = 0
            while done < len(samples):
                rest = samples.stamps_ns[done:], table[done:]
                done += timed('laying out in chunks', chunk.add_ticks, *rest)
                if chunk.is_full:
                    contents = timed('index', Contents, chunk.take())
                    compressed = timed('compression', compress, contents.data)
                    index = timed('index', message_indexes, contents)
                    for part in (contents.data.data, compressed, index):
                        timed('checksums', zlib.crc32, part)
                    for part in (compressed, index):
                        timed('writing', file.write, part)
            block = chunk.whole(table)
    lines = ['| part of the recording of a day | CPU |', '| --- | --- |']
    most_first = sorted(seconds.items(), key=lambda part: part[1], reverse=True)
    return '\n'.join(lines + [f'| {k} | {milliseconds(v)} |' for k, v in most_first])


def memory_mb(days) -> float:
    """Return the peak memory above the start of a process that records some days."""
    return printed_mb(
        'import offline; offline.written(lambda path: offline.ours(path, 600.0))();'
        'begin = common.peak_memory_kb();'
        'duration_s = float(sys.argv[1]);'
        'offline.written(lambda path: offline.ours(path, duration_s))();'
        'print(common.peak_memory_kb() - begin)',
        days * DAY_S,
    )


def main(rounds=7):
    """Run all; return title, claims and text."""
    global CHUNKS
    with tempfile.TemporaryDirectory() as name:
        ours(Path(name))
        CHUNKS = chunks(Path(name) / 'ours')
    contenders = {
        'ours': ours,
        'floor': floor(zstandard.ZstdCompressor(level=-1).compress),
        'its zstd': floor(compressor('zstd')),
        'mcap': mcap_writer,
        'foxglove': foxglove,
        'sensed': sensed,
        'copied': copied,
    }
    seconds = medians({name: written(write) for name, write in contenders.items()}, rounds)
    for peer in ('mcap', 'foxglove'):
        seconds[peer] *= PART
    # Before the runs of many days: by their end a virtual machine gave memory back to its host.
    recording = parts()
    memory = {days: memory_mb(days) for days in (1, 7, 30)}
    claims = [
        Claim(
            f'one day, two topics at 10 Hz, against {title}',
            milliseconds(seconds['ours']),
            milliseconds(seconds[peer]),
            seconds[peer] / seconds['ours'],
            must,
        )
        for peer, title, must in (
            ('mcap', 'mcap.Writer with rclpy serialisation', 25.0),
            ('foxglove', "foxglove-sdk's writer of ready bytes", 4.0),
        )
    ]
    claims += [
        Claim(
            what,
            milliseconds(seconds['ours']),
            milliseconds(seconds[contender]),
            seconds['ours'] / seconds[contender],
            must,
            at_most=True,
        )
        for contender, what, must in (
            (
                'floor',
                'the same over compressing, summing and writing the same contents',
                1.4,
            ),
            (
                'its zstd',
                'the same over that with our settings of zstd, faster than those of its level',
                None,
            ),
        )
    ]
    claims.append(
        Claim(
            'a run with gyro and star tracker over one with two further topics of this size',
            milliseconds(seconds['sensed']),
            milliseconds(seconds['copied']),
            seconds['sensed'] / seconds['copied'],
            1.3,
            at_most=True,
        )
    )
    rows = ['| days | memory above the start |', '| --- | --- |']
    rows += [f'| {days} | {peak:.1f} MB |' for days, peak in memory.items()]
    rows.append('\nWhat grows is the list of chunks, which a file has at its end.\n')
    text = '\n'.join([*rows, recording])
    print(text)
    return 'Offline', show(claims), text


CHUNKS: list[bytes] = []

if __name__ == '__main__':
    main()
