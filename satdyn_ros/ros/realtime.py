"""What the pacing thread asks of the system and of Python to be on time: soft real time."""

import ctypes
import gc
import os
import time
from collections.abc import Callable
from threading import Lock

from ..run.scenario import Scenario

# From <sys/mman.h>: pages of today and those to come, each from when it is first used: to bring in
# all of the libraries at once would cost half a gigabyte.
_MCL_CURRENT, _MCL_FUTURE, _MCL_ONFAULT = 1, 2, 4
_PERIOD_NS = 10**9
_OVERDUE_NS = 10 * _PERIOD_NS


def lock_memory(scenario: Scenario, warn: Callable[[str], None]) -> None:
    """Keep the process in memory if realtime.lock_memory asks for it; warn where refused."""
    if not scenario['realtime.lock_memory']:
        return
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.mlockall(_MCL_CURRENT | _MCL_FUTURE | _MCL_ONFAULT) != 0:
        reason = os.strerror(ctypes.get_errno())
        warn(
            f'realtime.lock_memory is not in force ({reason}): grant CAP_IPC_LOCK, or memlock in '
            '/etc/security/limits.conf'
        )


def raise_priority(scenario: Scenario, warn: Callable[[str], None]) -> None:
    """Give the calling thread realtime.priority and realtime.cpu; warn where refused."""
    priority, cpu = scenario['realtime.priority'], scenario['realtime.cpu']
    if cpu >= 0:
        try:
            os.sched_setaffinity(0, {cpu})
        except OSError as error:
            allowed = ', '.join(map(str, sorted(os.sched_getaffinity(0))))
            warn(
                f'realtime.cpu {cpu} is not in force ({error.strerror}): the process may run on '
                f'{allowed}'
            )
    if priority > 0:
        try:
            # Threads that this one starts do not inherit it.
            policy = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
            os.sched_setscheduler(0, policy, os.sched_param(priority))
        except OSError as error:
            warn(
                f'realtime.priority {priority} is not in force ({error.strerror}): grant '
                'CAP_SYS_NICE, or rtprio in /etc/security/limits.conf'
            )


class GarbageCollection:
    """
    Garbage collection at chosen moments, once a second, where Python's own is disabled.

    It takes about as long as the last time.  Threads may share one.
    """

    def __init__(self) -> None:
        self._collecting = Lock()
        self._due_ns = 0
        self._cost_ns = 0

    def begin(self) -> None:
        """Exclude what exists by now from every scan."""
        if not gc.isenabled():
            gc.freeze()

    def collect_within(self, left_ns: float) -> bool:
        """Collect if it is due and fits twice into the time left; return whether it was done."""
        if left_ns < 2 * self._cost_ns or time.monotonic_ns() < self._due_ns or gc.isenabled():
            return False
        self._collect()
        return True

    def collect_at_last(self, has_deadlines: bool) -> None:
        """Collect after a block of ticks: without deadlines each time, else if long overdue."""
        is_overdue = time.monotonic_ns() > self._due_ns + _OVERDUE_NS
        if (is_overdue or not has_deadlines) and not gc.isenabled():
            self._collect()

    def _collect(self):
        if not self._collecting.acquire(blocking=False):
            return
        begin_ns = time.monotonic_ns()
        gc.collect()
        end_ns = time.monotonic_ns()
        self._cost_ns, self._due_ns = end_ns - begin_ns, end_ns + _PERIOD_NS
        self._collecting.release()


# Of all nodes of the process.
GARBAGE = GarbageCollection()
