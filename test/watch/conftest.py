import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
os.environ['FASTRTPS_DEFAULT_PROFILES_FILE'] = str(ROOT / 'test/ros/discovery.xml')

pytest.importorskip('aiohttp')


# What the first of them may say.
COMPILING = 'compiling, for some ten seconds: the code is kept for the next start\n'


class Watches:
    """A call starts `satdyn watch` and returns its URL; pid: that of the last one."""

    def __init__(self):
        self.running: list[subprocess.Popen[str]] = []

    def __call__(self, *arguments):
        process = subprocess.Popen(
            [sys.executable, '-m', 'satdyn_ros.cli.main', 'watch', *arguments, '--port', '0'],
            cwd=ROOT,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self.running.append(process)
        assert process.stdout is not None
        # Before it, on stdout, Fast DDS says what it makes of ports that others hold.
        said = next(line for line in process.stdout if line.startswith('watch: '))
        return said.removeprefix('watch: ').strip()

    @property
    def pid(self):
        return self.running[-1].pid


@pytest.fixture(scope='module')
def watch():
    """Return what starts `satdyn watch`, and end it after the module."""
    watches = Watches()
    yield watches
    for number, process in enumerate(watches.running):
        # Both end it in good order.
        asked, code = ((signal.SIGINT, 0), (signal.SIGTERM, 143))[number % 2]
        process.send_signal(asked)
        said = process.communicate(timeout=60)[1].replace(COMPILING, '')
        assert said == ''
        assert process.returncode == code
