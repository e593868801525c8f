"""What is written: the records of rosbag2 in their order, and never a failure in silence."""

import os
import struct
import subprocess
import sys
import tracemalloc
from contextlib import closing
from itertools import groupby

import flights
import numpy as np
import pytest
import yaml
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    Header,
    Message,
    MessageIndex,
    Metadata,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.stream_reader import StreamReader, breakup_chunk
from ruamel.yaml import YAML

from satdyn_ros.rosbag2 import scan as scan_module
from satdyn_ros.rosbag2 import summary as summary_module
from satdyn_ros.rosbag2.errors import Incomplete
from satdyn_ros.rosbag2.integrity import check
from satdyn_ros.rosbag2.metadata import TopicMetadata
from satdyn_ros.rosbag2.reader import Bag
from satdyn_ros.rosbag2.recover import recover
from satdyn_ros.rosbag2.scan import Block, Flaw, scan
from satdyn_ros.rosbag2.writer import BagWriter

PROFILE = '- history: keep_last\n  depth: 10'
A = TopicMetadata('/a', 'std_msgs/msg/Int64', 'int64 data', 'RIHS01_aa', PROFILE)
B = TopicMetadata('/b', 'std_msgs/msg/Int8', 'int8 data', 'RIHS01_bb', '')
SILENT = TopicMetadata('/c', 'std_msgs/msg/Int8', 'int8 data', 'RIHS01_bb', '')
TICK_NS = 10**8


def rows(length, count, first=0):
    """Return `count` messages of a length, each filled with its number."""
    numbers = np.arange(first, first + count) % 256
    return np.repeat(numbers.astype(np.uint8), length).view(f'V{length}')


def stamps(count, first=0):
    return flights.EPOCH_NS + TICK_NS * np.arange(first, first + count)


def records(path):
    """Return a file's records, its chunks unopened, read by the mcap library with checksums."""
    return list(StreamReader(str(path), emit_chunks=True, validate_crcs=True).records)


def only(path, kind):
    return [record for record in records(path) if isinstance(record, kind)]


@pytest.fixture
def bag(tmp_path):
    """Write two chunks of two topics, metadata between them, and a topic without messages."""
    preamble = {'satdyn_ros/scenario': {'version': '1: "x"'}}
    with closing(BagWriter(tmp_path / 'bag', [A, B, SILENT], preamble=preamble)) as writer:
        writer.write(stamps(3), {'/a': rows(12, 3)})
        writer.write_metadata('between', {'key': 'value'})
        writer.write(stamps(2, 3), {'/a': rows(12, 2, 3), '/b': rows(5, 2, 3)})
    return tmp_path / 'bag'


def test_records_stand_in_the_order_of_rosbag2(bag):
    """Header, metadata, chunks each with its indexes, metadata, data end, summary, footer."""
    found = records(bag / 'bag_0.mcap')
    counted = [(name, len(list(run))) for name, run in groupby(type(r).__name__ for r in found)]
    assert counted == [
        ('Header', 1),
        ('Metadata', 2),
        ('Chunk', 1),
        ('MessageIndex', 1),
        ('Metadata', 1),
        ('Chunk', 1),
        ('MessageIndex', 2),
        ('Metadata', 1),
        ('DataEnd', 1),
        ('Schema', 2),
        ('Channel', 3),
        ('Statistics', 1),
        ('ChunkIndex', 2),
        ('MetadataIndex', 4),
        ('SummaryOffset', 5),
        ('Footer', 1),
    ]
    assert found[0].profile == 'ros2'
    metadata = [record.name for record in found if isinstance(record, Metadata)]
    assert metadata == ['rosbag2', 'satdyn_ros/scenario', 'between', 'rosbag2']


def test_a_channel_is_declared_ahead_of_its_first_message(bag):
    """Chunks hold schemas and channels where rosbag2 has them; the summary has the silent too."""
    chunks = [breakup_chunk(chunk) for chunk in only(bag / 'bag_0.mcap', Chunk)]
    inside = [[type(record).__name__ for record in chunk] for chunk in chunks]
    assert inside == [
        ['Schema', 'Channel', *['Message'] * 3],
        ['Schema', 'Channel', *['Message'] * 4],
    ]
    quality = {'offered_qos_profiles': PROFILE, 'topic_type_hash': 'RIHS01_aa'}
    none = {'offered_qos_profiles': '', 'topic_type_hash': 'RIHS01_bb'}
    assert only(bag / 'bag_0.mcap', Channel) == [
        Channel(1, '/a', 'cdr', quality, 1),
        Channel(2, '/b', 'cdr', none, 2),
        Channel(3, '/c', 'cdr', none, 2),
    ]
    assert only(bag / 'bag_0.mcap', Schema) == [
        Schema(1, b'int64 data', 'ros2msg', 'std_msgs/msg/Int64'),
        Schema(2, b'int8 data', 'ros2msg', 'std_msgs/msg/Int8'),
    ]


def test_messages_stand_tick_by_tick(bag):
    """Log and publish time are the stamp, the sequence is 0, as rosbag2 writes it."""
    chunks = only(bag / 'bag_0.mcap', Chunk)
    messages = [r for c in chunks for r in breakup_chunk(c) if isinstance(r, Message)]
    expected = [(1, k, 12) for k in range(3)] + [
        (i, k, n) for k in (3, 4) for i, n in ((1, 12), (2, 5))
    ]
    assert messages == [
        Message(i, int(stamp), bytes([k]) * n, int(stamp), 0)
        for i, k, n in expected
        for stamp in stamps(1, k)
    ]


def test_indexes_point_at_what_they_say(bag):
    """Every entry of every index leads to its record; the summary is the reader's way in."""
    path = bag / 'bag_0.mcap'
    data = path.read_bytes()
    chunks = only(path, Chunk)
    for index, chunk in zip(only(path, ChunkIndex), chunks, strict=True):
        start, length = index.chunk_start_offset, index.chunk_length
        assert data[start] == Opcode.CHUNK
        assert struct.unpack_from('<Q', data, start + 1)[0] + 9 == length
        assert (index.compressed_size, index.uncompressed_size) == (
            len(chunk.data),
            chunk.uncompressed_size,
        )
        for channel_id, offset in index.message_index_offsets.items():
            assert data[offset] == Opcode.MESSAGE_INDEX
            assert struct.unpack_from('<H', data, offset + 9)[0] == channel_id
    for index in only(path, MessageIndex):
        for log_time, _ in index.records:
            assert log_time in stamps(5).tolist()
    for group in only(path, SummaryOffset):
        assert data[group.group_start] == group.group_opcode
    with open(path, 'rb') as file:
        reader = make_reader(file, validate_crcs=True)
        found = [(c.topic, m.log_time) for _, c, m in reader.iter_messages(topics=['/b'])]
        assert found == [('/b', stamp) for stamp in stamps(2, 3).tolist()]
        assert [record.name for record in reader.iter_metadata()][2] == 'between'


def test_statistics_count_what_is_there(bag):
    """Counts and times of the whole file; rosbag2 takes them for granted."""
    (statistics,) = only(bag / 'bag_0.mcap', Statistics)
    first, last = stamps(5)[[0, -1]].tolist()
    assert statistics == Statistics(0, 3, {1: 5, 2: 2}, 2, 7, last, first, 4, 2)


METADATA = f"""\
rosbag2_bagfile_information:
  version: 9
  storage_identifier: mcap
  duration:
    nanoseconds: {4 * TICK_NS}
  starting_time:
    nanoseconds_since_epoch: {flights.EPOCH_NS}
  message_count: 7
  topics_with_message_count:
    - topic_metadata:
        name: /a
        type: std_msgs/msg/Int64
        serialization_format: cdr
        offered_qos_profiles:
          - history: keep_last
            depth: 10
        type_description_hash: RIHS01_aa
      message_count: 5
    - topic_metadata:
        name: /b
        type: std_msgs/msg/Int8
        serialization_format: cdr
        offered_qos_profiles: []
        type_description_hash: RIHS01_bb
      message_count: 2
    - topic_metadata:
        name: /c
        type: std_msgs/msg/Int8
        serialization_format: cdr
        offered_qos_profiles: []
        type_description_hash: RIHS01_bb
      message_count: 0
  compression_format: ""
  compression_mode: ""
  relative_file_paths:
    - bag_0.mcap
  files:
    - path: bag_0.mcap
      starting_time:
        nanoseconds_since_epoch: {flights.EPOCH_NS}
      duration:
        nanoseconds: {4 * TICK_NS}
      message_count: 7
  custom_data:
    version: "1: \\"x\\""
  ros_distro: jazzy"""


def test_metadata_yaml_is_version_9_field_by_field(bag):
    """The text is laid out as yaml-cpp lays it out for rosbag2 of Jazzy, no newline at its end."""
    assert (bag / 'metadata.yaml').read_text() == METADATA


def test_a_file_says_twice_what_metadata_yaml_says(bag):
    """At its start without messages and topics, at its end all of it, without the outer key."""
    first, last = said_in(bag / 'bag_0.mcap')
    assert last == yaml.safe_load(METADATA)['rosbag2_bagfile_information']
    assert first == last | {
        'duration': {'nanoseconds': 0},
        'starting_time': {'nanoseconds_since_epoch': 2**63 - 1},
        'message_count': 0,
        'topics_with_message_count': [],
        'files': [
            {
                'path': 'bag_0.mcap',
                'starting_time': {'nanoseconds_since_epoch': 2**63 - 1},
                'duration': {'nanoseconds': 0},
                'message_count': 0,
            }
        ],
    }


def said_in(path, load=yaml.safe_load):
    """Return what each of the rosbag2 records of a file says."""
    return [
        load(record.metadata['serialized_metadata'])
        for record in only(path, Metadata)
        if record.name == 'rosbag2'
    ]


TEXTS = {
    'quotes': '"\'\\ #: {}[]&*!|>%@`, - ? ~\t\r\n\n  \n',
    'control': ''.join(map(chr, range(0x20))) + '\x7f\x80\x9b',
    'breaks': 'a\x85b\u2028c\u2029\r\nd',
    'unicode': '\ufeffcaf\xe9\xa0\u4e2d\u6587\U0001f600\ufffd\ufffe\uffff\U0010fffe',
    'words': 'null',
    'number': '0x1F',
    'empty': '',
    'long': 'x' * 100_000,
    'k: #\x85' + 2000 * '"': 'a key that is none for YAML without quotes, nor a short one',
}


@pytest.mark.parametrize(
    'load',
    [
        pytest.param(yaml.safe_load, id='PyYAML'),
        pytest.param(lambda text: yaml.load(text, yaml.CSafeLoader), id='libyaml'),
        pytest.param(YAML(typ='safe', pure=True).load, id='ruamel'),
    ],
)
def test_every_text_comes_back_from_metadata_yaml(tmp_path, load):
    """By readers of YAML 1.1 and, as rosbags has it, of 1.2; from the files' own records too."""
    BagWriter(tmp_path / 'bag', [A], preamble={'own': TEXTS}).close()
    outer = load((tmp_path / 'bag/metadata.yaml').read_text(encoding='utf-8'))
    assert outer['rosbag2_bagfile_information']['custom_data'] == TEXTS
    said = said_in(tmp_path / 'bag/bag_0.mcap', load)
    assert [each['custom_data'] for each in said] == [TEXTS, TEXTS]


def test_what_is_written_is_read_whatever_its_texts(tmp_path):
    """Texts of more than the 2 MB that a file of YAML alone may have; recover finds them too."""
    texts = TEXTS | {'many': '\xe9\n' * 1_000_000}
    BagWriter(tmp_path / 'bag', [A], preamble={'own': texts}).close()
    path = tmp_path / 'bag/metadata.yaml'
    assert path.stat().st_size > 2_000_000
    assert check(Bag(tmp_path / 'bag')) == []
    information = Bag(tmp_path / 'bag').information
    assert information is not None
    assert information['custom_data'] == texts
    before = path.read_bytes()
    path.unlink()
    assert recover(tmp_path / 'bag').files == ('metadata.yaml',)
    assert path.read_bytes() == before


def test_a_name_that_is_not_utf_8_is_refused(tmp_path):
    """What names the files of the bag must be text; nothing is made."""
    with pytest.raises(OSError, match=r'cannot be created: its name is not UTF-8$'):
        BagWriter(tmp_path / 'b\udcff', [A])
    assert list(tmp_path.iterdir()) == []


def test_a_name_that_yaml_would_misread_is_quoted(tmp_path):
    """A directory may be called anything; its metadata.yaml still names its file."""
    BagWriter(tmp_path / '12: #x', [A]).close()
    information = yaml.safe_load((tmp_path / '12: #x' / 'metadata.yaml').read_text())
    assert information['rosbag2_bagfile_information']['relative_file_paths'] == ['12: #x_0.mcap']


@pytest.mark.parametrize('compression', ['none', 'lz4', 'zstd'])
def test_every_compression_gives_the_same_messages(tmp_path, compression):
    """Chunks of 768 KiB with checksums, whatever they are compressed with."""
    count = 50_000
    with closing(BagWriter(tmp_path / 'bag', [A, B], compression=compression)) as writer:
        writer.write(stamps(count), {'/a': rows(12, count), '/b': rows(5, count)})
    chunks = only(tmp_path / 'bag/bag_0.mcap', Chunk)
    name = '' if compression == 'none' else compression
    assert {chunk.compression for chunk in chunks} == {name}
    assert all(chunk.uncompressed_crc for chunk in chunks)
    sizes = [chunk.uncompressed_size for chunk in chunks]
    tick = 2 * 31 + 12 + 5
    assert all(786432 <= size < 786432 + tick for size in sizes[:-1])
    assert len(sizes) == 6
    assert flights.sequence(tmp_path / 'bag') == [
        (topic, stamp, bytes([k % 256]) * length)
        for k, stamp in enumerate(stamps(count).tolist())
        for topic, length in (('/a', 12), ('/b', 5))
    ]


def test_an_unknown_compression_is_refused(tmp_path):
    """By name, before anything is made."""
    with pytest.raises(ValueError, match=r"record\.compression is 'gzip'; allowed: none, lz4"):
        BagWriter(tmp_path / 'bag', [A], compression='gzip')
    assert not (tmp_path / 'bag').exists()


def test_blocks_do_not_change_the_sequence(tmp_path):
    """Row by row as the node writes and in one piece as an offline run does: the same messages."""
    written = []
    for block in (1, 7, 500):
        with closing(BagWriter(tmp_path / f'{block}', [A, B])) as writer:
            for first in range(0, 500, block):
                count = min(block, 500 - first)
                messages = {'/a': rows(12, count, first), '/b': rows(5, count, first)}
                writer.write(stamps(count, first), messages)
        written.append(flights.sequence(tmp_path / f'{block}'))
    assert len(written[0]) == 1000
    assert written[0] == written[1] == written[2]


def test_a_message_larger_than_a_chunk_is_written_whole(tmp_path):
    """A chunk holds at least one tick."""
    with closing(BagWriter(tmp_path / 'bag', [A])) as writer:
        writer.write(stamps(2), {'/a': rows(2_000_000, 2)})
    assert [len(data) for _, _, data in flights.sequence(tmp_path / 'bag')] == [2_000_000] * 2


def test_a_topic_may_come_later(tmp_path):
    """rosbag2 takes in topics at any time; one that is known already stays as it is."""
    with closing(BagWriter(tmp_path / 'bag', [A])) as writer:
        writer.write(stamps(1), {'/a': rows(12, 1)})
        writer.add_topic(B)
        writer.add_topic(A)
        writer.write(stamps(1, 1), {'/b': rows(5, 1, 1), '/a': rows(12, 1, 1)})
    assert [topic for topic, _, _ in flights.sequence(tmp_path / 'bag')] == ['/a', '/b', '/a']
    assert [c.topic for c in only(tmp_path / 'bag/bag_0.mcap', Channel)] == ['/a', '/b']


# -- splitting -----------------------------------------------------------------------------------


def test_a_bag_splits_by_duration(tmp_path):
    """As rosbag2: a file spans no more than the duration; each begins with the run's snapshot."""
    asked = []

    def snapshot(row):
        asked.append(row)
        return 'satdyn_ros/snapshot', {'row': str(row)}

    with closing(BagWriter(tmp_path / 'bag', [A], max_duration_s=1.0)) as writer:
        writer.write(stamps(30), {'/a': rows(12, 30)}, snapshot)
    information = yaml.safe_load((tmp_path / 'bag/metadata.yaml').read_text())
    files = information['rosbag2_bagfile_information']['files']
    assert [file['path'] for file in files] == ['bag_0.mcap', 'bag_1.mcap', 'bag_2.mcap']
    assert [file['message_count'] for file in files] == [11, 11, 8]
    assert [file['duration']['nanoseconds'] for file in files] == [10**9, 10**9, 7 * 10**8]
    assert asked == [0, 11, 22]
    for path, row in zip(sorted((tmp_path / 'bag').glob('*.mcap')), asked, strict=True):
        names = [record.name for record in only(path, Metadata)]
        assert names == ['rosbag2', 'satdyn_ros/snapshot', 'rosbag2']
        assert only(path, Metadata)[1].metadata == {'row': str(row)}
        assert len(only(path, Schema)) == len(only(path, Channel)) == 1
    assert len(flights.sequence(tmp_path / 'bag')) == 30


def split(directory, file_count):
    """Write so many files of eleven messages; return their sizes and that of metadata.yaml."""
    # Uncompressed, as what is compressed has the size of its content.
    with closing(
        BagWriter(directory, [A, B], compression='none', max_duration_s=1.0, preamble=PREAMBLE)
    ) as writer:
        writer.write(stamps(11 * file_count), {'/a': rows(12, 11 * file_count)})
    files = [directory / f'{directory.name}_{k}.mcap' for k in range(file_count)]
    assert sorted(files) == sorted(directory.glob('*.mcap'))
    return [path.stat().st_size for path in files], (directory / 'metadata.yaml').stat().st_size


PREAMBLE = {'own': {'text': 'caf\xe9\n' * 100}}


def test_every_file_costs_the_same(tmp_path, monkeypatch):
    """
    Its own records name itself alone, and metadata.yaml, which grows by it, is written once.

    Numbers of files are chosen so that those that are written have as many digits.
    """
    completed = []
    replace = os.replace

    def counted(old, new):
        completed.append(new)
        replace(old, new)

    monkeypatch.setattr(os, 'replace', counted)
    sizes, of_yaml = zip(
        *(split(tmp_path / f'bag_{count}', count) for count in (30, 50, 70)), strict=True
    )
    assert completed == [tmp_path / f'bag_{count}/metadata.yaml' for count in (30, 50, 70)]
    assert len({*sizes[-1][10:], *sizes[0][10:]}) == len({*sizes[-1][:10]}) == 1
    assert of_yaml[2] - of_yaml[1] == of_yaml[1] - of_yaml[0] < 20 * 300
    outer = yaml.safe_load((tmp_path / 'bag_30/metadata.yaml').read_text())
    files = {file['path']: file for file in outer['rosbag2_bagfile_information']['files']}
    assert len(files) == 30
    for name in list(files)[::7]:
        begin, end = said_in(tmp_path / 'bag_30' / name)
        assert begin['relative_file_paths'] == end['relative_file_paths'] == [name]
        assert end['files'] == [files[name]]
        assert end['message_count'] == 11
        assert begin['custom_data'] == end['custom_data'] == PREAMBLE['own']
        assert [topic['message_count'] for topic in end['topics_with_message_count']] == [11, 0]


def test_files_leave_little_in_memory(tmp_path):
    """Of a file that is complete what metadata.yaml will say stays: a name and three numbers."""
    with closing(BagWriter(tmp_path / 'bag', [A], max_duration_s=1.0)) as writer:
        held = []
        tracemalloc.start()
        for first in range(0, 80, 20):
            writer.write(stamps(220, 11 * first), {'/a': rows(12, 220)})
            held.append(tracemalloc.get_traced_memory()[0])
        tracemalloc.stop()
    assert writer.file_count == 80
    assert held[-1] - held[1] < 40 * 500


def test_every_file_is_read_the_same_number_of_times(tmp_path, monkeypatch):
    """To check a bag, and to complete it, costs each file the same, however many there are."""
    opened = []

    def counted(path, *arguments, **keywords):
        opened.append(path)
        return open(path, *arguments, **keywords)

    for module in (scan_module, summary_module):
        monkeypatch.setattr(module, 'open', counted, raising=False)
    counts = []
    for count in (3, 6):
        split(tmp_path / f'{count}', count)
        before = len(opened)
        check(Bag(tmp_path / f'{count}'))
        (tmp_path / f'{count}/metadata.yaml').unlink()
        recover(tmp_path / f'{count}')
        counts.append(len(opened) - before)
    assert counts[0] % 3 == 1  # custom_data are read from the first
    assert counts[1] - counts[0] == 3 * (counts[0] // 3)


def test_a_size_is_known_without_looking(tmp_path):
    """That of the files that are complete and of the one that is written."""
    writer = BagWriter(tmp_path / 'bag', [A], max_duration_s=1.0)
    for first in (0, 7, 30):
        writer.write(stamps(20, first), {'/a': rows(12, 20)})
        writer.flush()
        files = list((tmp_path / 'bag').glob('*.mcap'))
        assert writer.size_bytes == sum(path.stat().st_size for path in files)
    writer.close()
    assert writer.size_bytes == sum(path.stat().st_size for path in files)


@pytest.mark.parametrize('at_once', [1000, 100_000])
def test_a_bag_splits_by_size(tmp_path, at_once):
    """As rosbag2: a file that has reached the size is followed by the next one."""
    count = 100_000
    noise = np.random.default_rng(1).integers(0, 256, (count, 20), np.uint8).view('V20')[:, 0]
    with closing(BagWriter(tmp_path / 'bag', [A], max_size_bytes=1_000_000)) as writer:
        for first in range(0, count, at_once):
            part = slice(first, first + at_once)
            writer.write(stamps(at_once, first), {'/a': noise[part]})
    sizes = [path.stat().st_size for path in sorted((tmp_path / 'bag').glob('*.mcap'))]
    assert len(sizes) >= 3
    # It ends with the chunk that reached the size; compressed chunks and indexes are below 1 MB.
    assert all(1_000_000 <= size < 2_000_000 for size in sizes[:-1])
    assert [data for _, _, data in flights.sequence(tmp_path / 'bag')] == [bytes(n) for n in noise]


def test_a_file_that_begins_too_large_still_takes_a_chunk(tmp_path):
    """A limit below the size of what every file begins with ends it at its first chunk."""
    with closing(BagWriter(tmp_path / 'bag', [A], max_size_bytes=1)) as writer:
        writer.write(stamps(100_000), {'/a': rows(12, 100_000)})
    paths = sorted((tmp_path / 'bag').glob('*.mcap'))
    assert len(paths) >= 3
    assert [len(only(path, Chunk)) for path in paths] == [1] * len(paths)
    assert len(flights.sequence(tmp_path / 'bag')) == 100_000


# -- what outlives the writer --------------------------------------------------------------------


def test_flushed_messages_are_with_the_system(tmp_path):
    """Another process finds what was flushed while the writer still has the file open."""
    writer = BagWriter(tmp_path / 'bag', [A])
    writer.write(stamps(10), {'/a': rows(12, 10)})
    writer.flush()
    writer.write(stamps(1, 10), {'/a': rows(12, 1, 10)})
    assert not (tmp_path / 'bag/metadata.yaml').exists()
    found = [found.item for found in scan(tmp_path / 'bag/bag_0.mcap')]
    assert isinstance(found[-1], Flaw)
    assert isinstance(found[-1].error, Incomplete)
    assert [len(block.contents) for block in found if isinstance(block, Block)] == [10]
    writer.close()
    assert len(flights.sequence(tmp_path / 'bag')) == 11


def test_memory_stays_flat(tmp_path):
    """Forty times the messages take the same memory but for the index of chunks."""
    with closing(BagWriter(tmp_path / 'bag', [A])) as writer:
        tracemalloc.start()
        peaks = []
        for first in range(0, 80, 2):
            writer.write(stamps(9000, 9000 * first), {'/a': rows(60, 9000)})
            peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[-1] - peaks[1] < 100_000


# -- refusals ------------------------------------------------------------------------------------


def test_a_directory_that_exists_is_left_alone(tmp_path):
    """A bag never overwrites another."""
    with pytest.raises(FileExistsError, match=r'already exists; a bag needs a new directory$'):
        BagWriter(tmp_path, [A])
    assert list(tmp_path.iterdir()) == []


def test_a_folder_without_permission_is_reported(tmp_path):
    """The sentence names the bag and says what the system says; the superuser asks as nobody."""
    (tmp_path / 'locked').mkdir(mode=0o500)
    program = """if True:
        import os, sys
        from satdyn_ros.rosbag2.writer import BagWriter
        if os.geteuid() == 0:
            os.setuid(65534)
        try:
            BagWriter(sys.argv[1], [])
        except PermissionError as error:
            print(error)
    """
    path = tmp_path / 'locked/bag'
    result = subprocess.run(
        [sys.executable, '-c', program, path], capture_output=True, text=True, check=True
    )
    assert result.stdout == f'the bag {path} cannot be created: Permission denied\n'


def test_a_full_disk_is_reported_once_and_what_was_written_stays(tmp_path):
    """A limit on the size of files simulates a full disk; the bag is recoverable after it."""
    program = """if True:
        import resource, sys
        import numpy as np
        from satdyn_ros.rosbag2.metadata import TopicMetadata
        from satdyn_ros.rosbag2.writer import BagWriter
        resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))
        topic = TopicMetadata('/a', 'std_msgs/msg/Int64', 'int64 data', '', '')
        writer = BagWriter(sys.argv[1], [topic], compression='none')
        for k in range(20):
            row = np.full(20_000, k, np.uint8).view('V20000')
            try:
                writer.write(np.array([k]), {'/a': row})
                writer.flush()
            except OSError as error:
                print(k, error)
        writer.close()
    """
    path = tmp_path / 'bag'
    result = subprocess.run(
        [sys.executable, '-c', program, path], capture_output=True, text=True, check=True
    )
    failed = [line.split(' ', 1) for line in result.stdout.splitlines()]
    assert [int(k) for k, _ in failed] == list(range(int(failed[0][0]), 20))
    assert {sentence for _, sentence in failed} == {
        f'the bag {path} can no longer be written: File too large; satdyn recover completes it'
    }
    assert not (path / 'metadata.yaml').exists()
    found = [found.item for found in scan(path / 'bag_0.mcap')]
    kept = sum(len(block.contents) for block in found if isinstance(block, Block))
    assert kept == int(failed[0][0]) == 9


def test_header_names_the_profile(bag):
    """Players choose by it how messages are decoded."""
    assert [header.profile for header in only(bag / 'bag_0.mcap', Header)] == ['ros2']
