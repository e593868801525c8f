"""Ctrl-C and SIGTERM: they end a command at once, but never tear what must be whole."""

import os
import signal
import sys
import threading
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

_NUMBERS = (signal.SIGINT, signal.SIGTERM)
# An interruption that was lost comes again after this time.
_AGAIN_S = 0.01

# How many contexts the main thread is in that wait for their end, and the signals that wait.
_depth = 0
_waiting: list[int] = []


class Terminated(KeyboardInterrupt):
    """SIGTERM, which ends a command as Ctrl-C does."""


@contextmanager
def interruptible() -> Iterator[list[int]]:
    """
    Let SIGINT raise KeyboardInterrupt and SIGTERM Terminated; yield the list of those that came.

    The exception comes again where a callback, such as that of numba's compiler, has lost it.
    """
    heard: list[int] = []
    # Only the main thread may say what a signal does, and only there does it act.
    if not _is_main():
        yield heard
        return

    def hear(number: int, frame: Any) -> None:
        heard.append(number)
        if _depth:
            _waiting.append(number)
        else:
            _interrupt(number)

    def come_again(number: int) -> None:
        if signal.getsignal(number) is hear:
            os.kill(os.getpid(), number)

    def hear_lost(lost: Any) -> None:
        if issubclass(lost.exc_type, KeyboardInterrupt):
            number = signal.SIGTERM if issubclass(lost.exc_type, Terminated) else signal.SIGINT
            threading.Timer(_AGAIN_S, come_again, [number]).start()
        elif not heard:
            hook_before(lost)

    before = [signal.signal(number, hear) for number in _NUMBERS]
    hook_before, sys.unraisablehook = sys.unraisablehook, hear_lost
    try:
        yield heard
    except KeyboardInterrupt as error:
        # Objects that it left half built may complain when they are freed: here, where none hears.
        traceback.clear_frames(error.__traceback__)
        raise
    except SystemError as error:
        # What becomes of an interruption while numba makes Python objects of a result.
        cause: BaseException | None = error
        while isinstance(cause, SystemError):
            cause = cause.__cause__
        if isinstance(cause, KeyboardInterrupt):
            raise cause from None
        raise
    except ImportError:
        # What becomes of an interruption while the C code of numpy imports a module.
        if heard:
            _interrupt(heard[-1])
        raise
    finally:
        sys.unraisablehook = hook_before
        for number, handler in zip(_NUMBERS, before, strict=True):
            signal.signal(number, handler)


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Let the signals of an interruptible context wait until the end; other ones do as ever."""
    global _depth
    if not _is_main():
        yield
        return
    _depth += 1
    try:
        yield
    finally:
        _depth -= 1
        if _waiting and not _depth:
            number = _waiting[0]
            _waiting.clear()
            _interrupt(number)


def _is_main():
    return threading.current_thread() is threading.main_thread()


def _interrupt(number):
    raise KeyboardInterrupt if number == signal.SIGINT else Terminated
