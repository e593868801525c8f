"""
Run what README, docs and CONTRIBUTING tell a reader to run, as it stands.

    make pages
    python scripts/run_pages.py docs/sensors.md

Without pages: all of them, README first, in a clone of the last commit, where nothing is installed
but by what the pages themselves say.  With pages: those, here, with the installation that is here.

How a fenced block is run is said behind its opening fence:

    sh               its commands, in their order; each has to succeed
    sh background    each line in a terminal of its own, ended by Ctrl-C at the end of the page
    sh ros2          where there is an installation of ROS 2, otherwise it is listed at the end
    sh long          not here, since it takes too long; it is listed at the end
    python           as a program; with a file name behind it, the file is written, to be run later
    yaml NAME        the file is written
    text             not run: the output of the block before it, line by line; ... is anything

What a block changes in its shell, such as the PATH, is so for the following ones.  A target of
make that .ci/run makes by itself is not made twice.

The pages between the tutorial and CONTRIBUTING are read by two readers side by side, who do not
hear each other's nodes: most of the time a page waits for a node that flies.
"""

import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field, replace
from io import StringIO
from pathlib import Path
from typing import TextIO

ROOT = Path(__file__).parents[1]
# Those that build on others' installation and bags come later.
ORDER = ('README.md', 'docs/tutorial.md', 'docs', 'CONTRIBUTING.md')
# ROS domains of the readers side by side; the tests have those up to 100.
DOMAINS = '101', '215'
FENCE = re.compile(r'^```(\w+)(?: ([^\n]*))?\n(.*?)^```$', re.MULTILINE | re.DOTALL)
FILE = re.compile(r'[\w-]+\.\w+')
# What ends a program by Ctrl-C may say so.
ENDED = (0, 128 + signal.SIGINT, -signal.SIGINT)
BLOCK_TIMEOUT_S, OUTPUT_TIMEOUT_S, SILENCE_S, END_TIMEOUT_S = 900.0, 600.0, 10.0, 60.0
# A reader's shell has these; what else is set here would be a help that the reader does not have.
KEPT = ('HOME', 'LANG', 'LC_ALL', 'PATH', 'TERM', 'TMPDIR', 'USER')


@dataclass(frozen=True)
class Block:
    """A fenced block: its language, the words behind it, its text, and its stated output."""

    location: str
    language: str
    words: list[str]
    text: str
    output: str

    @property
    def lines(self) -> list[str]:
        """Return the commands, one a line; a line that ends with a backslash goes on."""
        joined = self.text.replace('\\\n', '')
        return [line for line in joined.splitlines() if line.strip() and line[0] != '#']


def pages(root: Path) -> list[Path]:
    """Return the pages in the order in which they are run."""
    found = []
    for name in ORDER:
        path = root / name
        for page in sorted(path.rglob('*.md')) if path.is_dir() else [path]:
            # The pages of the API are written by Sphinx.
            if page not in found and 'api' not in page.parts:
                found.append(page)
    return found


def blocks(page: Path, root: Path) -> list[Block]:
    """Return the blocks of a page that are to be run or written, in their order."""
    text = page.read_text(encoding='utf-8')
    found: list[Block] = []
    for fence in FENCE.finditer(text):
        language, words, content = fence[1], (fence[2] or '').split(), fence[3]
        if language == 'text':
            if found and not found[-1].output:
                found[-1] = replace(found[-1], output=content)
            continue
        line = text.count('\n', 0, fence.start()) + 1
        found.append(Block(f'{page.relative_to(root)}:{line}', language, words, content, ''))
    return found


def differs(stated: str, printed: str) -> str | None:
    """Return the first line of a stated output that was not printed, None where all were."""
    rest = printed
    for line in stated.splitlines():
        pattern = '.*'.join(map(re.escape, line.split('...')))
        found = re.search(rf'^{pattern}$', rest, re.MULTILINE)
        if not found:
            return line
        rest = rest[found.end() :]
    return None


class Failed(Exception):  # noqa: N818 - it says what a block did
    """A block did not do what its page says; the text is one sentence."""


@dataclass
class Reader:
    """Somebody who types what the pages say: a folder, the variables of the shell, terminals."""

    folder: Path
    environment: dict[str, str]
    made: frozenset[str]
    # None: the standard output.
    out: TextIO | None = None
    commands: int = 0
    programs: int = 0
    outputs: int = 0
    left_out: list[str] = field(default_factory=list)
    terminals: list[tuple[Block, str, subprocess.Popen, Path]] = field(default_factory=list)

    def read(self, page: Path) -> None:
        """Run a page; raise Failed where it does not do what it says."""
        try:
            for block in blocks(page, self.folder):
                self._do(block)
            for terminal in self.terminals:
                self._end(*terminal)
        except Failed:
            for _, line, _, log in self.terminals:
                self._say(f'\n# in another terminal\n$ {line}\n{log.read_text()}')
            raise
        finally:
            for *_, process, log in self.terminals:
                process.kill()
                process.wait()
                log.unlink(missing_ok=True)
            self.terminals.clear()

    def _say(self, text, end='\n'):
        print(text, end=end, file=self.out, flush=True)

    def _do(self, block):
        match block.language, block.words:
            case (('python' | 'yaml'), [name]) if FILE.fullmatch(name):
                (self.folder / name).write_text(block.text, encoding='utf-8')
                self._say(f'\n# {block.location}: {name} is written')
            case 'python', []:
                self.programs += 1
                self._run(block, f"python - <<'END_OF_PROGRAM'\n{block.text}END_OF_PROGRAM\n")
            case 'sh', ['long']:
                self._leave_out(block)
            case 'sh', ['ros2', *_] if not shutil.which('ros2'):
                self._leave_out(block)
            case 'sh', ['background'] | ['ros2', 'background']:
                for line in block.lines:
                    self._begin(block, line)
            case 'sh', [] | ['ros2']:
                self._run_lines(block)
            case 'python' | 'sh', words:
                raise Failed(f'{block.location}: a block of {block.language} cannot be {words}')

    def _leave_out(self, block):
        self.left_out += [f'{block.location}: {line}' for line in block.lines]

    def _run_lines(self, block):
        lines = [line for line in block.lines if line.split('#')[0].strip() not in self.made]
        self.commands += len(lines)
        if lines:
            self._run(block, '\n'.join(lines) + '\n')

    def _run(self, block, script):
        self._say(f'\n# {block.location}')
        self._say(''.join(f'$ {line}\n' for line in script.splitlines()), end='')
        with tempfile.NamedTemporaryFile() as after:
            try:
                done = subprocess.run(
                    ['bash', '-euo', 'pipefail', '-c', f'{script}env -0 > {after.name}'],
                    cwd=self.folder,
                    env=self.environment,
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.PIPE,
                    stderr=subprocess.STDOUT,
                    text=True,
                    timeout=BLOCK_TIMEOUT_S,
                    check=False,
                )
            except subprocess.TimeoutExpired:
                raise Failed(f'{block.location}: not done in {BLOCK_TIMEOUT_S:g} s') from None
            self._say(done.stdout, end='')
            if done.returncode:
                raise Failed(f'{block.location}: exit code {done.returncode}')
            entries = Path(after.name).read_text().split('\0')
            self.environment = dict(entry.split('=', 1) for entry in entries if '=' in entry)
        self._compare(block, done.stdout)

    def _begin(self, block, line):
        self.commands += 1
        self._say(f'\n# {block.location}, in another terminal\n$ {line}')
        log = Path(tempfile.mkstemp(suffix='.log')[1])
        with log.open('wb') as file:
            process = subprocess.Popen(
                ['bash', '-c', f'exec {line}'],
                cwd=self.folder,
                env=self.environment,
                stdin=subprocess.DEVNULL,
                stdout=file,
                stderr=subprocess.STDOUT,
            )
        self.terminals.append((block, line, process, log))
        # Who types in another terminal sees first that something happens in this one.
        end_s = time.monotonic() + (OUTPUT_TIMEOUT_S if block.output else SILENCE_S)
        while process.poll() is None and time.monotonic() < end_s:
            printed = log.read_text()
            if printed and differs(block.output, printed) is None:
                break
            time.sleep(0.2)
        self._compare(block, log.read_text())

    def _compare(self, block, printed):
        if block.output:
            self.outputs += 1
            if (line := differs(block.output, printed)) is not None:
                raise Failed(f'{block.location}: not printed: {line}')

    def _end(self, block, line, process, log):
        # Seen once in hundreds of times: a program in rclpy.spin that the first does not end.
        for _ in range(2):
            process.send_signal(signal.SIGINT)
            with suppress(subprocess.TimeoutExpired):
                code = process.wait(END_TIMEOUT_S)
                break
            self._say(f'{block.location}: Ctrl-C has not ended {line}')
        else:
            raise Failed(f'{block.location}: Ctrl-C does not end {line}')
        self._say(f'\n# {block.location}, in the other terminal\n$ {line}\n{log.read_text()}')
        # One that has ended before is done, or has failed.
        if code not in ENDED:
            raise Failed(f'{block.location}: exit code {code} of {line}')


def read_all(reader: Reader, *queues: list[Path]) -> dict[str, float]:
    """Read pages as long as any wait, and print each as a whole; return what each took [s]."""
    took = {}
    for waiting in queues:
        while waiting:
            page, begin_s = waiting.pop(0), time.monotonic()
            reader.out = out = StringIO()
            try:
                reader.read(page)
            except Failed:
                for each in queues:
                    each.clear()
                raise
            finally:
                print(out.getvalue(), end='', flush=True)
            took[str(page.relative_to(reader.folder))] = time.monotonic() - begin_s
    return took


def main() -> int:
    """Run the pages that are named, or all; return the exit code."""
    environment = {name: os.environ[name] for name in KEPT if name in os.environ}
    # No other nodes are heard, and none hear these.
    environment |= {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST', 'ROS_DOMAIN_ID': DOMAINS[0]}
    environment |= {'PIP_QUIET': '2', 'PIP_DISABLE_PIP_VERSION_CHECK': '1'}
    environment |= {'PYTHONUNBUFFERED': '1'}
    made = frozenset(filter(None, (ROOT / '.ci/run').read_text().splitlines()))
    with tempfile.TemporaryDirectory() as temporary:
        folder, chosen = ROOT, [Path(name).resolve() for name in sys.argv[1:]]
        beside: list[Path] = []
        first, last, count = chosen, list[Path](), len(chosen)
        if not chosen:
            folder = Path(temporary, 'satdyn_ros')
            subprocess.run(['git', 'clone', '--quiet', ROOT, folder], check=True)
            chosen = pages(folder)
            first, beside, last, count = chosen[:2], chosen[2:-1], chosen[-1:], len(chosen)
        # Those that open the port of the live page come one after the other.
        watching = [page for page in beside if 'satdyn watch' in page.read_text(encoding='utf-8')]
        others = [page for page in beside if page not in watching]
        readers = [Reader(folder, environment, made)]
        try:
            took = read_all(readers[0], first)
            # What these have installed is there for all.
            environment = readers[0].environment
            two = [
                Reader(folder, environment | {'ROS_DOMAIN_ID': domain}, made) for domain in DOMAINS
            ]
            with ThreadPoolExecutor() as pool:
                found = [
                    pool.submit(read_all, two[0], watching, others),
                    pool.submit(read_all, two[1], others),
                ]
            for each in found:
                took |= each.result()
            took |= read_all(readers[0], last)
            readers += two
        except Failed as failure:
            print(f'\n{failure}', file=sys.stderr)
            return 1
    commands, programs, outputs = (
        sum(getattr(reader, name) for reader in readers)
        for name in ('commands', 'programs', 'outputs')
    )
    print(
        f'\n{count} pages, {commands} commands, {programs} programs, {outputs} outputs: '
        'all as the pages say'
    )
    for page, page_s in sorted(took.items(), key=lambda item: -item[1]):
        print(f'{page_s:6.0f} s  {page}')
    if left_out := [line for reader in readers for line in reader.left_out]:
        print('not run here:', *left_out, sep='\n  ')
    return 0


if __name__ == '__main__':
    sys.exit(main())
