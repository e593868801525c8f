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
            stderr=subprocess.PIPE,
            text=True,
        )
        running.append(process)
        begin.pid = process.pid
        return process.stdout.readline().removeprefix('watch: ').strip()

    yield begin
    for number, process in enumerate(running):
        # Both end it in good order.
        asked, code = ((signal.SIGINT, 0), (signal.SIGTERM, 143))[number % 2]
        process.send_signal(asked)
        assert process.communicate(timeout=60)[1] == ''
        assert process.returncode == code


@pytest.fixture(scope='module')
def browser():
    browser = pages.start()
    yield browser
    browser.quit()
