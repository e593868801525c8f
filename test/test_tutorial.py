"""Each command of the tutorial, run in its order as a reader runs it."""

import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
TUTORIAL = ROOT / 'docs' / 'tutorial.md'
# Where the commands write; here it is a folder of the test's own.
DIRECTORY = '/tmp/satdyn_tutorial'
BLOCK = re.compile(r'```(sh background|sh|python)\n(.*?)```', re.S)
COMMANDS = [
    (kind, line)
    for kind, text in BLOCK.findall(TUTORIAL.read_text())
    for line in ([text] if kind == 'python' else text.strip().splitlines())
    if not line.startswith('. ')
]


@pytest.mark.skipif(shutil.which('bash') is None, reason='the commands are for a shell')
def test_every_command_of_the_tutorial(tmp_path):
    """Every command ends with exit code 0, the node when it is told to, in their order."""
    pytest.importorskip('rclpy')
    bin_directory = Path(sys.executable).parent
    environment = os.environ | {
        'PATH': f'{bin_directory}:{os.environ["PATH"]}',
        'PYTHONPATH': str(ROOT),
    }
    background = []
    try:
        for kind, told in COMMANDS:
            command = told.replace(DIRECTORY, str(tmp_path))
            if kind == 'python':
                arguments: list[str] = [sys.executable, '-c', command]
            else:
                arguments = ['bash', '-c', f'exec {command}']
            if kind == 'sh background':
                background.append(subprocess.Popen(arguments, cwd=ROOT, env=environment))
                continue
            done = subprocess.run(
                arguments,
                cwd=ROOT,
                env=environment,
                timeout=150,
                capture_output=True,
                text=True,
                check=False,
            )
            assert done.returncode == 0, f'{command}\n{done.stdout}\n{done.stderr}'
            assert all(process.poll() is None for process in background)
        for process in background:
            process.send_signal(signal.SIGINT)
            assert process.wait(20) == 0
    finally:
        for process in background:
            process.kill()
            process.wait()
