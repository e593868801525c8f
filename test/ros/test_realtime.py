"""What the node requests of the system, tested in separate processes."""

import gc
import os
import re
import subprocess
import sys
import time
from types import SimpleNamespace

import pytest
from ros.live import ROOT

from satdyn_ros.ros.pacing import Pacing
from satdyn_ros.ros.realtime import GarbageCollection
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import Simulation

ASK = """
import os, resource, threading
from satdyn_ros.ros import realtime
from satdyn_ros.run.scenario import Scenario
{before}
scenario = Scenario({values})
def ask():
    realtime.raise_priority(scenario, print)
    policy = os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK
    print(policy == os.SCHED_FIFO, os.sched_getparam(0).sched_priority, os.sched_getaffinity(0))
realtime.lock_memory(scenario, print)
thread = threading.Thread(target=ask)
thread.start()
thread.join()
print(os.sched_getscheduler(0) == os.SCHED_OTHER, len(os.sched_getaffinity(0)))
print(int(open('/proc/self/status').read().split('VmLck:')[1].split()[0]) > 0)
"""
# An ordinary user, who has no rights and may lock no page.
NOBODY = """
resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))
resource.setrlimit(resource.RLIMIT_MEMLOCK, (0, 0))
if os.getuid() == 0:
    os.setgroups([])
    os.setgid(65534)
    os.setuid(65534)
"""
CPU = max(os.sched_getaffinity(0))
WANTED = {'realtime.priority': 10, 'realtime.cpu': CPU, 'realtime.lock_memory': True}


def asked(values, before=''):
    program = ASK.format(before=before, values=values)
    result = subprocess.run(
        [sys.executable, '-c', program], cwd=ROOT, capture_output=True, text=True
    )
    assert result.returncode == 0, result.stderr
    return result.stdout.splitlines()


def test_what_the_system_allows_is_in_force():
    """The pacing thread alone gets priority and processor; all memory is locked."""
    *warnings, thread, process, locked = asked(WANTED)
    if warnings:
        pytest.skip(f'the system allows no real time: {warnings[0]}')
    assert thread == f'True 10 {{{CPU}}}'
    assert process == f'True {len(os.sched_getaffinity(0))}'
    assert locked == 'True'


@pytest.mark.long
def test_what_the_system_refuses_is_reported_with_the_remedy():
    """One sentence each; everything goes on as without."""
    absent = {**WANTED, 'realtime.cpu': 4095}
    memory, cpu, priority, thread, process, locked = asked(absent, NOBODY)
    everywhere = os.sched_getaffinity(0)
    assert re.fullmatch(
        r'realtime.lock_memory is not in force \(.+\): grant CAP_IPC_LOCK.*', memory
    )
    assert re.fullmatch(r'realtime.cpu 4095 is not in force \(.+\): the process may .*', cpu)
    assert re.fullmatch(
        r'realtime.priority 10 is not in force \(.+\): grant CAP_SYS_N.*', priority
    )
    assert thread == f'False 0 {everywhere}'
    assert (process, locked) == (f'True {len(everywhere)}', 'False')


def test_without_a_wish_nothing_changes():
    """The defaults."""
    everywhere = os.sched_getaffinity(0)
    assert asked({}) == [f'False 0 {everywhere}', f'True {len(everywhere)}', 'False']


@pytest.fixture
def collections(monkeypatch):
    """Return the list of collections that happen, with Python's own switched off."""
    happened = []

    def callback(phase, info):
        if phase == 'start':
            happened.append(info)

    gc.collect()
    gc.disable()
    gc.callbacks.append(callback)
    yield happened
    gc.callbacks.remove(callback)
    gc.unfreeze()
    gc.enable()


@pytest.mark.long
def test_garbage_is_collected_where_the_time_allows(collections):
    """When it is due and fits; then not again for a second."""
    garbage = GarbageCollection()
    assert garbage.collect_within(10**9)
    assert not garbage.collect_within(10**9)
    assert len(collections) == 1
    garbage._due_ns = 0
    assert not garbage.collect_within(garbage._cost_ns)
    assert garbage.collect_within(10**12)
    assert len(collections) == 2


@pytest.mark.long
def test_garbage_is_collected_at_last(collections):
    """Without deadlines after each block; with them when no tick left the time for too long."""
    garbage = GarbageCollection()
    garbage.collect_at_last(has_deadlines=False)
    garbage.collect_at_last(has_deadlines=False)
    assert len(collections) == 2
    garbage.collect_at_last(has_deadlines=True)
    assert len(collections) == 2
    garbage._due_ns = 1
    garbage.collect_at_last(has_deadlines=True)
    assert len(collections) == 3


def test_pythons_own_collection_is_left_alone():
    """Where it is enabled, as in a program that has nodes among other things, none is added."""
    assert gc.isenabled()
    assert not GarbageCollection().collect_within(10**12)


def test_what_was_there_before_the_ticks_is_never_scanned(collections):
    """However soon they begin: to scan the modules of a node takes longer than many ticks."""
    silent = SimpleNamespace(publish=lambda row: None, published=lambda *_: None)
    silent.prepare = lambda applied, samples: silent
    pacing = Pacing(Simulation(Scenario({'publish.rate': 50.0})), silent, 0.0, print)
    pacing.start()
    pacing.stop()
    assert not any(each is pacing for each in gc.get_objects())


def test_no_garbage_is_collected_inside_a_tick(collections):
    """A listener that leaves cycles behind, thousands a tick: all are collected in between."""
    inside = []

    class Listener:
        def __init__(self):
            self.busy = False

        def prepare(self, samples):
            return self

        def publish(self, row):
            self.busy = True
            for _ in range(2000):
                cycle: list = []
                cycle.append(cycle)
            self.busy = False

        def published(self, happened, samples, messages, count):
            inside.extend([self.busy] * len(collections))

    listener = Listener()
    gc.callbacks.append(lambda phase, info: inside.append(listener.busy))
    try:
        for factor in (1.0, 0.0):
            collections.clear()
            pacing = Pacing(Simulation(Scenario({'publish.rate': 50.0})), listener, factor, print)
            pacing.start()
            while len(collections) < 2:
                assert pacing.is_alive
                time.sleep(0.01)
            pacing.stop()
    finally:
        gc.callbacks.pop()
    assert inside
    assert not any(inside)


@pytest.mark.parametrize('ahead_ns', [-500_000_000, 100_000_000])
def test_ticks_are_due_from_a_given_moment_on(ahead_ns):
    """Whether it is still to come or has passed: stamps counted from it are the wall clock's."""
    published_ns: list[int] = []

    class Listener:
        def prepare(self, samples):
            return self

        def publish(self, row):
            published_ns.append(time.monotonic_ns())

        def published(self, happened, samples, messages, count):
            pass

    first_tick_ns = time.monotonic_ns() + ahead_ns
    simulation = Simulation(Scenario({'publish.rate': 50.0}))
    pacing = Pacing(simulation, Listener(), 1.0, print, first_tick_ns=first_tick_ns)
    pacing.start()
    while len(published_ns) < 3:
        assert pacing.is_alive
        time.sleep(0.01)
    pacing.stop()
    assert published_ns[0] > first_tick_ns
    # What has passed is a lag.
    assert pacing.take_punctuality().largest_lag_ns > -ahead_ns
