"""Signals wait for what they must not tear, and are not lost."""

import signal
import threading

import pytest

from satdyn_ros.cli.interruption import Terminated, interruptible
from satdyn_ros.uninterrupted import uninterrupted


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


def test_other_threads_leave_signals_alone():
    """Only the main thread may say what a signal does."""
    handlers = []

    def work():
        with uninterrupted():
            handlers.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert handlers == [signal.getsignal(signal.SIGINT)]
