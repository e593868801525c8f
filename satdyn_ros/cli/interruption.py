"""Ctrl-C and SIGTERM end a command at once, and both let it clean up."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


class Terminated(KeyboardInterrupt):
    """SIGTERM, which ends a command as Ctrl-C does."""


@contextmanager
def interruptible() -> Iterator[None]:
    """Let SIGINT raise KeyboardInterrupt and SIGTERM Terminated."""
    # Only the main thread may say what a signal does, and only there does it act.
    numbers = (signal.SIGINT, signal.SIGTERM)
    is_main = threading.current_thread() is threading.main_thread()
    before = [signal.signal(number, _interrupt) for number in numbers] if is_main else []
    try:
        yield
    except SystemError as error:
        # What becomes of an interruption while numba makes Python objects of a result.
        cause: BaseException | None = error
        while isinstance(cause, SystemError):
            cause = cause.__cause__
        if isinstance(cause, KeyboardInterrupt):
            raise cause from None
        raise
    finally:
        for number, handler in zip(numbers, before, strict=False):
            signal.signal(number, handler)


def _interrupt(number: int, frame: Any) -> None:
    raise KeyboardInterrupt if number == signal.SIGINT else Terminated
