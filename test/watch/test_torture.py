"""Ten minutes of a node at 1000 Hz with a page open: its memory and the server's stay flat."""

import asyncio
import math
import os
import time
from pathlib import Path

import aiohttp
import browser as pages
import pytest
from ros.live import LiveNode

VALUES = {'publish.rate': 1000.0, 'publish.topics': ['attitude', 'imu', 'odometry', 'rotor']}


async def watched(url, duration_s, most=math.inf):
    """Take frames as a browser does, for a time or until so many came; return how many did."""
    frames, begin_s = 0, time.monotonic()
    async with (
        aiohttp.ClientSession() as session,
        session.ws_connect(f'{url}socket', max_msg_size=0) as socket,
    ):
        while time.monotonic() - begin_s < duration_s and frames < most:
            message = await socket.receive(timeout=60)
            frames += '"type": "rows"' in message.data[:40]
    return frames


def resident(pid):
    """Return the memory of a process [byte]."""
    pages = int(Path(f'/proc/{pid}/statm').read_text().split()[1])
    return pages * os.sysconf('SC_PAGE_SIZE')


def heap(browser):
    """Return what the scripts of a page hold [byte], garbage collected."""
    browser.execute_cdp_cmd('HeapProfiler.collectGarbage', {})
    return browser.execute_cdp_cmd('Runtime.getHeapUsage', {})['usedSize']


@pytest.fixture
def url(watch, tmp_path):
    """Return the URL of the page of a node at 1000 Hz."""
    node = LiveNode(tmp_path, VALUES, namespace='/tortured')
    yield watch('--node', '/tortured/satdyn')
    node.end()


@pytest.mark.torture
@pytest.mark.timeout(1800)
def test_ten_minutes_leave_memory_flat(url, watch, browser):
    """The server keeps 9000 rows, five minutes of a machine that keeps up; then nothing grows."""
    browser.get(url)
    pages.wait(browser, 'window.satdyn && satdyn.rows.length > 5')
    asyncio.run(watched(url, 1200.0, most=9300))
    before = resident(watch.pid), heap(browser)
    frames = asyncio.run(watched(url, 300.0))
    after = resident(watch.pid), heap(browser)
    print(f'{frames / 300.0:.1f} frames a second; server and page [byte]: {before}, {after}')
    assert 0 < frames <= 31 * 300
    assert pages.errors(browser) == []
    # Fragments of the allocator; 300 s of frames kept by mistake would be 20 MB at 30 a second.
    assert after[0] - before[0] < 8e6
    # The page keeps between 9000 rows and a quarter more, each of some 300 bytes.
    assert after[1] - before[1] < 4e6


@pytest.mark.long
def test_frames_are_at_most_thirty_a_second(url):
    """A node at 1000 Hz gives no more frames than the eye takes."""
    asyncio.run(watched(url, 1.0))
    assert 0 < asyncio.run(watched(url, 3.0)) <= 34 * 3
