import os
import signal
import subprocess
import sys
from pathlib import Path

import browser as pages
import pytest

ROOT = Path(__file__).parents[2]
os.environ['FASTRTPS_DEFAULT_PROFILES_FILE'] = str(ROOT / 'test/ros/discovery.xml')

pytest.importorskip('aiohttp')


@pytest.fixture(scope='module')
def watch():
    """Return a function that starts `satdyn watch` and returns its URL."""
    running = []

    def begin(*arguments):
        process = subprocess.Popen(
            [sys.executable, '-m', 'satdyn_ros.cli.main', 'watch', *arguments, '--port', '0'],
            cwd=ROOT,
            stdout=subprocess.PIPE,
            text=True,
        )
        running.append(process)
        begin.pid = process.pid
        return process.stdout.readline().removeprefix('watch: ').strip()

    yield begin
    for process in running:
        process.send_signal(signal.SIGINT)
        # Ctrl-C ends it in good order.
        assert process.wait(timeout=60) in (0, 130)


@pytest.fixture(scope='module')
def browser():
    browser = pages.start()
    yield browser
    browser.quit()
