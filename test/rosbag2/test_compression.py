"""Contents are expanded within what is claimed and a ceiling, whatever the bytes."""

import struct
import subprocess
import sys
import zlib

import lz4.frame
import numpy as np
import pytest
import zstandard
from mcap.records import Channel, Chunk, DataEnd, Footer, Header, Schema
from mcap.writer import MCAP0_MAGIC

from satdyn_ros.rosbag2 import budget
from satdyn_ros.rosbag2.compression import compressor, decompress, zstd_size
from satdyn_ros.rosbag2.errors import Damaged
from satdyn_ros.rosbag2.reader import Bag
from satdyn_ros.rosbag2.records import written
from satdyn_ros.rosbag2.recover import recover

TEXT = b'the same words again and again ' * 1000


@pytest.mark.parametrize('compression', ['', 'lz4', 'zstd'])
def test_contents_come_back(compression):
    """Whatever they were compressed with, of the size that is claimed."""
    data = compressor(compression)(np.frombuffer(TEXT, np.uint8))
    assert decompress(compression, data, len(TEXT)) == TEXT


@pytest.mark.parametrize('compression', ['', 'lz4', 'zstd'])
@pytest.mark.parametrize('claimed', [0, 1, len(TEXT) - 1, len(TEXT) + 1, 2**60])
def test_another_size_than_claimed_is_refused(compression, claimed):
    """More or less than the chunk says, or more than any chunk may hold."""
    data = compressor(compression)(np.frombuffer(TEXT, np.uint8))
    with pytest.raises(Damaged, match='bytes'):
        decompress(compression, data, claimed)


@pytest.mark.parametrize('cut', [1, 3])
def test_a_frame_that_is_cut_off_is_refused(cut):
    """Also where only its checksum lacks bytes, and all contents are there."""
    frame = zstandard.ZstdCompressor(write_checksum=True).compress(TEXT)
    assert decompress('zstd', frame, len(TEXT)) == TEXT
    with pytest.raises(Damaged, match='full frame'):
        decompress('zstd', frame[:-cut], len(TEXT))


def test_another_compression_is_named():
    """Only the compressions of MCAP, lz4 and zstd, are supported."""
    with pytest.raises(Damaged, match="its compression is 'br'; lz4 and zstd are supported"):
        decompress('br', b'', 0)
    with pytest.raises(Damaged, match='not compressed with zstd'):
        zstd_size(b'plain')


def frame_without_size(count):
    """Return a zstd frame of zeros that does not say its size."""
    context = zstandard.ZstdCompressor().compressobj()
    return b''.join([*(context.compress(bytes(2**20)) for _ in range(count)), context.flush()])


def test_bombs_are_not_expanded(tmp_path):
    """Two gigabytes behind a claim of 1000 bytes: they take less than 100 MB of memory."""
    with lz4.frame.open(tmp_path / 'lz4', 'wb') as file:
        for _ in range(256):
            file.write(bytes(8 * 2**20))
    (tmp_path / 'zstd').write_bytes(frame_without_size(2048))
    program = """if True:
        import resource, sys
        from pathlib import Path
        from satdyn_ros.rosbag2.compression import decompress
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        for name in ('lz4', 'zstd'):
            data = (Path(sys.argv[1]) / name).read_bytes()
            try:
                decompress(name, data, 1000)
            except ValueError as error:
                print(error)
        after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        print((after - before) / 1024 < 100)
    """
    command = [sys.executable, '-c', program, tmp_path]
    result = subprocess.run(command, capture_output=True, text=True, check=True)
    *sentences, is_small = result.stdout.splitlines()
    assert len(sentences) == 2
    assert is_small == 'True'


def file_of_equal_messages(path, length, messages, chunks):
    """Write so many equal chunks of so many equal messages."""
    message = struct.pack('<BQHIQQ', 5, 22 + length, 1, 0, 0, 0) + bytes(length)
    declared = written([Schema(1, b'', 'ros2msg', 'a/msg/A'), Channel(1, '/a', 'cdr', {}, 1)])
    contents = declared + messages * message
    data = zstandard.ZstdCompressor().compress(contents)
    chunk = Chunk('zstd', data, 0, 0, zlib.crc32(contents), len(contents))
    parts = [MCAP0_MAGIC, written([Header('ros2', 'another')])]
    parts += chunks * [written([chunk])]
    parts += [written([DataEnd(0), Footer(0, 0, 0)]), MCAP0_MAGIC]
    path.write_bytes(b''.join(parts))
    return path


def test_a_million_equal_messages_are_read(tmp_path):
    """An honest file may be a hundred times smaller than what it holds."""
    path = file_of_equal_messages(tmp_path / 'equal.mcap', 64, 5000, 200)
    assert path.stat().st_size < 200 * 5000 * 95 / 100
    assert len(Bag(path).messages('/a').log_times_ns) == 1_000_000


def test_many_bombs_in_one_file_end_soon(tmp_path, monkeypatch):
    """Each chunk is allowed, all together are not: recover keeps those that come first."""
    path = file_of_equal_messages(tmp_path / 'bombs.mcap', 786_000, 1, 20)
    monkeypatch.setattr(budget, '_LEAST', 10 * 2**20)
    with pytest.raises(Damaged, match=r'Chunk record .* more than the work of 10485760 bytes'):
        Bag(path).messages('/a')
    recovered = recover(path, tmp_path / 'kept.mcap')
    assert recovered.message_count == 12
    assert len(recovered.losses) == 1


def test_millions_of_empty_messages_end_soon(tmp_path, monkeypatch):
    """They take a few bytes when compressed, but a reader a microsecond each."""
    path = file_of_equal_messages(tmp_path / 'empty.mcap', 0, 5000, 20)
    monkeypatch.setattr(budget, '_LEAST', 10 * 2**20)
    with pytest.raises(Damaged, match='more than the work of 10485760 bytes'):
        Bag(path).messages('/a')
    recovered = recover(path, tmp_path / 'kept.mcap')
    assert recovered.message_count == 60_000
    assert len(recovered.losses) == 1
