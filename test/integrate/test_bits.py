"""Compiled or not, alone or in lanes: the source defines the bits."""

import inspect
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from drawn_systems import drawn

from satdyn_ros.dynamics.motion import Halted
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.integrate import step_code as step_code_module
from satdyn_ros.integrate import walk as walk_module
from satdyn_ros.integrate.batch import propagate_all
from satdyn_ros.integrate.course import problem_of
from satdyn_ros.integrate.lanes import END, EXITS, REACHED, UNFINISHED, Lanes
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.integrate.step_code import step_code
from satdyn_ros.integrate.walk import walk
from satdyn_ros.kernel import rotation
from satdyn_ros.rosbag2.reader import Bag
from satdyn_ros.trace.graph import flatten

PLAIN = (
    'import runpy, sys; sys.modules["numba"] = sys.modules["llvmlite"] = None; '
    'sys.path.insert(0, sys.argv[1]); '
    'runpy.run_path(sys.argv.pop(1) + "/plain_walk.py", run_name="__main__")'
)
STEPS = 50
INERTIA = np.diag([3.0, 2.0, 4.0])


def compiled_bits(seed):
    """Return the time and the variables after STEPS steps, in hexadecimal."""
    motion = Propagation(*drawn(seed))
    code, course = step_code(motion.constants, 1), motion.new_course()
    lanes = Lanes(1, code.layout, flatten(motion.constants)[1])
    problem = problem_of(motion.begin()[None], [course], code.layout, motion.wanted)
    t_s = np.array([np.finfo(float).max])
    problem.ask(t_s)
    course.allow(STEPS, problem, 0)
    while not walk(problem.address, *2 * (lanes.address,), code.attempt, code.dense):
        if UNFINISHED < problem.outcome[0] < REACHED:
            course.go_on(problem, lanes, 0, t_s)
            # An exit counts as many steps, of which this test has none.
            course.allow(STEPS + 200 * lanes.step_state[0, EXITS], problem, 0)
    y = lanes.y[: problem.begin.shape[1]]
    return np.array([lanes.step_state[0, END], *y]).tobytes().hex()


def plain(seeds):
    """Return the bits of the plain walks by their seeds, and what they met."""
    here = str(Path(__file__).parents[1])
    done = subprocess.run(
        [sys.executable, '-c', PLAIN, here, str(STEPS), *map(str, seeds)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    *lines, met = done.stdout.splitlines()
    return dict(line.split() for line in lines), [int(x) for x in met.split()]


def check(seeds):
    found, met = plain(seeds)
    assert [seed for seed in seeds if compiled_bits(seed) != found[str(seed)]] == []
    print('pieces, exits, stops and corners:', met)
    return met


def test_code_has_the_bits_of_the_plain_functions():
    """Of systems of all kinds, with everything that ends a step."""
    assert min(check(range(20))) > 0


def test_one_wrong_operation_would_be_seen(monkeypatch):
    """With sums in place of differences in the code the bits are others."""
    right = step_code_module.text_of

    def wrong(*kind):
        return right(*kind).replace(' = fsub ', ' = fadd ')

    monkeypatch.setattr(step_code_module, '_known', {})
    monkeypatch.setattr(step_code_module, 'text_of', wrong)
    found, _ = plain([1])
    assert compiled_bits(1) != found['1']


@pytest.mark.long
def test_code_has_the_bits_of_the_plain_functions_of_many():
    """As above; each is of a kind of its own, whose code is made in some seconds."""
    assert min(check(range(20, 80))) > 3


@pytest.mark.long
def test_a_bag_has_the_same_bytes_for_every_processor(tmp_path):
    """Where there are sums, products, quotients and roots alone, but for the axes of the orbit."""
    program = 'import sys; from satdyn_ros.cli.main import main; sys.exit(main(sys.argv[1:]))'
    found = set()
    for name in ('', 'x86-64', 'haswell', 'znver2'):
        other = {'NUMBA_CPU_NAME': name, 'NUMBA_CPU_FEATURES': ''} if name else {}
        bag = tmp_path / f'bag_{name}'
        subprocess.run(
            [sys.executable, '-c', program, 'simulate', 'default', '--duration', '60', '-o', bag],
            env=os.environ | {'NUMBA_CACHE_DIR': str(tmp_path / f'cache_{name}')} | other,
            check=True,
        )
        messages = Bag(bag).messages('/attitude').data
        # All but the head and the stamp, which is that of the start.
        found.add(b''.join(bytes(row)[12:] for row in messages))
    assert len(found) == 1


def flown(motion, t_s):
    """Return the bytes of all that a motion's states are, up to where it may come to a halt."""
    try:
        states = motion if not isinstance(motion, Propagation) else motion.at(t_s)
    except Halted as halted:
        states = halted
    if isinstance(states, Halted):
        states = states.states
    numbers = states.q_ib, states.omega_bi_b, states.rotor_speed, states.rotor_angle, states.work
    torque = b'' if states.rotor_torque is None else states.rotor_torque.tobytes()
    return [*(np.ascontiguousarray(each).tobytes() for each in numbers), torque]


@pytest.mark.parametrize('count', [1, 7, 8, 9, 1000])
def test_any_number_of_motions_has_the_bits_of_each(count):
    """Each ends in its own time, and the next takes its lane."""
    rng = np.random.default_rng(count)
    rates, t_s = rng.normal(0.0, 1.0, (count, 3)), np.linspace(0.0, 20.0, 5)

    def motions():
        return [Propagation(System(INERTIA), State(rotation.IDENTITY, each)) for each in rates]

    together = propagate_all(motions(), t_s)
    chosen = rng.permutation(count)[:50]
    alone = motions()
    assert all(flown(together[m], t_s) == flown(alone[m], t_s) for m in chosen)


@pytest.mark.parametrize('seed', [0, pytest.param(1, marks=pytest.mark.long)])
def test_lanes_have_the_bits_of_each_alone(seed):
    """In random company, in any order; what is met there is what is met alone."""
    rng = np.random.default_rng(seed)
    seeds = range(8) if seed == 0 else range(100)
    t_s = np.linspace(0.0, 600.0, 13)
    alone = {each: flown(Propagation(*drawn(each)), t_s) for each in seeds}
    for _ in range(2):
        order = rng.permutation([*seeds, *seeds])
        together = propagate_all([Propagation(*drawn(each)) for each in order], t_s)
        different = [
            int(each)
            for each, states in zip(order, together, strict=True)
            if flown(states, t_s) != alone[each]
        ]
        assert different == []


@pytest.mark.parametrize('seed', range(4))
def test_the_walk_does_what_python_does(seed, monkeypatch):
    """The same function run by Python, with the code of the steps, writes the same rows."""
    t_s = np.linspace(0.0, 30.0, 7)
    by_code = flown(Propagation(*drawn(seed)), t_s)
    monkeypatch.setattr(walk_module, 'walk', inspect.unwrap(walk))
    assert flown(Propagation(*drawn(seed)), t_s) == by_code
