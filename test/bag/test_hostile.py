"""Damaged and hostile bags: every command ends with an answer or one sentence, within bounds."""

import random
import re
import resource
import shutil
import signal
import struct
import sys
from collections import Counter
from contextlib import contextmanager

import flights
import numpy as np
import pytest
from mcap.records import Channel, Message, Metadata

from satdyn_ros.bag import run_metadata
from satdyn_ros.bag.playback import Playback
from satdyn_ros.bag.read_run import RecordedRun
from satdyn_ros.cli.main import main
from satdyn_ros.rosbag2.chunk import Contents
from satdyn_ros.rosbag2.errors import BagError
from satdyn_ros.rosbag2.records import written
from satdyn_ros.rosbag2.scan import Block, scan

SCENARIO = flights.GYROSTAT.with_values({'publish.topics': ('attitude', 'imu')})
# Whatever the bag: a file of 10 MB is to take less than 10 s, and these have some kilobytes.
MOST_S, MOST_KB = 10, 2 * 2**20
NUMBERS = (0, 1, 9, 2**16, 2**31, 2**32 - 1, 2**40, 2**63, 2**64 - 1)
WORDS = ('{', '[', '~', '-1', '1e400', '&a [*a]', '!!python/name:os.system', '"\\0"', '../x.mcap')


@pytest.fixture(scope='module')
def bags(tmp_path_factory):
    """Record small bags: compressed, not compressed, and one of several files."""
    folder = tmp_path_factory.mktemp('bags')
    return [
        flights.record(folder / name / 'bag', SCENARIO.with_values(values), 60, events, 20, True)
        for name, values, events in (
            ('zstd', {}, flights.EVENTS[:-2]),
            ('none', {'record.compression': 'none'}, flights.EVENTS[:2]),
            ('split', {'record.max_duration_s': 0.7, 'record.compression': 'lz4'}, ()),
        )
    ]


def flip(data, draw):
    """Flip bits, close to each other or not."""
    for _ in range(draw.choice((1, 1, 4, 100))):
        data[draw.randrange(len(data))] ^= 1 << draw.randrange(8)


def truncate(data, draw):
    """Cut off the end, the beginning or a piece."""
    first, last = sorted(draw.randrange(len(data)) for _ in range(2))
    del data[draw.choice((slice(first, None), slice(0, first), slice(first, last)))]


def splice(data, draw):
    """Put a piece of the file at another offset, or over it."""
    start = draw.randrange(len(data))
    piece = data[start : start + draw.choice((1, 9, 100, 3000))]
    offset = draw.randrange(len(data))
    data[offset : offset + draw.choice((0, len(piece)))] = piece


def renumber(data, draw):
    """Write another number where a record, or something in it, has a length or an offset."""
    starts = [found.start for found in draw.records]
    offset = draw.choice(starts) + draw.choice((1, 9, 13, 17, 25, 33, 37))
    form = draw.choice(('<Q', '<I', '<H'))
    number = draw.choice((*NUMBERS, *starts, len(data))) % 256 ** struct.calcsize(form)
    data[offset : offset + struct.calcsize(form)] = struct.pack(form, number)


def edit(text, draw):
    """Change words, lines or columns of a YAML text."""
    lines = text.split('\n')
    for _ in range(draw.choice((1, 1, 3))):
        i = draw.randrange(len(lines))
        match draw.randrange(5):
            case 0:
                del lines[i]
            case 1:
                lines.insert(i, lines[draw.randrange(len(lines))])
            case 2:
                lines[i] = re.sub(r'[^ :-]+$', lambda _: draw.choice(WORDS), lines[i])
            case 3:
                lines[i] = ' ' * draw.randrange(5) + lines[i].lstrip()
            case 4:
                lines[i] = lines[i].replace(draw.choice('0123456789abcdef:'), draw.choice(WORDS))
        lines = lines or ['']
    return '\n'.join(lines)


def forge(path, draw):
    """Write a file again, sound in every checksum, with a metadata record that is not true."""
    forged = path.with_suffix('.forged')
    records = [found.item for found in draw.records]
    chosen = draw.choice([record for record in records if isinstance(record, Metadata)])

    def changed(record):
        mapping = dict(record.metadata)
        if record is chosen:
            key = draw.choice(list(mapping))
            match draw.randrange(4):
                case 0:
                    del mapping[key]
                case 1:
                    mapping[key] = draw.choice((*WORDS, *map(str, NUMBERS), '"__class__"', ''))
                case 2:
                    mapping[key] = edit(mapping[key], draw)
                case 3:
                    number = draw.choice(('-1', '1e9', 'null', '"a"', '{}', '[]', 'NaN'))
                    mapping[key] = re.sub(r'-?[0-9][0-9.e-]*', number, mapping[key], count=1)
        return mapping

    flights.rewritten(records, forged, changed).finish()
    forged.replace(path)


def mutate(bag, draw):
    """Change a bag by one of all kinds of mutations, and return its name."""
    path = draw.choice(sorted(bag.glob('*.mcap')))
    draw.records = list(scan(path))
    kind = draw.choice((flip, truncate, splice, renumber, edit, forge))
    if kind is edit:
        yaml = bag / 'metadata.yaml'
        yaml.write_text(edit(yaml.read_text(), draw))
    elif kind is forge:
        forge(path, draw)
        if draw.random() < 0.5:
            (bag / 'metadata.yaml').unlink()
    else:
        data = bytearray(path.read_bytes())
        kind(data, draw)
        path.write_bytes(data)
    return kind.__name__


@contextmanager
def bounded(what):
    """Fail where a command does not end."""

    def stop(*_):
        raise TimeoutError(f'{what} takes more than {MOST_S} s')

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(MOST_S)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def replay(bag):
    """Read what `satdyn replay` publishes; return its exit code."""
    try:
        playback = Playback(bag)
        for _ in playback.messages(list(playback.types), playback.begin_ns):
            pass
    except (BagError, OSError) as error:
        print(error, file=sys.stderr)
        return 2
    return 0


def answers(bag, out):
    """Return the exit code of every command that reads the bag."""
    commands = {
        'verify': lambda: main(['verify', str(bag)]),
        'replay': lambda: replay(bag),
        'export': lambda: main(['export', str(bag), '-o', str(out / 'x.csv')]),
        'report': lambda: main(['report', str(bag), '-o', str(out / 'x.html')]),
        'recover -o': lambda: main(['recover', str(bag), '-o', str(out / 'new')]),
        'recover': lambda: main(['recover', str(bag)]),
        'verify what was recovered': lambda: main(['verify', str(bag)]),
    }
    for name, command in commands.items():
        with bounded(name):
            yield name, command()


def torment(bags, folder, numbers, capsys):
    """Mutate bags, run all commands on each, and print how often each ended how."""
    codes: Counter[tuple[str, int]] = Counter()
    kinds: Counter[str] = Counter()
    outside = folder / 'x.mcap'
    outside.write_bytes(b'not of the bag')
    for number in numbers:
        draw = random.Random(number)
        subfolder = folder / str(number)
        bag = shutil.copytree(draw.choice(bags), subfolder / 'bag')
        kinds[mutate(bag, draw)] += 1
        for name, code in answers(bag, subfolder):
            out, err = capsys.readouterr()
            assert code in (0, 1, 2), (number, name)
            assert 'Traceback' not in out + err, (number, name)
            # What it may compile first, once on a machine, it says in a line of its own.
            said = [line for line in err.splitlines() if not line.startswith('compiling ')]
            assert code != 2 or (len(said) <= 1 and str(subfolder) in err), (number, name, err)
            codes[name, code] += 1
        shutil.rmtree(subfolder)
    assert outside.read_bytes() == b'not of the bag'
    with capsys.disabled():
        print(f'\n{len(numbers)} bags: {dict(kinds)}')
        for (name, code), count in sorted(codes.items()):
            print(f'  {name}: exit {code} {count} times')
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss < MOST_KB


def test_a_hostile_bag_ends_in_an_answer(bags, tmp_path, capsys):
    """Thirty mutations, the same in every run of the test."""
    torment(bags, tmp_path, range(30), capsys)


@pytest.mark.long
def test_a_run_that_halts_is_not_flown_on(tmp_path, capsys):
    """A request for a turn too fast to follow ends the run, wherever its bag ends."""
    whole = flights.record(tmp_path / 'bag', SCENARIO) / 'bag_0.mcap'
    fast = tmp_path / 'fast.mcap'

    def changed(record):
        return {
            key: text.replace('angular_velocity": [0.0, 0.1', 'angular_velocity": [2.9e7, 0.1')
            for key, text in record.metadata.items()
        }

    records = [found.item for found in scan(whole)]
    flights.rewritten(records, fast, changed).finish()
    onward = ['simulate', str(tmp_path / 'gyrostat.yaml'), '--duration', '1', '-o']
    onward += [str(tmp_path / 'on'), '--from', str(fast), '--at', '4']
    (tmp_path / 'gyrostat.yaml').write_text(SCENARIO.to_yaml())
    for argv in (['report', str(fast), '-o', str(tmp_path / 'x.html')], onward):
        with bounded(argv[0]):
            assert main(argv) == 2
        assert re.search(r'cannot continue: .* came to a halt', capsys.readouterr().err)


@pytest.mark.parametrize('command', ['report', 'plot'])
def test_a_message_far_ahead_is_not_flown_to(bags, tmp_path, capsys, command):
    """A bag of some kilobytes cannot hold a run of 146 years, whatever its messages say."""
    (whole,), far = bags[1].glob('*.mcap'), tmp_path / 'far.mcap'
    records = [found.item for found in scan(whole)]
    file = flights.rewritten(records, far)
    *_, last = (record.contents for record in records if isinstance(record, Block))
    message = bytearray(last.data[last.offsets[-1] :])
    struct.pack_into('<Q', message, 15, 2**62)
    file.write_chunk(Contents(np.frombuffer(message, np.uint8)), '', bytes(message))
    file.finish()
    with bounded(command):
        assert main([command, str(far), '-o', str(tmp_path / 'drawn.png')]) == 2
    assert (
        'ticks after its first; the limit for a bag of its size is 50' in capsys.readouterr().err
    )


@pytest.mark.long
def test_the_last_channel_is_found_as_soon_as_the_first(bags, tmp_path, capsys):
    """Thousands of chunks, each with a message on channel 65535."""
    (whole,), forged = bags[1].glob('*.mcap'), tmp_path / 'forged.mcap'
    file = flights.rewritten([found.item for found in scan(whole)], forged)
    extra = [Channel(65535, '/extra', 'cdr', {}, 1), Message(65535, 10**18, bytes(4), 10**18, 0)]
    for records in [extra, *3000 * [extra[1:]]]:
        chunk = written(records)
        file.write_chunk(Contents(np.frombuffer(chunk, np.uint8)), '', chunk)
    file.finish()
    codes = dict(answers(forged, tmp_path))
    assert codes['verify'] == 1
    assert 'an extra message of another topic' in capsys.readouterr().out


def test_provenance_is_parsed_once(bags, tmp_path, monkeypatch):
    """However many blocks of inputs stand between it and the first sample."""
    (whole,), forged = bags[1].glob('*.mcap'), tmp_path / 'forged.mcap'
    header, *records = [found.item for found in scan(whole)]
    provenance = [record for record in records if isinstance(record, Metadata)]
    file = flights.rewritten([header, *provenance], forged)
    for _ in range(20):
        file.write_chunk(Contents(np.empty(0, np.uint8)), '', b'')
    file.finish()
    parse, calls = run_metadata.names_and_machine, []

    def counted(record):
        calls.append(record)
        return parse(record)

    monkeypatch.setattr(run_metadata, 'names_and_machine', counted)
    RecordedRun(forged)
    assert len(calls) == 1


@pytest.mark.parametrize('command', ['report', 'plot'])
def test_a_bag_that_lost_all_messages_is_refused(bags, tmp_path, capsys, command):
    """Its scenario and its snapshot are there, but no chunk."""
    (whole,), empty = bags[1].glob('*.mcap'), tmp_path / 'empty.mcap'
    records = [found.item for found in scan(whole) if not isinstance(found.item, Block)]
    flights.rewritten(records, empty).finish()
    assert main([command, str(empty), '-o', str(tmp_path / 'drawn.png')]) == 2
    assert f'{empty} has no messages' in capsys.readouterr().err


@pytest.mark.torture
def test_1200_hostile_bags(bags, tmp_path, capsys):
    """The same with other seeds."""
    torment(bags, tmp_path, range(1000, 2200), capsys)
