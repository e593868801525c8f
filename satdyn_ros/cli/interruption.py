"""Ctrl-C and SIGTERM: they end a command at once, but never tear what is being written."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


class Terminated(KeyboardInterrupt):
    """SIGTERM, which ends a command as Ctrl-C does."""


class Shelter:
    """A context in which an interruption waits until its end; it may be entered many times."""

    def __init__(self) -> None:
        self._is_inside = False
        self._waiting: int | None = None

    def __enter__(self) -> None:
        self._is_inside = True

    def __exit__(self, *raised: object) -> None:
        self._is_inside = False
        if self._waiting is not None:
            self._waiting, number = None, self._waiting
            _interrupt(number)

    def hear(self, number: int, frame: Any) -> None:
        """Handle a signal."""
        if self._is_inside:
            self._waiting = number
        else:
            _interrupt(number)


@contextmanager
def interruptible() -> Iterator[Shelter]:
    """Let SIGINT raise KeyboardInterrupt and SIGTERM Terminated, but not inside the shelter."""
    shelter = Shelter()
    # Only the main thread may say what a signal does, and only there does it act.
    numbers = (signal.SIGINT, signal.SIGTERM)
    is_main = threading.current_thread() is threading.main_thread()
    before = [signal.signal(number, shelter.hear) for number in numbers] if is_main else []
    try:
        yield shelter
    finally:
        for number, handler in zip(numbers, before, strict=False):
            signal.signal(number, handler)


def _interrupt(number):
    raise KeyboardInterrupt if number == signal.SIGINT else Terminated
