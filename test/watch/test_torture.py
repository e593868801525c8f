"""Ten minutes of a node at 1000 Hz with a page open: memory stays flat."""

import asyncio
import os
import time
from pathlib import Path

import aiohttp
import pytest
from ros.live import LiveNode

VALUES = {'publish.rate': 1000.0, 'publish.topics': ['attitude', 'imu', 'odometry', 'rotor']}


async def watched(url, duration_s):
    """Take the frames as a browser does; return how many came."""
    frames, begin_s = 0, time.monotonic()
    async with (
        aiohttp.ClientSession() as session,
        session.ws_connect(f'{url}socket', max_msg_size=0) as socket,
    ):
        while time.monotonic() - begin_s < duration_s:
            message = await socket.receive(timeout=60)
            frames += '"type": "rows"' in message.data[:40]
    return frames


def resident(pid):
    """Return the memory of a process [byte]."""
    pages = int(Path(f'/proc/{pid}/statm').read_text().split()[1])
    return pages * os.sysconf('SC_PAGE_SIZE')


def flies_flat(watch, tmp_path, warm_s, duration_s):
    """Fly for a time and compare the server's memory before and after."""
    node = LiveNode(tmp_path, VALUES, namespace='/tortured')
    try:
        url = watch('--node', '/tortured/satdyn')
        asyncio.run(watched(url, warm_s))
        before = resident(watch.pid)
        frames = asyncio.run(watched(url, duration_s))
        return frames / duration_s, resident(watch.pid) - before
    finally:
        node.end()


@pytest.mark.torture
def test_ten_minutes_leave_memory_flat(watch, tmp_path):
    """The rows that are kept are full after five minutes; from then on nothing grows."""
    rate_hz, grown = flies_flat(watch, tmp_path, warm_s=330.0, duration_s=300.0)
    assert 0.0 < rate_hz <= 31.0
    # Fragments of the allocator; 300 s of frames kept by mistake would be 20 MB and more.
    assert grown < 8e6


def test_frames_are_at_most_thirty_a_second(watch, tmp_path):
    """A node at 1000 Hz gives no more frames than the eye takes."""
    rate_hz, _ = flies_flat(watch, tmp_path, warm_s=1.0, duration_s=3.0)
    assert 0.0 < rate_hz <= 34.0
