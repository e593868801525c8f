"""Propagations that cannot continue end in an exception, keep what they reached, never hang."""

import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

from satdyn_ros.dynamics.motion import Halted
from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.integrate.batch import LANES, propagate_all
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import FixedDirection, KeplerOrbit

BODY = np.diag([800.0, 900.0, 600.0])
MOTOR = Rotor('motor', np.array([0.0, 0.6, 0.8]), inertia=0.5)
CALM = np.array([1e-3, 2e-3, 3e-3])
MOST_STEPS = 20_000

# What a user may ask for by mistake: the system and the rate of the body.
HOSTILE = {
    'rate 1e300': (System(BODY), np.array([1e300, 1.0, 0.0])),
    'rate 1e150': (System(BODY), np.array([1e150, 1.0, 0.0])),
    'rate 1e20': (System(BODY), np.array([1e20, 1.0, 0.0])),
    'rate 1e20 on an orbit': (System(BODY, orbit=KeplerOrbit()), np.array([1e20, 1.0, 0.0])),
    'torque 1e30': (System(BODY, torque_b=np.array([1e30, 0.0, 0.0])), CALM),
    'torque 1e300': (System(BODY, torque_b=np.array([1e300, 1e300, 0.0])), CALM),
    'mu 1e300': (System(BODY, orbit=KeplerOrbit(mu=1e300)), CALM),
    'axis of 1 m': (System(BODY, orbit=KeplerOrbit(semi_major_axis=1.0)), CALM),
    'axis of 1e-100 m': (System(BODY, orbit=KeplerOrbit(semi_major_axis=1e-100)), CALM),
    'eccentricity 0.999999': (System(BODY, orbit=KeplerOrbit(eccentricity=0.999999)), CALM),
    'gradient 1e30': (System(BODY, orbit=FixedDirection(1e30)), CALM),
    'gradient 1e300': (System(BODY, orbit=FixedDirection(-1e300)), CALM),
    'weight 1e200': (System(BODY, weight_moment=np.array([0.0, 1e200, 0.0])), CALM),
    'slender, spinning': (System(np.diag([1e12, 1e12, 1.0])), np.array([0.1, 0.2, 3.0])),
    'inertias 1e300': (System(np.diag([1e300, 1e300, 1.1e300])), np.array([0.1, 0.2, 3.0])),
    'inertias 1e-300': (System(np.diag([1e-300, 1e-300, 1.1e-300])), np.array([0.1, 0.2, 3.0])),
    'momentum 1e15': (System(BODY, (Rotor('constant_momentum', momentum=1e15),)), CALM),
    'motor 1e30': (System(BODY, (MOTOR,), rotor_torque=np.array(1e30)), CALM),
    'motor 1e308': (System(BODY, (MOTOR,), rotor_torque=np.array(1e308)), CALM),
    'nothing acts, for ages': (System(BODY), np.zeros(3)),
}


def _hostile(name):
    system, omega = HOSTILE[name]
    speed = 0.0 if system.has_turning_rotor else np.nan
    state = State(rotation.normalise([0.4, 0.4, 0.8, 0.2]), omega, speed, speed)
    return Propagation(system, state, tolerance=1e-12, most_steps=MOST_STEPS)


def _flown(motion, t_s):
    """Return the states at t_s, or the error that ended the motion."""
    try:
        return motion.at(t_s)
    except Halted as halted:
        return halted


def _is_finite(states):
    columns = [states.q_ib, states.omega_bi_b, states.work, states.r_i, states.v_i]
    return all(np.all(np.isfinite(column)) for column in columns)


@pytest.mark.parametrize(
    'name',
    # Code of its own is compiled for a body that turns a rotor.
    [
        pytest.param(name, marks=[pytest.mark.long] * system.has_turning_rotor)
        for name, (system, _) in HOSTILE.items()
    ],
)
def test_ends_in_halted_or_finite(name):
    """Whatever the numbers: finite states, or Halted with the finite rows before it."""
    t_s = np.array([0.0, 0.01, 100.0, 1e6, 1e308 if 'ages' in name else 1e7])
    states = _flown(_hostile(name), t_s)
    if isinstance(states, Halted):
        sentence, reached_s, states = str(states), states.reached_s, states.states
        assert len(sentence) < 200
        assert '\n' not in sentence
        assert 1 <= len(states) < len(t_s)
        assert states.t_s[-1] <= reached_s
    np.testing.assert_array_equal(states.t_s, t_s[: len(states)])
    assert _is_finite(states)


@pytest.mark.long
def test_hostile_beside_calm():
    """In a batch each ends as it does alone, and its neighbours continue."""
    calm = Propagation(System(BODY, orbit=KeplerOrbit()), State(rotation.IDENTITY, CALM))
    t_s = np.array([0.0, 0.01, 100.0, 1e4])
    flown = [_hostile(name) for name in HOSTILE] + [calm]
    found = propagate_all(flown, t_s)
    assert not isinstance(found[-1], Halted)
    for motion, ended in zip(flown, found, strict=True):
        alone = _flown(motion, t_s)
        assert type(alone) is type(ended)
        if isinstance(alone, Halted) and isinstance(ended, Halted):
            assert len(ended.states) == len(alone.states)
            assert str(ended).split(': ')[1] == str(alone).split(': ')[1]
            # The two differ by rounding, which grows to other steps where a motion is chaotic.
            assert ended.reached_s == pytest.approx(alone.reached_s, rel=0.1)


def _counted(most_steps=None):
    system = System(BODY, orbit=FixedDirection(1e-6))
    return Propagation(system, State(rotation.IDENTITY, 100.0 * CALM), most_steps=most_steps)


def test_steps_between_rows_are_counted():
    """One step less than the rows need halts; where it halts does not depend on the calls."""
    t_s = np.array([0.0, 30.0, 60.0, 400.0, 420.0])
    free, counts = _counted(), []
    for t in t_s:
        free.at(t)
        counts.append(free.steps)
    most = int(np.max(np.diff(counts)))
    np.testing.assert_array_equal(_counted(most).at(t_s).q_ib, free.at(t_s).q_ib)
    halted, one_by_one = _flown(_counted(most - 1), t_s), _counted(most - 1)
    assert f'more than {most - 1} steps' in str(halted)
    np.testing.assert_array_equal(halted.states.t_s, t_s[:3])
    np.testing.assert_array_equal(halted.states.q_ib, free.at(t_s[:3]).q_ib)
    same = [_flown(one_by_one, t) for t in t_s][3]
    for other in [same, *propagate_all([_counted(most - 1)] * (LANES + 1), t_s)]:
        assert str(other) == str(halted)
        # A lane differs by rounding, which the choice of step lengths multiplies.
        assert other.reached_s == pytest.approx(halted.reached_s, rel=1e-6)


def test_earlier_rows_after_a_halt():
    """A motion that halted answers all that it had reached, at once, and halts again beyond."""
    t_s = np.arange(0.0, 200.0, 5.0)
    motion, free = _counted(20), _counted()
    motion.at(t_s)
    for _ in range(2):
        with pytest.raises(Halted) as halted:
            motion.at([500.0, 195.0])
        np.testing.assert_array_equal(halted.value.states.t_s, [195.0])
        assert halted.value.reached_s < 500.0
        # More than 20 steps from the start, none of them new.
        np.testing.assert_array_equal(motion.at(150.0).q_ib, free.at(150.0).q_ib)
        np.testing.assert_array_equal(motion.at(195.0).q_ib, free.at(195.0).q_ib)
    np.testing.assert_array_equal(motion.at(198.0).q_ib, free.at(198.0).q_ib)


def test_slices_change_nothing():
    """Many slices of steps and of rows give the bits that short calls give."""
    motion, t_s = _counted(), np.linspace(0.0, 4e4, 50_001)
    table = motion.at(t_s)
    assert motion.steps > 3000
    other = _counted()
    for first in range(0, len(t_s), 777):
        part = slice(first, first + 777)
        np.testing.assert_array_equal(other.at(t_s[part]).q_ib, table.q_ib[part])


def test_other_threads_get_their_turn():
    """While a propagation that never ends is under way, another thread runs on."""
    system, omega = HOSTILE['rate 1e20']
    motion, seen = Propagation(system, State(rotation.IDENTITY, omega)), []
    motion.at(0.0)

    def count():
        for _ in range(20):
            seen.append(motion.steps)
            time.sleep(0.001)
        motion.most_steps = 1

    thread = threading.Thread(target=count)
    thread.start()
    # most_steps as the other thread sets it acts at the next slice.
    with pytest.raises(Halted):
        motion.at(1.0)
    thread.join()
    assert len(set(seen)) > 1


ENDLESS = """
import numpy as np
from satdyn_ros.integrate.batch import propagate_all
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.dynamics.system import State, System
motion = Propagation(System(np.eye(3)), State(np.array([0.0, 0.0, 0.0, 1.0]), np.full(3, 1e20)))
{ready}
print('flying', flush=True)
{fly}
"""


@pytest.mark.parametrize(
    ('ready', 'fly'),
    [
        ('motion.at(0.0)', 'motion.at(1.0)'),
        ('propagate_all([motion], [0.0])', 'propagate_all([motion], [1.0])'),
    ],
)
def test_ctrl_c_ends_it(ready, fly):
    """Ctrl-C interrupts a propagation that would never end, alone and in a batch."""
    process = subprocess.Popen(
        [sys.executable, '-c', ENDLESS.format(ready=ready, fly=fly)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == 'flying\n'
        os.kill(process.pid, signal.SIGINT)
        _, errors = process.communicate(timeout=60)
    finally:
        process.kill()
    assert errors.rstrip().endswith('KeyboardInterrupt')


def test_the_limit_is_that_of_now():
    """Of each question, whatever it was when the motion was made."""
    motion = _counted(3)
    motion.most_steps = None
    assert len(motion.at([200.0])) == 1
    motion.most_steps = 3
    with pytest.raises(Halted, match='more than 3 steps'):
        motion.at([4000.0])


def test_after_an_interruption_it_starts_again(monkeypatch):
    """In the middle of a step there is nothing to answer from."""
    motion, right = _counted(), _counted().at(np.linspace(0.0, 2000.0, 21)).q_ib
    motion.at(0.0)

    def interrupted(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr('satdyn_ros.integrate.one_lane.walk', interrupted)
        with pytest.raises(KeyboardInterrupt):
            motion.at(1000.0)
    np.testing.assert_array_equal(motion.at(np.linspace(0.0, 2000.0, 21)).q_ib, right)


def test_the_row_at_the_start_is_the_state():
    """Where no step can be taken, with a motor whose torque is known when there is one."""
    rotor = Rotor('motor', inertia=0.1, max_speed=1.0)
    system = System(np.eye(3), (rotor,), torque_b=np.array([np.inf, 0.0, 0.0]))
    state = State(rotation.IDENTITY, np.array([0.1, 0.0, 0.0]), 0.5, 0.0)
    for halted in propagate_all([Propagation(system, state)], [0.0, 1.0]):
        assert isinstance(halted, Halted)
        assert halted.states.omega_bi_b.tolist() == [[0.1, 0.0, 0.0]]
