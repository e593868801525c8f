"""
Build what a release uploads, and try it as somebody who installs it would.

    make release

dist/ gets the source distribution of the last commit, which holds the files that git knows, and
the wheel that is built from it.  The wheel is installed into a fresh environment.  Its commands
then run in another folder and with an empty process environment, but for a ROS domain of its own,
so that nothing of the checkout and of the shell can help them.
"""

import os
import re
import shutil
import signal
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.request import urlopen

ROOT = Path(__file__).parents[1]
DIST = ROOT / 'dist'
# What setuptools adds to the files of the commit.
ADDED = re.compile(r'PKG-INFO|satdyn_ros\.egg-info/.*')
# The one exception to the empty environment: no other nodes are heard, and none hear these.
APART = {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST', 'ROS_DOMAIN_ID': '216'}
COMMAND_TIMEOUT_S, END_TIMEOUT_S = 600.0, 60.0


def build(clone: Path) -> tuple[Path, Path]:
    """Build the source distribution and, from it, the wheel; return their paths."""
    subprocess.run(['git', 'clone', '--quiet', ROOT, clone], check=True)
    shutil.rmtree(DIST, ignore_errors=True)
    done = subprocess.run(
        [sys.executable, '-m', 'build', '--outdir', DIST, clone],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    if done.returncode:
        sys.exit(f'{done.stdout}\nthe build fails')
    [source], [wheel] = DIST.glob('*.tar.gz'), DIST.glob('*.whl')
    return source, wheel


def compare(source: Path, clone: Path) -> int:
    """Return the number of files of the commit; exit where the source distribution has others."""
    with tarfile.open(source) as archive:
        packed = {info.name.partition('/')[2] for info in archive if info.isfile()}
    packed = {name for name in packed if not ADDED.fullmatch(name)}
    listed = subprocess.run(
        ['git', 'ls-files', '-z'], cwd=clone, stdout=subprocess.PIPE, text=True, check=True
    )
    known = {name for name in listed.stdout.split('\0') if name}
    if packed != known:
        sys.exit(
            f'{source.name} lacks {sorted(known - packed)} and has beside the files of the '
            f'commit {sorted(packed - known)}; see MANIFEST.in'
        )
    return len(known)


def install(wheel: Path, folder: Path) -> Path:
    """Install the wheel with all its extras; return the folder of its commands."""
    subprocess.run([sys.executable, '-m', 'venv', folder], check=True)
    # How pip reaches its index is the machine's own matter: it keeps the shell's environment.
    pip = [str(folder / 'bin/python'), '-I', '-m', 'pip', '--quiet', '--quiet']
    subprocess.run([*pip, 'install', f'{wheel}[all]'], cwd=folder, check=True)
    subprocess.run([*pip, 'check'], cwd=folder, check=True)
    return folder / 'bin'


class Stranger:
    """Somebody who has the commands and a folder, and nothing else."""

    def __init__(self, commands: Path, folder: Path):
        self._commands, self._folder = commands, folder

    def run(self, *line: str) -> None:
        """Run a command to its end."""
        self._type(line)
        done = subprocess.run(
            [self._commands / line[0], *line[1:]],
            cwd=self._folder,
            env=APART,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=COMMAND_TIMEOUT_S,
            check=False,
        )
        self._judge(line, done.returncode, done.stdout)

    @contextmanager
    def running(self, *line: str) -> Iterator[str]:
        """Start a command; give the first line that it prints, and end it by Ctrl-C."""
        self._type(line)
        with subprocess.Popen(
            [self._commands / line[0], *line[1:]],
            cwd=self._folder,
            env=APART,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        ) as process:
            assert process.stdout
            first = process.stdout.readline()
            try:
                yield first
                process.send_signal(signal.SIGINT)
                rest, _ = process.communicate(timeout=END_TIMEOUT_S)
            finally:
                process.kill()
        self._judge(line, process.returncode, first + rest)

    def _type(self, line):
        print('$', *line, flush=True)

    def _judge(self, line, code, printed):
        print(printed, end='', flush=True)
        if code or 'Traceback' in printed:
            sys.exit(f'exit code {code} of {" ".join(line)}')


def try_out(stranger: Stranger) -> None:
    """Fly without ROS; then start a node, ask it, and look at it."""
    stranger.run('satdyn', 'simulate', 'default', '--duration', '10 min', '-o', 'orbit')
    stranger.run('satdyn', 'verify', 'orbit')
    stranger.run('satdyn', 'report', 'orbit', '-o', 'orbit.html')
    with (
        stranger.running('satdyn', 'node', '--params-file', 'default'),
        stranger.running('satdyn', 'watch', '--port', '0') as printed,
    ):
        stranger.run(
            'satdyn', 'request', '--timeout', '60', 'initial.angular_velocity=[0,0,0.002]'
        )
        url = printed.split()[-1]
        with urlopen(url, timeout=COMMAND_TIMEOUT_S) as answer:
            print(f'{url} answers with {len(answer.read())} bytes')


def main() -> None:
    """Build, check and try; exit in a sentence where something fails."""
    os.environ.pop('PYTHONPATH', None)
    with tempfile.TemporaryDirectory() as name:
        clone, folder = Path(name, 'clone'), Path(name, 'elsewhere')
        source, wheel = build(clone)
        count = compare(source, clone)
        print(f'{source.name}: the {count} files of the last commit', flush=True)
        twine = [sys.executable, '-m', 'twine', '--no-color']
        subprocess.run([*twine, 'check', '--strict', str(source), str(wheel)], check=True)
        print('Installing the wheel with all extras (a minute)', flush=True)
        commands = install(wheel, Path(name, 'installed'))
        folder.mkdir()
        try_out(Stranger(commands, folder))
    print(f'dist/{source.name}, dist/{wheel.name}: built, checked, installed and tried')


if __name__ == '__main__':
    main()
