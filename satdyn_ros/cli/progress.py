"""Long work says so: a progress bar, only on a terminal, and a notice."""

import logging
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager


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
