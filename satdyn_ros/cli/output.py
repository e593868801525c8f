"""The standard output of a command; if it fails, the work continues and the end says so."""

import os
import sys
from collections.abc import Iterator
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
