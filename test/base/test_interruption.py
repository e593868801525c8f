"""Signals wait for what they must not tear, and are not lost."""

import ctypes
import signal
import sys
import threading
import time
from contextlib import suppress

import pytest

from satdyn_ros.base import interruption
from satdyn_ros.base.interruption import Terminated, interruptible, uninterrupted


@pytest.mark.parametrize(
    ('number', 'raised'), [(signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, Terminated)]
)
def test_a_signal_waits_for_the_end_and_acts_there(number, raised):
    """Of a context within another, for that of the outer one."""
    done = []
    with interruptible():
        with pytest.raises(raised), uninterrupted():  # noqa: PT012
            with uninterrupted():
                signal.raise_signal(number)
                done.append('inner')
            done.append('outer')
        with pytest.raises(raised):
            signal.raise_signal(number)
    assert done == ['inner', 'outer']


def test_a_signal_acts_after_an_error():
    """Both are raised: the interruption, and the error as what it was raised in."""
    with interruptible(), pytest.raises(Terminated) as caught, uninterrupted():  # noqa: PT012
        signal.raise_signal(signal.SIGTERM)
        raise ValueError('wrong')
    assert isinstance(caught.value.__context__, ValueError)


@pytest.mark.parametrize(
    ('number', 'raised'), [(signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, Terminated)]
)
def test_what_a_callback_has_lost_comes_again(capfd, number, raised):
    """Without a word of the first time, which C ignores."""
    callback = ctypes.CFUNCTYPE(None)(lambda: signal.raise_signal(number))
    with interruptible() as heard, pytest.raises(raised):  # noqa: PT012
        callback()
        assert heard == [number]
        while True:
            time.sleep(0.01)
    assert capfd.readouterr().err == ''


def test_what_a_callback_has_lost_does_not_come_after_the_end(monkeypatch):
    """Who hears the signal then has not been interrupted."""
    monkeypatch.setattr(interruption, '_AGAIN_S', 0.1)
    callback = ctypes.CFUNCTYPE(None)(lambda: signal.raise_signal(signal.SIGINT))
    later: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, frame: later.append(number))
    try:
        with interruptible():
            callback()
        for thread in threading.enumerate():
            if isinstance(thread, threading.Timer):
                thread.join()
    finally:
        signal.signal(signal.SIGINT, before)
    assert later == []


@pytest.mark.parametrize(
    ('number', 'raised'), [(signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, Terminated)]
)
def test_what_c_code_makes_an_import_error_is_an_interruption(number, raised):
    """As PyCapsule_Import does while numpy is imported; any other ImportError stays one."""

    def load():
        try:
            signal.raise_signal(number)
        except KeyboardInterrupt:
            raise ImportError('PyCapsule_Import could not import module "datetime"') from None

    with pytest.raises(raised), interruptible():
        load()
    with pytest.raises(ImportError, match='no such'), interruptible():
        raise ImportError('no such module')


def test_what_was_half_built_is_freed_without_a_word(monkeypatch):
    """Such as an object of the compiler's whose handle was still to come."""
    unraisable: list[object] = []
    monkeypatch.setattr(sys, 'unraisablehook', unraisable.append)

    class Half:
        def __init__(self):
            signal.raise_signal(signal.SIGINT)
            self.handle = 1

        def __del__(self):
            del self.handle

    with suppress(KeyboardInterrupt), interruptible():
        Half()
    assert not unraisable


def test_a_context_in_another_thread_does_not_hold_the_main_one():
    """Signals act in the main thread alone, and only what it does can be torn."""
    inside, ended = threading.Event(), threading.Event()

    def work():
        with uninterrupted():
            inside.set()
            ended.wait()

    thread = threading.Thread(target=work)
    thread.start()
    inside.wait()
    with pytest.raises(Terminated), interruptible():
        signal.raise_signal(signal.SIGTERM)
    ended.set()
    thread.join()


def test_a_context_in_another_thread_changes_nothing():
    """Not the hook for lost exceptions either, which two threads could restore in disorder."""
    hooks = []

    def work():
        with interruptible():
            hooks.append(sys.unraisablehook)

    before = sys.unraisablehook
    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert hooks == [before]


def test_the_handlers_of_others_stay():
    """Such as those of rclpy, which Python cannot put back."""
    before = signal.getsignal(signal.SIGINT)
    with uninterrupted():
        assert signal.getsignal(signal.SIGINT) is before
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)


def test_what_a_callback_loses_is_in_the_list():
    """As in a callback of the compiler, whose exceptions are dropped."""
    with interruptible() as heard, suppress(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)
    assert heard == [signal.SIGINT]
