"""Whatever the bytes of a file: what reading it costs is bounded, in counts."""

import struct

import numpy as np
import pytest
from mcap.opcode import Opcode
from mcap.records import Channel, Header, Metadata
from mcap.writer import MCAP0_MAGIC

from satdyn_ros.rosbag2 import budget
from satdyn_ros.rosbag2.chunk import Contents
from satdyn_ros.rosbag2.compression import compressor
from satdyn_ros.rosbag2.errors import BagError, Damaged
from satdyn_ros.rosbag2.mcap_file import McapFile
from satdyn_ros.rosbag2.records import PREFIX, written
from satdyn_ros.rosbag2.recover import recover
from satdyn_ros.rosbag2.scan import Block, Flaw, Scanner, scan

METADATA = written([Metadata('', {})])
MESSAGE = PREFIX.pack(Opcode.MESSAGE, 22) + bytes(22)
NOISE = b'\xff' * 9
# Bytes in which records seem to begin everywhere, or to reach far.
PATTERNS = {
    'headers': bytes([Opcode.MESSAGE, 1, 1, 1, 0, 0, 0, 0, 0]),
    'dense headers': bytes([5, 5, 5, 1, 0, 0, 0, 0, 0]),
    'chunks': PREFIX.pack(Opcode.CHUNK, 49),
    'two messages': MESSAGE + MESSAGE + NOISE,
    'far records': PREFIX.pack(Opcode.METADATA, 400_000) + struct.pack('<I', 100_000),
    'far statistics': PREFIX.pack(Opcode.STATISTICS, 400_000) + bytes(42),
    'far unknown records': PREFIX.pack(200, 400_000) + NOISE,
    'records and noise': NOISE + METADATA,
    'messages and noise': NOISE + 3 * MESSAGE,
    'noise': NOISE,
    'zeros': bytes(9),
}


class Counting(Scanner):
    """A scanner that counts the bytes that it has read, and where it has looked for a record."""

    def __init__(self, path, file):
        self.byte_count = self.look_count = 0
        super().__init__(path, file)

    def _read(self, start, length):
        data = super()._read(start, length)
        self.byte_count += len(data)
        return data

    def _is_record(self, start, chain=3):
        self.look_count += 1
        return super()._is_record(start, chain)


def read_all(path, content):
    """Read a file of this content as far as it is read; return the scanner and why it ended."""
    path.write_bytes(MCAP0_MAGIC + content)
    with open(path, 'rb') as file:
        scanner = Counting(path, file)
        try:
            for _ in scanner.found():
                pass
        except BagError as error:
            return scanner, str(error)
    return scanner, ''


@pytest.mark.parametrize('name', PATTERNS)
def test_bytes_that_look_like_records_cost_a_bounded_number_of_looks(tmp_path, name):
    """At most four for each of the damaged parts and records that the budget allows."""
    size = 1_000_000
    piece = PATTERNS[name]
    scanner, why = read_all(tmp_path / 'a.mcap', piece * (size // len(piece)))
    most = 2**29 // budget.DAMAGE + size // len(piece) + 1
    assert scanner.look_count <= 4 * most
    assert scanner.byte_count <= 4 * 2**29
    assert why == '' or 'the limit for a file of its size' in why


def test_a_file_has_no_more_records_than_its_size_allows(tmp_path, monkeypatch):
    """Twenty thousand of 17 bytes are too many where those of 50 are not, however many."""
    monkeypatch.setattr(budget, '_LEAST', 10 * 2**20)
    small, large = METADATA, written([Metadata('x' * 33, {})])
    assert (len(small), len(large)) == (17, 50)
    _, why = read_all(tmp_path / 'a.mcap', 20_000 * small)
    assert why == (
        f'{tmp_path}/a.mcap is damaged: reading it takes more than the work of '
        f'{64 * (8 + 20_000 * 17)} bytes, the limit for a file of its size'
    )
    assert read_all(tmp_path / 'b.mcap', 20_000 * large)[1] == ''


def test_messages_outside_chunks_are_read_together(tmp_path):
    """As many blocks as chunks would be, and not a message less."""
    path = tmp_path / 'a.mcap'
    path.write_bytes(MCAP0_MAGIC + 50_000 * MESSAGE)
    blocks = [found.item for found in scan(path) if isinstance(found.item, Block)]
    assert len(blocks) < 5
    assert b''.join(block.contents.data.tobytes() for block in blocks) == 50_000 * MESSAGE
    assert sum(len(block.contents) for block in blocks) == 50_000


def test_a_file_with_damage_everywhere_is_refused_and_left_as_it_is(tmp_path):
    """One sentence, and recover writes nothing."""
    path = tmp_path / 'a.mcap'
    content = MCAP0_MAGIC + METADATA + (NOISE + METADATA) * 10_000
    path.write_bytes(content)
    with pytest.raises(BagError, match='takes more than the work of 536870912 bytes, the limit'):
        recover(path)
    assert path.read_bytes() == content
    assert [file.name for file in tmp_path.iterdir()] == ['a.mcap']


@pytest.mark.parametrize(('name', 'count'), [('', 20_000), ('x' * 1_000_000, 5)])
def test_what_all_chunks_declare_is_bounded(tmp_path, name, count):
    """However small they are when compressed: by their number, and by their bytes."""
    channels = written([Channel(1, name, '', {}, 0)] * count)
    contents = Contents(np.frombuffer(channels, np.uint8))
    file = McapFile(tmp_path / 'a.mcap', Header('ros2', 'another'))
    for _ in range(2):
        file.write_chunk(contents, 'zstd', compressor('zstd')(contents.data))
    file.finish()
    first, second = [found for found in scan(file.path) if isinstance(found.item, Block | Flaw)]
    assert isinstance(first.item, Block)
    with pytest.raises(Damaged, match=r'Chunk record .* takes more than the work of'):
        second.sound()
