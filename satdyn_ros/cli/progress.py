"""What takes its time says so: a progress bar, on a terminal alone, and a notice."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from ..compiled import NOTICE


def tell_of_compiling(is_compiled: bool) -> None:
    """Say why the first use takes seconds, unless the compiled code is there."""
    if not is_compiled:
        print(NOTICE, file=sys.stderr)


@contextmanager
def progress(what: str, unit: str) -> Iterator[Callable[[int, int], None]]:
    """Show a bar while the context lasts; yield show(done, total), both in units."""
    if not sys.stderr.isatty():
        yield lambda done, total: None
        return
    # Half a second of imports that a pipe does not pay.
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
