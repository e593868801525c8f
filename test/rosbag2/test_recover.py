"""A bag whose writer did not finish is completed, and loses nothing that was written."""

import itertools
import random
import re
import subprocess
import sys

import flights
import pytest
import yaml
from mcap.reader import make_reader
from mcap.records import Chunk, Message
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.writer import CompressionType, Writer
from rosbags.rosbag2 import Reader

from satdyn_ros.bag.verify import verify
from satdyn_ros.rosbag2.errors import BagError
from satdyn_ros.rosbag2.integrity import check
from satdyn_ros.rosbag2.reader import Bag
from satdyn_ros.rosbag2.recover import recover

SCENARIO = flights.GYROSTAT.with_values({'publish.topics': ('attitude', 'imu')})
TICKS = 200


@pytest.fixture(
    scope='module',
    params=[
        'zstd',
        pytest.param('lz4', marks=pytest.mark.long),
        pytest.param('none', marks=pytest.mark.long),
    ],
)
def whole(request, tmp_path_factory):
    """Record a bag of several chunks and return it with its messages."""
    scenario = SCENARIO.with_values({'record.compression': request.param})
    path = tmp_path_factory.mktemp(request.param) / 'bag'
    flights.record(path, scenario, TICKS, flights.EVENTS, block=17, flush=True)
    return path, flights.sequence(path)


def cut(whole, directory, length):
    """Return a bag with the first bytes of another one's file, as a killed writer leaves it."""
    directory.mkdir()
    data = (whole / 'bag_0.mcap').read_bytes()
    (directory / 'bag_0.mcap').write_bytes(data[:length])
    return directory


def information(path):
    return yaml.safe_load((path / 'metadata.yaml').read_text())['rosbag2_bagfile_information']


def chunk_ends(path):
    """Return, for each chunk of a file, where it ends and how many messages there are by then."""
    chunks = [r for r in StreamReader(str(path), emit_chunks=True).records if isinstance(r, Chunk)]
    counts = [sum(isinstance(r, Message) for r in breakup_chunk(chunk)) for chunk in chunks]
    indexes = flights.summary(path).chunk_indexes
    ends = [index.chunk_start_offset + index.chunk_length for index in indexes]
    return list(zip(ends, itertools.accumulate(counts), strict=True))


def test_a_file_cut_anywhere_keeps_all_that_was_written(whole, tmp_path):
    """What is left is the start of the sequence, with every whole chunk; other readers agree."""
    path, messages = whole
    ends = chunk_ends(path / 'bag_0.mcap')
    size = (path / 'bag_0.mcap').stat().st_size
    edges = [edge + side for edge, _ in ends for side in (-1, 0, 1)]
    for length in sorted({1, 8, 20, size - 9, size - 1, *edges, *range(30, size, size // 12)}):
        bag = cut(path, tmp_path / f'{length}', length)
        recovered = recover(bag)
        kept = flights.sequence(bag)
        assert kept == messages[: len(kept)]
        assert len(kept) >= max([count for end, count in ends if end <= length], default=0)
        assert recovered.message_count == len(kept) == information(bag)['message_count']
        assert recovered.files == ('bag_0.mcap',)
        with Reader(bag) as reader:
            assert reader.message_count == len(kept)
            assert [data for _, _, data in reader.messages()] == [data for _, _, data in kept]
        names = {'bag_0.mcap', 'metadata.yaml'}
        if length in {8, size - 9, size - 1, *(end for end, _ in ends)}:
            assert recovered.losses == ()
        if recovered.losses:
            names.add('bag_0.mcap.damaged')
            assert (bag / 'bag_0.mcap.damaged').stat().st_size == length
        assert {file.name for file in bag.iterdir()} == names
        assert recover(bag).files == ()


def test_an_empty_file_is_no_bag(whole, tmp_path):
    """Nothing is made of nothing: neither of a file, nor of a directory that holds only such."""
    alone = tmp_path / 'alone.mcap'
    alone.touch()
    with pytest.raises(BagError, match=r'alone\.mcap is not a bag: it is empty'):
        recover(alone)
    assert alone.stat().st_size == 0
    bag = cut(whole[0], tmp_path / 'bag', 0)
    before = sorted(file.name for file in bag.iterdir())
    with pytest.raises(BagError, match='bag is not a bag: its files are empty'):
        recover(bag, tmp_path / 'new')
    assert sorted(file.name for file in bag.iterdir()) == before
    assert not (tmp_path / 'new').exists()


def test_an_empty_file_among_others(tmp_path):
    """What the others hold is kept, and it is said that this one holds nothing."""
    scenario = SCENARIO.with_values({'record.max_duration_s': 2.0})
    path = flights.record(tmp_path / 'bag', scenario, TICKS, flights.EVENTS)
    messages, counts = (
        flights.sequence(path),
        [f['message_count'] for f in information(path)['files']],
    )
    (path / 'bag_1.mcap').write_bytes(b'')
    recovered = recover(path)
    assert recovered.files == ('bag_1.mcap',)
    assert list(recovered.losses) == ['bag_1.mcap: the file holds nothing']
    assert flights.sequence(path) == messages[: counts[0]] + messages[sum(counts[:2]) :]
    assert recover(path).losses == ()


def test_what_is_recovered_whole_is_the_file_itself(whole, tmp_path):
    """Killed between the last chunk and the end: recovering writes what the writer would have."""
    path, _ = whole
    data = (path / 'bag_0.mcap').read_bytes()
    bag = cut(path, tmp_path / 'bag', len(data) - 40)
    recover(bag)
    assert (bag / 'bag_0.mcap').read_bytes() == data
    assert (bag / 'metadata.yaml').read_text() == (path / 'metadata.yaml').read_text()


def test_a_recovered_bag_verifies(whole, tmp_path):
    """It holds its scenario and its events as far as it goes."""
    path, _ = whole
    size = (path / 'bag_0.mcap').stat().st_size
    bag = cut(path, tmp_path / 'bag', size * 2 // 3)
    assert 'satdyn recover completes it' in (verify(bag).problem or '')
    recover(bag)
    verdict = verify(bag)
    assert verdict.is_true
    assert verdict.same_bytes
    assert verdict.message_count > 100


def test_blocks_that_the_system_never_filled_end_the_file(whole, tmp_path):
    """After a power cut a file may end with zeros: they are no records."""
    path, messages = whole
    end, count = chunk_ends(path / 'bag_0.mcap')[3]
    bag = cut(path, tmp_path / 'bag', end)
    with open(bag / 'bag_0.mcap', 'ab') as file:
        file.write(bytes(5000))
    recover(bag)
    assert flights.sequence(bag) == messages[:count]


@pytest.mark.parametrize('has_end', [True, False])
def test_a_damaged_chunk_is_lost_alone(whole, tmp_path, has_end):
    """What its checksum does not vouch for is lost, all before and behind it is kept."""
    path, messages = whole
    (_, kept), (end, count), *_ = chunk_ends(path / 'bag_0.mcap')
    size = (path / 'bag_0.mcap').stat().st_size
    bag = cut(path, tmp_path / 'bag', size if has_end else size - 40)
    data = bytearray((bag / 'bag_0.mcap').read_bytes())
    data[end - 30] ^= 1
    (bag / 'bag_0.mcap').write_bytes(data)
    recovered = recover(bag)
    assert flights.sequence(bag) == messages[:kept] + messages[count:]
    (loss,) = recovered.losses
    found = re.fullmatch(r'bag_0\.mcap: ([0-9]+) bytes lost, the first at byte ([0-9]+)', loss)
    assert found is not None
    byte_count, first = map(int, found.groups())
    assert 0 < byte_count < size / 5
    assert first == end - byte_count
    assert (bag / 'bag_0.mcap.damaged').read_bytes() == data
    assert recover(bag).losses == ()
    assert check(Bag(bag)) == []


@pytest.mark.parametrize('number', [0, 3])
def test_a_chunk_that_declares_leaves_its_declarations(whole, tmp_path, number):
    """Where the chunk is lost that declared channels, the messages behind keep their topics."""
    path, messages = whole
    ends = [(0, 0), *chunk_ends(path / 'bag_0.mcap')]
    bag = cut(path, tmp_path / 'bag', (path / 'bag_0.mcap').stat().st_size)
    with open(bag / 'bag_0.mcap', 'r+b') as file:
        file.seek(ends[number + 1][0] - 100)
        file.write(bytes(60))
    recover(bag)
    assert flights.sequence(bag) == messages[: ends[number][1]] + messages[ends[number + 1][1] :]


def test_bytes_that_are_gone_or_foreign_cost_what_they_touch(whole, tmp_path):
    """A piece cut out, written over or put in, anywhere: all whole chunks elsewhere are kept."""
    path, messages = whole
    data = (path / 'bag_0.mcap').read_bytes()
    ends = chunk_ends(path / 'bag_0.mcap')
    draw = random.Random(4)
    for number in range(30):
        start = draw.randrange(60, len(data) - 60)
        noise = draw.randbytes(40)
        damaged = draw.choice(
            [
                data[:start] + noise + data[start + 40 :],
                data[:start] + data[start + 40 :],
                data[:start] + noise + data[start:],
            ]
        )
        bag = tmp_path / str(number)
        bag.mkdir()
        (bag / 'bag_0.mcap').write_bytes(damaged)
        recover(bag)
        kept = flights.sequence(bag)
        begins = [0, *(count for _, count in ends)]
        touched = next((k for k, (end, _) in enumerate(ends) if end > start), len(ends))
        whole_before = begins[touched]
        assert kept[:whole_before] == messages[:whole_before]
        behind = messages[begins[min(touched + 2, len(ends))] :]
        assert kept[len(kept) - len(behind) :] == behind
        assert check(Bag(bag)) == []


def test_a_damaged_index_or_summary_costs_nothing(whole, tmp_path):
    """They are rebuilt from the data: the file is the one that was written."""
    path, _ = whole
    data = (path / 'bag_0.mcap').read_bytes()
    bag = cut(path, tmp_path / 'bag', len(data))
    for offset in (chunk_ends(path / 'bag_0.mcap')[2][0] + 20, len(data) - 300, len(data) - 20):
        damaged = data[:offset] + bytes([data[offset] ^ 4]) + data[offset + 1 :]
        (bag / 'bag_0.mcap').write_bytes(damaged)
        recovered = recover(bag)
        assert (recovered.files, recovered.losses) == (('bag_0.mcap',), ())
        assert (bag / 'bag_0.mcap').read_bytes() == data


def test_a_changed_event_is_reported_as_what_it_is(whole, tmp_path):
    """A metadata record has no checksum of its own: it is kept, and the doubt is reported."""
    path, messages = whole
    data = (path / 'bag_0.mcap').read_bytes()
    bag = cut(path, tmp_path / 'bag', len(data))
    offset = data.index(b'Timeout') + 3
    damaged = data[:offset] + bytes([data[offset] ^ 1]) + data[offset + 1 :]
    (bag / 'bag_0.mcap').write_bytes(damaged)
    (loss,) = recover(bag).losses
    assert loss == (
        'bag_0.mcap: a Header or Metadata record is not as it was written; '
        'all are kept as they are'
    )
    assert flights.sequence(bag) == messages
    assert (bag / 'bag_0.mcap.damaged').read_bytes() == damaged


def test_a_damaged_metadata_yaml_is_written_again(whole, tmp_path):
    """Every key of it is in the files."""
    path, _ = whole
    bag = cut(path, tmp_path / 'bag', (path / 'bag_0.mcap').stat().st_size)
    text = (path / 'metadata.yaml').read_text()
    for damaged in (
        text.replace('bag_0', 'cag_0'),
        text.replace('message_count: 4', '{'),
        '',
        '[',
    ):
        (bag / 'metadata.yaml').write_text(damaged)
        recovered = recover(bag)
        assert (recovered.files, recovered.losses) == (('metadata.yaml',), ())
        assert (bag / 'metadata.yaml').read_text() == text


def test_a_file_outside_of_the_bag_is_not_touched(whole, tmp_path):
    """A name that leads out of the bag is refused by whoever reads metadata.yaml."""
    path, _ = whole
    size = (path / 'bag_0.mcap').stat().st_size
    bag = cut(path, tmp_path / 'bag', size)
    outside = tmp_path / 'x.mcap'
    outside.write_bytes((path / 'bag_0.mcap').read_bytes()[: size // 2])
    text = (path / 'metadata.yaml').read_text()
    for name in ('../x.mcap', str(outside), '..', 'sub/x.mcap'):
        (bag / 'metadata.yaml').write_text(text.replace('bag_0.mcap', name))
        for read in (recover, Bag):
            with pytest.raises(BagError, match='which is not a file of the bag'):
                read(bag)
    assert outside.stat().st_size == size // 2
    assert sorted(file.name for file in bag.iterdir()) == ['bag_0.mcap', 'metadata.yaml']


@pytest.mark.parametrize('is_bare', [True, False])
def test_a_bag_that_cannot_be_written_is_recovered_elsewhere(whole, tmp_path, is_bare):
    """With an output the old bag is only read."""
    path, messages = whole
    bag = cut(path, tmp_path / 'bag', (path / 'bag_0.mcap').stat().st_size - 40)
    before = (bag / 'bag_0.mcap').read_bytes()
    bag.chmod(0o500)
    old, new = (bag / 'bag_0.mcap', tmp_path / 'new.mcap') if is_bare else (bag, tmp_path / 'new')
    recovered = recover(old, new)
    assert recovered.message_count == len(messages)
    assert flights.sequence(tmp_path if is_bare else new) == messages
    assert check(Bag(new)) == []
    assert (bag / 'bag_0.mcap').read_bytes() == before
    assert [file.name for file in bag.iterdir()] == ['bag_0.mcap']
    with pytest.raises(FileExistsError, match='already exists; a recovered bag needs a new path'):
        recover(old, new)


def test_a_bag_of_several_files(tmp_path):
    """Only the file that was being written is written again; metadata.yaml lists them all."""
    scenario = SCENARIO.with_values({'record.max_duration_s': 2.0})
    path = flights.record(tmp_path / 'bag', scenario, TICKS, flights.EVENTS)
    messages, files = flights.sequence(path), information(path)['files']
    assert len(files) == 4
    (path / 'metadata.yaml').unlink()
    last = path / 'bag_3.mcap'
    last.write_bytes(last.read_bytes()[:-40])
    before = {file.name: file.stat().st_ino for file in path.glob('*.mcap')}
    assert recover(path).files == ('bag_3.mcap',)
    assert flights.sequence(path) == messages
    assert information(path)['files'] == files
    after = {file.name: file.stat().st_ino for file in path.glob('*.mcap')}
    assert [name for name in before if before[name] != after[name]] == ['bag_3.mcap']


def test_more_than_ten_files_keep_their_order(tmp_path):
    """File 10 comes after file 9, not after file 1."""
    scenario = SCENARIO.with_values({'record.max_duration_s': 0.5})
    path = flights.record(tmp_path / 'bag', scenario, TICKS, flights.EVENTS)
    listed = information(path)
    assert len(listed['files']) > 11
    (path / 'metadata.yaml').unlink()
    assert recover(path).files == ('metadata.yaml',)
    assert information(path) == listed


def test_a_killed_file_without_a_message_is_completed(tmp_path):
    """A file that was just begun is an empty one afterwards, in its place."""
    path = flights.record(tmp_path / 'bag', SCENARIO, 10, ())
    (path / 'metadata.yaml').unlink()
    (path / 'bag_1.mcap').touch()
    assert recover(path).files == ('bag_1.mcap',)
    counts = [file['message_count'] for file in information(path)['files']]
    assert counts == [20, 0]
    assert len(flights.sequence(path)) == 20


def test_a_list_that_is_no_longer_true_is_written_again(whole, tmp_path):
    """Of a file that was cut later, behind a metadata.yaml, the counts are new too."""
    path, messages = whole
    bag = cut(path, tmp_path / 'bag', (path / 'bag_0.mcap').stat().st_size // 2)
    (bag / 'metadata.yaml').write_text((path / 'metadata.yaml').read_text())
    recovered = recover(bag)
    assert recovered.files == ('bag_0.mcap',)
    assert information(bag)['message_count'] == recovered.message_count < len(messages)


def test_a_bare_file_is_completed_in_its_place(whole, tmp_path):
    """Without its directory: no metadata.yaml is made."""
    path, messages = whole
    data = (path / 'bag_0.mcap').read_bytes()
    (tmp_path / 'bare.mcap').write_bytes(data[:-40])
    assert recover(tmp_path / 'bare.mcap').files == ('bare.mcap',)
    assert (tmp_path / 'bare.mcap').read_bytes() == data
    assert len(messages) == recover(tmp_path / 'bare.mcap').message_count
    assert [file.name for file in tmp_path.iterdir()] == ['bare.mcap']


@pytest.mark.parametrize('chunked', [True, False])
def test_a_foreign_file_is_completed(tmp_path, chunked):
    """Another writer's bag, in chunks or without, that never came to its end."""
    with open(tmp_path / 'foreign_0.mcap', 'wb') as file:
        writer = Writer(file, 500, CompressionType.LZ4, use_chunking=chunked)
        writer.start('ros2', 'another')
        schema = writer.register_schema('std_msgs/msg/Int8', 'ros2msg', b'int8 data')
        channel = writer.register_channel('/foreign', 'cdr', schema, {})
        for k in range(100):
            writer.add_message(channel, k, bytes([k]), k + 1)
        writer.flush()
    assert recover(tmp_path).message_count == 100
    assert flights.sequence(tmp_path) == [('/foreign', k, bytes([k])) for k in range(100)]
    with open(tmp_path / 'foreign_0.mcap', 'rb') as file:
        reader = make_reader(file, validate_crcs=True)
        assert reader.get_header().library == 'another'
        assert [message.publish_time for _, _, message in reader.iter_messages()][:2] == [1, 2]
    assert list(Bag(tmp_path).topics) == ['/foreign']


def test_a_disk_without_room_leaves_the_old_file(whole, tmp_path):
    """The file that there was stays as it was, and the sentence says what failed."""
    path, _ = whole
    data = (path / 'bag_0.mcap').read_bytes()[:-40]
    bag = cut(path, tmp_path / 'bag', len(data))
    program = """if True:
        import resource, sys
        from satdyn_ros.rosbag2.recover import recover
        resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000))
        try:
            recover(sys.argv[1])
        except OSError as error:
            print(error)
    """
    result = subprocess.run(
        [sys.executable, '-c', program, bag], capture_output=True, text=True, check=True
    )
    assert result.stdout == f'{bag}/bag_0.recovering cannot be written: File too large\n'
    assert (bag / 'bag_0.mcap').read_bytes() == data
    assert [file.name for file in bag.iterdir()] == ['bag_0.mcap']


def test_what_is_no_bag_is_refused(tmp_path):
    """Nothing there, nothing in it, or something else."""
    with pytest.raises(ValueError, match='is not a bag: no such file or directory'):
        recover(tmp_path / 'nothing')
    with pytest.raises(ValueError, match=r'is not a bag: it has no \.mcap file'):
        recover(tmp_path)
    (tmp_path / 'text.mcap').write_text('this is not an MCAP file')
    with pytest.raises(ValueError, match='is not an MCAP file'):
        recover(tmp_path)
    assert (tmp_path / 'text.mcap').read_text() == 'this is not an MCAP file'
