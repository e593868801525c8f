"""A torque of one's own that is none: one sentence, which names the class and what is wrong."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from torques import unfit
from torques.test_inherited import AT_REST

from satdyn_ros import Scenario
from satdyn_ros.dynamics.motion import Halted
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.dynamics.torque import own_torque
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
        ('Topic', 'has the topic a b; it must have letters, digits and _ alone'),
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
        ('Two', 'its torque returns a tuple of 2, .*; it must return a tuple of 3 numbers'),
        ('Nothing', 'its torque returns nothing; it must return a tuple of 3 numbers'),
        ('Array', r'its torque cannot be compiled: it makes an array .* \(unfit.py, line \d+\)'),
        ('Product', r'cannot be compiled: there is no mul\(UniTuple.* \(unfit.py, line \d+\)'),
        ('Import', r'cannot be compiled: .*IMPORT_NAME.* \(unfit.py, line \d+\)'),
        ('Field', r"cannot be compiled: Unknown attribute 'size'.* \(unfit.py, line \d+\)"),
    ],
)
def test_a_function_that_cannot_be_compiled_is_refused(kind, sentence):
    """In a sentence with the line, not in the compiler's pages."""
    torque = getattr(unfit, kind)
    with pytest.raises(ValueError, match=f'^the torque torques.unfit:{kind}: .*{sentence}$') as no:
        own_torque((torque(torque.Constants()),), AT_REST)
    assert '\n' not in str(no.value)
    assert len(str(no.value)) < 250


def test_where_it_is_no_number_the_motion_halts_and_it_is_named():
    """At the time from which it is the root of a negative number."""
    torque = unfit.NoNumber(unfit.NoNumber.Constants())
    with pytest.raises(Halted, match=r'halt at 3\.5 s: the torque torques\.unfit:NoNumber is not'):
        Propagation(System(np.eye(3), torques=(torque,)), REST).at([1.0, 5.0])


@pytest.mark.long
def test_what_flies_alone_may_not_fly_among_many():
    """An if cannot choose for eight motions at once; the sentence says what can."""
    system = System(np.eye(3), torques=(unfit.Chooses(unfit.Chooses.Constants()),))
    with pytest.raises(ValueError, match=r'unfit:Chooses: .* must choose by select, not by if'):
        propagate_all([Propagation(system, REST)] * 2, [2.0])


def test_the_command_line_says_it_too(tmp_path):
    """Exit code 2 and one line, of one that is no torque and of one that cannot be compiled."""
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
