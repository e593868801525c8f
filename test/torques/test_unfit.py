"""A torque of one's own that is none: one sentence, which names the class and what is wrong."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from torques import unfit

from satdyn_ros import Scenario
from satdyn_ros.dynamics.motion import Halted
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.integrate.batch import propagate_all
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.torques.body_torque import named

REST = State(np.array([0.0, 0.0, 0.0, 1.0]), np.zeros(3))
FUNCTION = r'torque\(t_s, r_i, v_i, q_ib, omega_bi_b, constants\)'


@pytest.mark.parametrize(
    ('kind', 'sentence'),
    [
        ('NoName', 'has no name'),
        ('NoConstants', 'has no Constants, a NamedTuple of floats'),
        ('PlainConstants', 'has Constants that are not a NamedTuple'),
        ('NoTorque', f'cannot be made: it has no function {FUNCTION}'),
        ('Method', f'has a torque that is not a static method {FUNCTION}'),
        ('FewArguments', f'has a torque that is not a static method {FUNCTION}'),
        ('FewForSigns', r'has a signs that is not a static method signs\(t_s, r_i'),
        ('TextKeys', r"has the keys \('text_keys.size',\); they must be a tuple of Key"),
        ('ForeignKey', r'has the key size; its keys must begin with foreign_key\.'),
        ('Topic', 'has the topic a b; it must have only letters, digits and _'),
        ('OfRaises', "cannot be made: KeyError: 'size'"),
        ('OfRefuses', 'cannot be made: .*'),
        ('OfNumber', 'cannot be made: its of returns 5; it must return a OfNumber or None'),
        ('NoKey', r'cannot be made: it has no key no_key\.size'),
        ('Text', "cannot be made: size of its Constants is '5'; it must be a float"),
        ('Thing', 'cannot be made: size of its Constants is None; it must be a float'),
        ('Stops', 'cannot be made: its stops must return times in an array of one dim'),
    ],
)
def test_a_class_that_is_no_torque_is_refused(kind, sentence):
    """By the command line before anything flies, and in Python."""
    with pytest.raises(ValueError, match=f'^the torque torques.unfit:{kind} {sentence}') as found:
        Scenario({}, [named(f'torques.unfit:{kind}')])
    assert '\n' not in str(found.value)
    with pytest.raises(ValueError, match=re.escape(str(found.value))):
        Scenario({}, [getattr(unfit, kind)])


@pytest.mark.parametrize(
    ('kind', 'sentence'),
    [
        ('Two', 'its torque returns a tuple of 2; it must return a tuple of 3 numbers'),
        ('Nothing', 'its torque returns nothing; it must return a tuple of 3 numbers'),
        (
            'Array',
            'its torque returns a value of type ndarray; it must return a tuple of 3 numbers',
        ),
        ('Product', "its torque cannot be computed: can't multiply sequence by non-int"),
        ('Import', 'its torque cannot be computed: .*ufunc'),
        ('Field', "its torque cannot be computed: AttributeError: .* has no attribute 'size'"),
        ('Chooses', 'its torque cannot be computed: it branches on .* must choose by select'),
    ],
)
def test_a_function_that_cannot_be_computed_is_refused(kind, sentence):
    """In a sentence with its file and line, alone and beside others."""
    torque = getattr(unfit, kind)
    system = System(np.eye(3), torques=(torque(torque.Constants()),))
    pattern = f'^the torque torques.unfit:{kind}: {sentence}.* \\(unfit.py, line \\d+\\)$'
    with pytest.raises(ValueError, match=pattern) as no:
        Propagation(system, REST).at([2.0])
    with pytest.raises(ValueError, match=pattern):
        propagate_all([Propagation(system, REST)] * 2, [2.0])
    assert '\n' not in str(no.value)
    assert len(str(no.value)) < 250


def test_where_it_is_no_number_the_motion_halts_and_it_is_named():
    """At the time from which it is the root of a negative number."""
    torque = unfit.NoNumber(unfit.NoNumber.Constants())
    with pytest.raises(Halted, match=r'halt at 3\.5 s: the torque torques\.unfit:NoNumber is not'):
        Propagation(System(np.eye(3), torques=(torque,)), REST).at([1.0, 5.0])


def test_the_command_line_says_it_too(tmp_path):
    """Exit code 2 and one line, of one that is no torque and of one that cannot be computed."""
    program = 'import sys; from satdyn_ros.cli.main import main; sys.exit(main())'
    for kind in ('OfRaises', 'Two'):
        command = ['describe', 'cubesat', '--torque', f'unfit:{kind}']
        done = subprocess.run(
            [sys.executable, '-c', program, *command],
            cwd=Path(__file__).parent,
            capture_output=True,
            text=True,
            check=False,
        )
        assert (done.returncode, done.stdout) == (2, ''), done.stderr
        assert done.stderr.splitlines()[-1].startswith(f'satdyn describe: the torque unfit:{kind}')
        assert 'Traceback' not in done.stderr
