"""Whatever the bytes of a file: each is read a bounded number of times, told as counts."""

import struct

import numpy as np
import pytest
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Metadata
from mcap.writer import MCAP0_MAGIC

from satdyn_ros.rosbag2.chunk import Contents
from satdyn_ros.rosbag2.compression import CEILING, ResourceBudget
from satdyn_ros.rosbag2.errors import BagError, Damaged
from satdyn_ros.rosbag2.frames import FrameReader
from satdyn_ros.rosbag2.records import PREFIX, written
from satdyn_ros.rosbag2.recover import recover
from satdyn_ros.rosbag2.scan import Block, scan

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


class Counting(FrameReader):
    """A reader that counts the bytes that it has read from the file, and where it has looked."""

    def __init__(self, file):
        self.byte_count = self.look_count = 0
        super().__init__(file, CEILING)

    def read(self, start, length):
        held = self._begin, len(self._buffer)
        data = super().read(start, length)
        if held != (self._begin, len(self._buffer)):
            self.byte_count += len(self._buffer)
        elif length > len(self._buffer):
            self.byte_count += len(data)
        return data

    def is_record(self, start, chain=3):
        self.look_count += 1
        return super().is_record(start, chain)


def read_all(path, content):
    """Read a file of this content as far as it is read; return the reader and why it ended."""
    path.write_bytes(MCAP0_MAGIC + content)
    with open(path, 'rb') as file:
        reader = Counting(file)
        try:
            for _ in reader.frames():
                pass
        except BagError as error:
            return reader, str(error)
    return reader, ''


@pytest.mark.parametrize('name', PATTERNS)
def test_bytes_that_look_like_records_cost_a_bounded_number_of_looks(tmp_path, name):
    """At most four for each of the damaged places allowed, and two buffers read for each look."""
    size = 1_000_000
    piece = PATTERNS[name]
    reader, why = read_all(tmp_path / 'a.mcap', piece * (size // len(piece)))
    assert reader.look_count <= 4 * (5_000 + size // 5_000 + 1)
    assert reader.byte_count <= 2 * (size + reader.look_count * 2**14)
    assert why == '' or 'the limit for a file of its size' in why


def test_a_file_has_no_more_records_than_its_size_allows(tmp_path):
    """A hundred thousand of 17 bytes are too many, forty thousand of 50 are not."""
    small, large = METADATA, written([Metadata('x' * 33, {})])
    assert (len(small), len(large)) == (17, 50)
    _, why = read_all(tmp_path / 'a.mcap', 100_000 * small)
    assert why == (
        f'{tmp_path}/a.mcap has more than 54000 records, the limit for a file of its size'
    )
    assert read_all(tmp_path / 'b.mcap', 40_000 * large)[1] == ''


def test_attachments_are_bounded(tmp_path):
    """They cost as much as chunks, and rosbag2 writes none."""
    attachment = written([Attachment(0, 0, 'a', 'b', b'')])
    _, why = read_all(tmp_path / 'a.mcap', 10_000 * attachment)
    most = 1000 + (len(MCAP0_MAGIC) + 10_000 * len(attachment)) // 1000
    assert why == (
        f'{tmp_path}/a.mcap has more than {most} attachments, the limit for a file of its size'
    )
    assert read_all(tmp_path / 'b.mcap', 1000 * attachment)[1] == ''


def test_messages_outside_chunks_are_read_together(tmp_path):
    """As many frames as buffers, and not a message less."""
    path = tmp_path / 'a.mcap'
    path.write_bytes(MCAP0_MAGIC + 50_000 * MESSAGE)
    with open(path, 'rb') as file:
        frames = list(FrameReader(file, CEILING).frames())
    assert len(frames) < 2 * 50_000 * len(MESSAGE) // 2**14 + 2
    assert b''.join(f.prefix + f.content for f in frames) == 50_000 * MESSAGE
    blocks = [found.item for found in scan(path) if isinstance(found.item, Block)]
    assert sum(len(block.contents) for block in blocks) == 50_000


def test_a_file_with_damage_everywhere_is_refused_and_left_as_it_is(tmp_path):
    """One sentence, and recover writes nothing."""
    path = tmp_path / 'a.mcap'
    content = MCAP0_MAGIC + METADATA + (NOISE + METADATA) * 10_000
    path.write_bytes(content)
    with pytest.raises(BagError, match='is damaged at more than 5052 places, the limit for a'):
        recover(path)
    assert path.read_bytes() == content
    assert [file.name for file in tmp_path.iterdir()] == ['a.mcap']


def test_what_all_chunks_declare_is_bounded():
    """However small they are when compressed: by their number, and by their bytes."""
    for name, count in (('', 20_000), ('x' * 1_000_000, 5)):
        channels = written([Channel(1, name, '', {}, 0)] * count)
        contents = Contents(np.frombuffer(channels, np.uint8))
        budget = ResourceBudget(10_000_000)
        contents.check(budget)
        with pytest.raises(Damaged, match='with it the chunks hold more than 32768 schemas and'):
            contents.check(budget)
