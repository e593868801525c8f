"""
What a command prints: output that may fail, notices, and a progress bar on a terminal.

Where the output fails, the work continues and the end says so.
"""

import logging
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout, suppress
from typing import Any, TextIO


class _Output:
    """A text stream that keeps its first problem instead of raising it."""

    def __init__(self, stream: TextIO):
        self._stream = stream
        self.problem: OSError | None = None

    def write(self, text: str) -> int:
        if self.problem is None:
            try:
                self._stream.write(text)
            except OSError as error:
                self.problem = error
        return len(text)

    def flush(self) -> None:
        if self.problem is None:
            try:
                self._stream.flush()
            except OSError as error:
                self.problem = error

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


@contextmanager
def output_that_may_fail(command: str) -> Iterator[None]:
    """Let a command print, and say on stderr when what it printed is lost."""
    stream = sys.stdout
    if stream is None:  # closed by the parent process
        yield
        return
    output = _Output(stream)
    try:
        with redirect_stdout(output):
            yield
    finally:
        output.flush()
        if output.problem is not None:
            print(
                f'satdyn {command}: the command completed, but its output could not be written: '
                f'{output.problem.strerror}',
                file=sys.stderr,
            )
            # What is still buffered would fail once more when Python ends.
            with suppress(OSError, ValueError):
                os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


class _ToStderr(logging.Handler):
    def emit(self, record):
        print(record.getMessage(), file=sys.stderr)


def show_notices() -> None:
    """Show on stderr what the package logs, such as that it compiles."""
    log = logging.getLogger('satdyn_ros')
    log.setLevel(logging.INFO)
    log.handlers = [_ToStderr()]


@contextmanager
def progress(what: str, unit: str) -> Iterator[Callable[[int, int | None], None]]:
    """Show a bar while the context lasts; yield show(done, total), both in units."""
    if not sys.stderr.isatty():
        yield lambda done, total: None
        return
    # Half a second of imports, which output to a pipe does not need.
    from rich.console import Console
    from rich.progress import BarColumn, Progress, ProgressColumn, TextColumn, TimeRemainingColumn
    from rich.text import Text

    class Rate(ProgressColumn):
        def render(self, task):
            speed = task.speed or 0.0
            return Text(f'{speed:,.{0 if speed >= 10.0 else 1}f} {unit}/s')

    columns = TextColumn('{task.description}'), BarColumn(), Rate(), TimeRemainingColumn()
    with Progress(*columns, console=Console(stderr=True)) as bar:
        task = bar.add_task(what, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)
