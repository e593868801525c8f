"""Every bit of a bag counts: a flipped one is noticed, by its file and its record."""

import io
import random
import re
import shutil
from dataclasses import replace

import flights
import numpy as np
import pytest
import yaml
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    Message,
    MessageIndex,
    Metadata,
    Statistics,
)
from mcap.stream_reader import StreamReader
from mcap.writer import MCAP0_MAGIC, Writer

from satdyn_ros.bag.verify import verify
from satdyn_ros.rosbag2.chunk import Contents
from satdyn_ros.rosbag2.errors import BagError, Damaged
from satdyn_ros.rosbag2.integrity import CheckedFile, check
from satdyn_ros.rosbag2.mcap_file import McapFile
from satdyn_ros.rosbag2.reader import Bag
from satdyn_ros.rosbag2.records import PREFIX, written
from satdyn_ros.rosbag2.recover import recover
from satdyn_ros.rosbag2.scan import Block, Flaw, scan
from satdyn_ros.rosbag2.summary import checksum

SCENARIO = flights.GYROSTAT.with_values({'publish.topics': ('attitude', 'imu')})
NAMED = re.compile(r'_[01]\.mcap is damaged: .*(magic|record|data section|footer|summary)')


@pytest.fixture(
    scope='module',
    params=[
        'zstd',
        pytest.param('lz4', marks=pytest.mark.long),
        pytest.param('none', marks=pytest.mark.long),
    ],
)
def bag(request, tmp_path_factory):
    """Record a bag of two files, several chunks, and a metadata record of each kind."""
    scenario = SCENARIO.with_values(
        {'record.compression': request.param, 'record.max_duration_s': 1.5}
    )
    path = tmp_path_factory.mktemp(request.param) / 'bag'
    return flights.record(path, scenario, 80, flights.EVENTS[:-2], block=20, flush=True)


def turned(path, bit):
    """Flip a bit of a file."""
    with open(path, 'r+b') as file:
        file.seek(bit // 8)
        byte = file.read(1)[0]
        file.seek(bit // 8)
        file.write(bytes([byte ^ 1 << bit % 8]))


def named(path):
    """
    Return by byte how an error message names the chunk there, or what else it is in.

    Some bits of a compressed chunk change none of its contents, but the data section.
    """
    patterns = [NAMED] * path.stat().st_size
    for start, end, item in scan(path):
        if isinstance(item, Block):
            here = re.compile(
                rf'_[01]\.mcap is damaged: .*(record at byte {start}\b|data section)'
            )
            patterns[start:end] = [here] * (end - start)
    return patterns


def unnoticed(bag, directory, name, bits):
    """Return those bits of a file that, flipped one at a time, are not noticed by their offset."""
    patterns = named(bag / name)
    copy = directory / 'bag'
    shutil.copytree(bag, copy)
    missed = []
    for bit in bits:
        turned(copy / name, bit)
        try:
            CheckedFile(copy / name)
            missed.append((bit, 'accepted'))
        except Damaged as error:
            if not patterns[bit // 8].search(str(error)):
                missed.append((bit, str(error)))
        turned(copy / name, bit)
    assert check(Bag(copy)) == []
    shutil.rmtree(copy)
    return missed


def bits_of_every_record(path, count, seed):
    """Return bits of a file: one of each byte of opcode and length, `count` of each content."""
    draw = random.Random(seed)
    size = path.stat().st_size
    spans = [(found.start, found.end) for found in scan(path)]
    bits = [8 * byte + draw.randrange(8) for byte in (*range(8), *range(size - 8, size))]
    for start, end in spans:
        bits += [8 * (start + k) + draw.randrange(8) for k in range(9)]
        bits += [draw.randrange(8 * (start + 9), 8 * end) for _ in range(count)]
    return bits


def test_a_sound_bag_has_nothing_to_report(bag):
    """No flaw and no note; the mcap library finds all checksums right and none missing."""
    assert check(Bag(bag)) == []
    for path in bag.glob('*.mcap'):
        assert not any(isinstance(found.item, Flaw) for found in scan(path))
        records = list(StreamReader(str(path), emit_chunks=True, validate_crcs=True).records)
        for record in records:
            if isinstance(record, DataEnd):
                assert record.data_section_crc != 0
            elif isinstance(record, Footer):
                assert record.summary_crc != 0
            elif isinstance(record, Chunk):
                assert record.uncompressed_crc != 0
        assert len({type(record) for record in records}) == 12


def test_a_turned_bit_in_any_record_is_noticed(bag, tmp_path):
    """In every byte of opcode and length, and in the content, of every record of a file."""
    bits = bits_of_every_record(bag / 'bag_1.mcap', 3, 'bag_1.mcap')
    print(f'{len(bits)} bits turned')
    assert unnoticed(bag, tmp_path, 'bag_1.mcap', bits) == []


@pytest.mark.torture
def test_every_turned_bit_is_noticed(bag, tmp_path):
    """The same with every bit of a whole file."""
    bits = range(8 * (bag / 'bag_0.mcap').stat().st_size)
    print(f'{len(bits)} bits turned')
    assert unnoticed(bag, tmp_path, 'bag_0.mcap', bits) == []


def with_summary(data, changed):
    """Return a file with the bytes of its summary changed, its checksum right."""
    footer_start = len(data) - len(written([Footer(0, 0, 0)]) + MCAP0_MAGIC)
    *_, footer = StreamReader(io.BytesIO(data)).records
    assert isinstance(footer, Footer)
    start, offset_start = footer.summary_start, footer.summary_offset_start
    summary = changed(data[start:footer_start])
    end = Footer(start, offset_start, checksum(summary, start, offset_start))
    return data[:start] + summary + written([end]) + MCAP0_MAGIC


def with_in_summary(bag, directory, record):
    """Return a copy of a file with a record at the end of its summary, its checksum right."""
    data = (bag / 'bag_0.mcap').read_bytes()
    path = directory / 'bag_0.mcap'
    path.write_bytes(with_summary(data, lambda summary: summary + record))
    return path


@pytest.mark.parametrize(
    'record',
    [
        PREFIX.pack(0x80, 1) + b'x',
        written([Header('ros2', 'x')]),
        written([Metadata('a', {})]),
        written([Attachment(0, 0, 'a', 'b', b'')]),
        written([AttachmentIndex(0, 0, 0, 0, 0, 'a', 'b')]),
        written([DataEnd(0)]),
        written([Message(1, 0, b'', 0, 0)]),
        written([MessageIndex(1, [])]),
        written([Chunk('', b'', 0, 0, 0, 0)]),
    ],
)
def test_a_record_that_does_not_belong_in_the_summary_is_reported(bag, tmp_path, record):
    """Its checksum is right: only its kind, or what it refers to, is wrong."""
    path = with_in_summary(bag, tmp_path, record)
    with pytest.raises(Damaged, match=r'summary(, it holds a record that| does not say what)'):
        CheckedFile(path)


def test_the_summary_says_each_thing_once(bag, tmp_path):
    """A second Channel of an id may be another, and a chunk with two indexes be played twice."""
    kinds = {type(item): item for _, _, item in scan(bag / 'bag_0.mcap')}
    path = with_in_summary(bag, tmp_path, written([kinds[ChunkIndex]]))
    with pytest.raises(Damaged, match='its summary does not say what its data hold'):
        CheckedFile(path)
    path = with_in_summary(bag, tmp_path, written([replace(kinds[Channel], topic='/other')]))
    with pytest.raises(Damaged, match='its summary does not say what its data hold'):
        CheckedFile(path)


def test_a_channel_is_declared_in_one_way(bag, tmp_path):
    """Whoever reads from start to end would take the messages for those of another topic."""
    records = [found.item for found in scan(bag / 'bag_0.mcap')]
    held = [bytes(record.contents.data) for record in records if isinstance(record, Block)]
    channel = next(item for item in records if isinstance(item, Channel))
    held[1] += written([replace(channel, topic='/other')])
    file = McapFile(tmp_path / 'bag_0.mcap', records[0])
    for data in held:
        file.write_chunk(Contents(np.frombuffer(data, np.uint8)), '', data)
    file.finish()
    with pytest.raises(Damaged, match='what it declares was declared in another way'):
        CheckedFile(file.path)
    with pytest.raises(Damaged, match='Channel 1 in two ways'):
        _ = Contents(np.frombuffer(b''.join(held[:2]), np.uint8)).declarations


def test_attachments_and_unknown_records_of_other_writers_are_sound(tmp_path):
    """As the mcap library writes attachments; readers skip what MCAP does not define."""
    path = tmp_path / 'other.mcap'
    with open(path, 'wb') as file:
        writer = Writer(file)
        writer.start('ros2', 'other')
        for name in ('a', 'b'):
            writer.add_attachment(1, 2, name, 'text/plain', b'content')
        writer.finish()
    assert check(Bag(path)) == ['other.mcap has no checksum of its data']
    (tmp_path / 'bag_0.mcap').write_bytes(path.read_bytes())
    CheckedFile(with_in_summary(tmp_path, tmp_path, PREFIX.pack(0x80, 1) + b'x'))


def recorded_by_ros2_bag(directory):
    """
    Write a bag as rosbag2 0.26 does with libmcap 1.3, of a topic with messages and one without.

    The latter is in the summary alone, and its Statistics do not count it.
    """
    directory.mkdir()
    held = io.BytesIO()
    writer = Writer(held)
    writer.start('ros2', 'libmcap 1.3.0')
    for topic, stamps in (('/text', (3, 4, 9)), ('/silent', ())):
        schema = writer.register_schema(f'a_msgs/msg{topic}', 'ros2msg', b'string data')
        channel = writer.register_channel(topic, 'cdr', schema, {})
        for stamp in stamps:
            writer.add_message(channel, stamp, b'\0\1\0\0', stamp)
        writer.flush()
    writer.finish()
    statistics = next(
        record
        for record in StreamReader(io.BytesIO(held.getvalue())).records
        if isinstance(record, Statistics)
    )
    counted = replace(statistics, schema_count=1, channel_count=1)
    data = with_summary(
        held.getvalue(),
        lambda summary: summary.replace(written([statistics]), written([counted])),
    )
    (directory / 'bag_0.mcap').write_bytes(data)
    said = {
        'version': 9,
        'storage_identifier': 'mcap',
        'duration': {'nanoseconds': 6},
        'starting_time': {'nanoseconds_since_epoch': 3},
        'message_count': 3,
        'relative_file_paths': ['bag_0.mcap'],
    }
    (directory / 'metadata.yaml').write_text(yaml.safe_dump({'rosbag2_bagfile_information': said}))
    return directory


def test_a_bag_of_rosbag2_is_sound_and_holds_no_scenario(tmp_path):
    """Verify says what it lacks, not that it is damaged, and recover leaves it as it is."""
    bag = recorded_by_ros2_bag(tmp_path / 'bag')
    assert len(CheckedFile(bag / 'bag_0.mcap').summary.channels) == 2
    with pytest.raises(BagError, match='holds no scenario: satdyn_ros did not write it') as raised:
        verify(bag)
    assert not isinstance(raised.value, Damaged)
    before = {path.name: path.read_bytes() for path in bag.iterdir()}
    assert recover(bag).files == ()
    assert {path.name: path.read_bytes() for path in bag.iterdir()} == before


def test_our_own_statistics_count_all_that_the_summary_lists(bag, tmp_path):
    """What another writer leaves out is damage in a file of ours."""
    data = (bag / 'bag_0.mcap').read_bytes()
    statistics = next(f.item for f in scan(bag / 'bag_0.mcap') if isinstance(f.item, Statistics))
    fewer = replace(statistics, channel_count=statistics.channel_count - 1)
    path = tmp_path / 'bag_0.mcap'
    path.write_bytes(
        with_summary(data, lambda s: s.replace(written([statistics]), written([fewer])))
    )
    with pytest.raises(Damaged, match='its summary does not say what its data hold'):
        CheckedFile(path)


def test_a_reindexed_bag_is_sound(bag, tmp_path):
    """
    As rosbag2 0.26 writes it anew: topics by name, durations added, no files, texts unquoted.

    Another order, or another duration, is damage all the same.
    """
    copy = tmp_path / 'bag'
    shutil.copytree(bag, copy)
    path = copy / 'metadata.yaml'
    outer = yaml.safe_load(path.read_text())
    said = outer['rosbag2_bagfile_information']
    whole_ns = said['duration']['nanoseconds']
    said['duration']['nanoseconds'] = sum(f['duration']['nanoseconds'] for f in said['files'])
    assert said['duration']['nanoseconds'] < whole_ns
    topics = said['topics_with_message_count']
    said['topics_with_message_count'] = sorted(topics, key=lambda t: t['topic_metadata']['name'])
    assert said['topics_with_message_count'] != topics
    said['files'] = []
    said['custom_data']['rules'] = int(said['custom_data']['rules'])
    path.write_text(yaml.safe_dump(outer))
    assert verify(copy).same_bytes
    before = path.read_bytes()
    assert recover(copy).files == ()
    assert path.read_bytes() == before
    said['duration']['nanoseconds'] -= 1
    path.write_text(yaml.safe_dump(outer))
    with pytest.raises(Damaged, match=r'metadata\.yaml is damaged: its duration is not what'):
        check(Bag(copy))
    said['duration']['nanoseconds'] += 1
    said['topics_with_message_count'].reverse()
    path.write_text(yaml.safe_dump(outer))
    with pytest.raises(Damaged, match=r'its topics_with_message_count is not what'):
        check(Bag(copy))


def meanings_kept(bag, directory, bits):
    """Flip bits of metadata.yaml; return those noticed without, or not with, another meaning."""
    copy = directory / 'bag'
    shutil.copytree(bag, copy)
    path = copy / 'metadata.yaml'
    before = yaml.safe_load(path.read_text())
    wrong = []
    for bit in bits:
        turned(path, bit)
        try:
            is_same = yaml.safe_load(path.read_text()) == before
        except (yaml.YAMLError, UnicodeDecodeError, ValueError):
            is_same = False
        try:
            check(Bag(copy))
            said = ''
        except ValueError as error:
            said = str(error)
        if is_same != (said == '') or not re.search(
            '^$|metadata.yaml|is stored as|compressed', said
        ):
            wrong.append((bit, said))
        turned(path, bit)
    shutil.rmtree(copy)
    return wrong


def test_a_turned_bit_in_metadata_yaml_is_noticed_where_it_means_something(bag, tmp_path):
    """By its key, or by the line where the text is not YAML."""
    size = 8 * (bag / 'metadata.yaml').stat().st_size
    bits = random.Random(1).sample(range(size), 100)
    assert meanings_kept(bag, tmp_path, bits) == []


@pytest.mark.torture
def test_every_turned_bit_in_metadata_yaml(bag, tmp_path):
    """The same with every bit of the file."""
    bits = range(8 * (bag / 'metadata.yaml').stat().st_size)
    assert meanings_kept(bag, tmp_path, bits) == []


@pytest.mark.parametrize('kind', ['magic', 'Header', 'Metadata', 'Block', 'DataEnd', 'Footer'])
def test_verify_says_no_to_a_turned_bit(bag, tmp_path, kind):
    """A damaged bag of satdyn_ros fails the check as Damaged, whatever record it is."""
    copy = tmp_path / 'bag'
    shutil.copytree(bag, copy)
    starts = {type(f.item).__name__: f.start for f in scan(copy / 'bag_0.mcap')} | {'magic': 0}
    for byte in (0, 5):
        turned(copy / 'bag_0.mcap', 8 * (starts[kind] + byte) + 2)
        with pytest.raises(Damaged, match=r'bag_0\.mcap'):
            verify(copy)
        turned(copy / 'bag_0.mcap', 8 * (starts[kind] + byte) + 2)
