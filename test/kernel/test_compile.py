"""Cached compiled code never outlives the equations that it was compiled from."""

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from pathlib import Path

import pytest
from numba import njit

from satdyn_ros.kernel.code_folder import sources
from satdyn_ros.kernel.compile import inlined

ROOT = Path(__file__).parents[2]
# A small compiled function that calls another file's.
USER = """
import logging
import sys
from ..kernel.compile import compiled, inlined
from ..kernel import vector

dot = inlined(vector.dot)

@compiled
def square(a):
    return dot(a, a)

logging.basicConfig(stream=sys.stdout, format='%(message)s', level=logging.INFO)
print(square((1.0, 2.0, 3.0)))
"""
# What it calls, in any room.
CALLED = """
def dot(a, b):
    return a[0] * b[0]
"""
# The same function for another type, as the equations are for another number of rotors.
OTHER_TYPE = """
from .user import square

print(square((1, 2, 3)))
"""
# For one of four types more.
SOME_TYPE = """
import os
from .user import square

x, y = ((1, 1.0)[int(digit)] for digit in os.environ['TYPES'])
print(square((2, x, y)))
"""
LONG = """
import logging
import sys
import numpy as np
from ..exact.free import Free
from .system import State, System

logging.basicConfig(stream=sys.stdout, format='%(message)s', level=logging.INFO)
system = System(np.diag([1.0, 2.0, 2.5]))
Free(system, State(np.array([0.0, 0.0, 0.0, 1.0]), np.array([0.2, 0.3, 1.0]))).at(0.0)
"""
# Another process, of newer sources, removes the folder for the code of these.
VANISHING = """
import shutil
from ..kernel import compile, vector

dot = compile.inlined(vector.dot)
square = compile.compiled(lambda a: dot(a, a))
shutil.rmtree(compile._FOLDER)
print(square((1.0, 2.0, 3.0)))
"""
NOTICE = 'compiling, for some ten seconds: the code is kept for the next start'
# A user without name or home.
NOBODY = 12345
# The interpreter and the tests may lie in root's home, which this user shall read all the same.
AS_NOBODY = (
    f'setpriv --reuid {NOBODY} --regid {NOBODY} --clear-groups '
    '--inh-caps=+dac_read_search --ambient-caps=+dac_read_search'
).split()

ANOMALY = """
from satdyn_ros.orbits.kepler import KeplerOrbit
KeplerOrbit(eccentricity=0.1).anomaly(60.0)
"""
ELLIPSE = """
from hashlib import sha256
import numpy as np
from satdyn_ros.orbits.kepler import KeplerOrbit
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.dynamics.system import State, System

orbit = KeplerOrbit(eccentricity=0.1)
t_s = np.linspace(0.0, 6000.0, 601)
state = State(np.array([0.0, 0.0, 0.6, 0.8]), np.array([0.01, 0.02, -0.01]))
states = Propagation(System(np.diag([900.0, 800.0, 600.0]), orbit=orbit), state).at(t_s)
print(sha256(states.q_ib.tobytes() + orbit.anomaly(t_s).tobytes()).hexdigest())
"""
# Everything that is compiled: ellipse, free rotor and torque; closed form; lanes.
MOTIONS = """
import sys
from hashlib import sha256
import numpy as np
from satdyn_ros import Scenario
from satdyn_ros.integrate.batch import propagate_all
from satdyn_ros.orbits.kepler import KeplerOrbit
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System

system = System(
    np.diag([900.0, 800.0, 600.0]),
    (Rotor('free', np.array([0.0, 1.0, 0.0]), inertia=0.05),),
    KeplerOrbit(eccentricity=0.1),
    torque_b=np.array([0.0, 1e-4, 0.0]),
)
state = State(np.array([0.0, 0.0, 0.6, 0.8]), np.array([0.01, 0.02, -0.01]), 30.0, 0.0)
t_s = np.linspace(0.0, 6000.0, 601)
tables = [
    Propagation(system, state).at(t_s),
    Scenario.from_yaml('config/default.yaml').motion().at(t_s),
    Scenario.from_yaml('config/paladini.yaml').motion().at(t_s),
    *propagate_all([Propagation(system, state)], t_s),
    *propagate_all([Scenario.from_yaml('config/default.yaml').motion()], t_s),
]
for states in tables:
    print(sha256(states.q_ib.tobytes() + states.omega_bi_b.tobytes()).hexdigest())
"""


@pytest.fixture
def package(tmp_path):
    """Return a copy of the package with one more module of compiled code."""
    copy = tmp_path / 'satdyn_ros'
    shutil.copytree(ROOT / 'satdyn_ros', copy, ignore=shutil.ignore_patterns('__pycache__'))
    (copy / 'dynamics' / 'user.py').write_text(USER)
    (copy / 'dynamics' / 'other_type.py').write_text(OTHER_TYPE)
    (copy / 'dynamics' / 'some_type.py').write_text(SOME_TYPE)
    (copy / 'dynamics' / 'long.py').write_text(LONG)
    (copy / 'dynamics' / 'vanishing.py').write_text(VANISHING)
    return copy


def start(package, module='user', before=(), **environment):
    """Start a process that imports a module of the package's dynamics."""
    return subprocess.Popen(
        [*before, sys.executable, '-c', f'import satdyn_ros.dynamics.{module}'],
        env=os.environ | {'PYTHONPATH': str(package.parent), 'NUMBA_CACHE_DIR': ''} | environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        cwd=package.parent,
    )


def said(process):
    """Return the lines that a process prints until it ends with success."""
    output, _ = process.communicate()
    assert process.returncode == 0, output
    return output.splitlines()


@pytest.mark.parametrize('elsewhere', [False, pytest.param(True, marks=pytest.mark.long)])
def test_code_is_kept_until_any_source_changes(package, tmp_path, elsewhere):
    """Kept for the next start; a change in what is called makes new code, and old code goes."""
    environment = {'NUMBA_CACHE_DIR': str(tmp_path / 'cache')} if elsewhere else {}
    assert said(start(package, **environment)) == [NOTICE, '14.0']
    assert said(start(package, **environment)) == ['14.0']
    vector = package / 'kernel' / 'vector.py'
    vector.write_text(
        vector.read_text().replace('return a[0] * b[0] +', 'return 2 * a[0] * b[0] +')
    )
    assert said(start(package, **environment)) == [NOTICE, '15.0']
    folder = 'cache/satdyn_ros' if elsewhere else 'satdyn_ros/__pycache__/compiled'
    assert [path.is_dir() for path in (tmp_path / folder).iterdir()] == [True]


# What compiled code reaches, from the rooms of the package.
ROOMS = (
    *('base', 'environment', 'orbits', 'torques', 'dynamics', 'integrate', 'theory', 'exact'),
    *('rosbag2', 'sweep'),
)


@pytest.mark.long
@pytest.mark.parametrize('room', ROOMS)
def test_code_does_not_outlive_a_source_of_any_room(package, room):
    """Compiled code that calls a function of a room is that of the function as it is now."""
    called = package / room / 'called.py'
    called.write_text(CALLED)
    user = package / 'dynamics' / 'user.py'
    user.write_text(
        USER.replace('from ..kernel import vector', f'from ..{room} import called as vector')
    )
    assert said(start(package)) == [NOTICE, '1.0']
    assert said(start(package)) == ['1.0']
    called.write_text(CALLED.replace('a[0] * b[0]', 'a[1] * b[1]'))
    assert said(start(package)) == [NOTICE, '4.0']


@pytest.mark.long
@pytest.mark.parametrize('library', ['numba', 'llvmlite', 'numpy', 'scipy'])
def test_code_does_not_outlive_the_version_of_a_library(package, library):
    """The tableau of the method is SciPy's, and the others make the code."""
    (package / 'dynamics' / 'upgraded.py').write_text(
        'from importlib import metadata\n'
        'version = metadata.version\n'
        f'metadata.version = lambda name: version(name) + ".1" * (name == {library!r})\n'
        'from . import user\n'
    )
    assert said(start(package)) == [NOTICE, '14.0']
    assert said(start(package, module='upgraded')) == [NOTICE, '14.0']


@pytest.mark.long
def test_every_type_of_arguments_is_compiled_with_the_notice(package):
    """Code for one type does not count as code for another; both are kept."""
    assert said(start(package)) == [NOTICE, '14.0']
    assert said(start(package, module='other_type')) == ['14.0', NOTICE, '14']
    assert said(start(package, module='other_type')) == ['14.0', '14']


def test_python_runs_an_inlined_function_as_it_is_written():
    """Also where a compiled function has it; there is no code that Python could jump to."""
    twice = inlined(lambda a: a + a)
    assert njit(lambda a: twice(a) + 1.0)(3.0) == 7.0
    assert (twice(3.0), twice('3')) == (6.0, '33')


@pytest.mark.long
def test_many_processes_compile_once(package):
    """Of processes started together one compiles; the others wait and find the code."""
    processes = [start(package) for _ in range(4)]
    assert sorted(line for each in processes for line in said(each)) == ['14.0'] * 4 + [NOTICE]


@pytest.mark.long
def test_code_that_processes_compile_at_once_for_several_types_is_all_kept(package):
    """None waits for the others, and none takes out what another has put in."""
    said(start(package))

    def all_say(*lines):
        types = '00', '01', '10', '11'
        for process in [start(package, module='some_type', TYPES=each) for each in types]:
            *before, _ = said(process)
            assert before == ['14.0', *lines]

    all_say(NOTICE)
    all_say()


def test_sources_are_not_looked_for_where_code_is_kept(tmp_path):
    """Other processes remove the folders of older code there: looking into one failed."""
    for name in ('b.py', 'a/c.py', 'a/notes.txt', '__pycache__/compiled/0/d.py'):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    assert sources(tmp_path) == [tmp_path / 'a' / 'c.py', tmp_path / 'b.py']


def test_a_folder_for_code_that_is_gone_is_no_error(package):
    """As where another process, of newer sources, has removed that of older ones."""
    assert said(start(package, module='vanishing')) == ['14.0']


def test_a_propagation_loads_neither_compiler_nor_linear_algebra():
    """Numba and SciPy's linear algebra take as long as the rest of a start."""
    program = """
import sys
from satdyn_ros import Scenario
Scenario().motion().at(0.0)
assert not {'numba', 'scipy.linalg'} & sys.modules.keys()
"""
    subprocess.run([sys.executable, '-c', program], check=True)


@pytest.mark.parametrize(
    'number',
    [
        signal.SIGINT,
        pytest.param(signal.SIGTERM, marks=pytest.mark.long),
        pytest.param(signal.SIGKILL, marks=pytest.mark.long),
    ],
)
def test_a_signal_ends_the_compilation(package, number):
    """A process that compiles ends at a signal, before there is code, and its child with it."""
    process = start(package, module='long')
    assert process.stdout.readline() == f'{NOTICE}\n'
    process.send_signal(number)
    process.wait()
    while compilers(package):
        time.sleep(0.01)
    assert list((package / '__pycache__').rglob('*.nbi')) == []


def test_a_compiler_that_heard_ctrl_c_is_not_followed_by_another(package):
    """A terminal sends it to all; who ignores it, as a worker of a sweep, ends all the same."""
    process = start(package, module='long')
    assert process.stdout.readline() == f'{NOTICE}\n'
    while not any(leaves_ctrl_c(compiler) for compiler in compilers(package)):
        time.sleep(0.01)
    os.kill(compilers(package)[0], signal.SIGINT)
    output, _ = process.communicate()
    assert output.endswith('KeyboardInterrupt\n')
    assert list((package / '__pycache__').rglob('*.nbi')) == []


def leaves_ctrl_c(compiler):
    """Whether a compiler that is loaded lets the system handle SIGINT, as it does by then."""
    status, maps = (Path(f'/proc/{compiler}/{name}').read_text() for name in ('status', 'maps'))
    caught = next(line for line in status.splitlines() if line.startswith('SigCgt'))
    return 'llvmlite' in maps and not int(caught.split()[1], 16) >> signal.SIGINT - 1 & 1


def compilers(package):
    """Return the processes that compile code of a package."""
    found = []
    for path in Path('/proc').glob('[0-9]*/cmdline'):
        with suppress(OSError):
            if str(package.parent) in path.read_bytes().decode().split('\0'):
                found.append(int(path.parent.name))
    return found


@pytest.fixture(scope='module')
def as_nobody():
    """Return what to write before a command of a user without name or home."""
    if subprocess.run([*AS_NOBODY, sys.executable, '-c', ''], stderr=subprocess.PIPE).returncode:
        pytest.skip('only root, with its capability to read all, can act as another user')
    return AS_NOBODY


@pytest.mark.parametrize(
    'home',
    [
        pytest.param('none', marks=pytest.mark.long),
        'own',
        pytest.param('of another', marks=pytest.mark.long),
    ],
)
def test_a_user_who_cannot_write_the_package(package, as_nobody, tmp_path, home):
    """Code is kept in the user's cache folder or, without one, until the process ends."""
    others, own = tmp_path / 'others', tmp_path / 'own'
    others.mkdir(mode=0o777)
    others.chmod(0o777)
    own.mkdir()
    os.chown(own, NOBODY, NOBODY)
    without_home = [*as_nobody, 'env', '-u', 'HOME']
    user = {
        'none': {'before': without_home},
        'own': {'before': as_nobody, 'HOME': str(own)},
        'of another': {'before': as_nobody, 'HOME': str(others)},
    }[home]
    first, second = (said(start(package, **user)) for _ in range(2))
    if home == 'own':
        assert (first, second) == ([NOTICE, '14.0'], ['14.0'])
        assert list((own / '.cache/satdyn_ros').rglob('*.nbi'))
        return
    for notice, result in first, second:
        assert result == '14.0'
        folder = Path(notice.split('written, and ')[1].split(' is removed')[0])
        assert folder.parent.parent == Path(tempfile.gettempdir())
        assert not folder.parent.exists()
    assert list(others.rglob('*.nbi')) == []


@pytest.mark.long
@pytest.mark.skipif(os.geteuid() != 0, reason='only root can give a folder away')
def test_no_code_of_another_user_is_run(package):
    """A package folder of another user, or one that all can write to, is not used for code."""
    said(start(package))
    kept = package / '__pycache__' / 'compiled'
    kept.chmod(0o777)
    assert said(start(package, HOME=str(package.parent))) == [NOTICE, '14.0']
    kept.chmod(0o755)
    os.chown(kept, NOBODY, NOBODY)
    environment = {'HOME': str(package.parent), 'XDG_CACHE_HOME': str(package.parent / 'cache')}
    assert said(start(package, **environment)) == [NOTICE, '14.0']


def printed(program, folder):
    """Return what a program prints that keeps its compiled code in a folder."""
    return subprocess.run(
        [sys.executable, '-c', program],
        env=os.environ | {'NUMBA_CACHE_DIR': str(folder)},
        stdout=subprocess.PIPE,
        check=True,
        cwd=ROOT,
    ).stdout


@pytest.mark.long
def test_the_same_bits_when_compiled_and_when_loaded(tmp_path):
    """The process that compiles gives the same bytes as those that find the code."""
    first, second = (printed(MOTIONS, tmp_path) for _ in range(2))
    assert first == second
    # A motion in a lane may have the very bits that it has alone.
    assert len(set(first.split())) >= 3


@pytest.mark.long
def test_the_same_bits_whichever_function_is_compiled_first(tmp_path):
    """Kepler's equation is solved inside the propagation and outside, compiled once for both."""
    inside_first = printed(ELLIPSE, tmp_path / 'inside')
    outside_first = printed(ANOMALY + ELLIPSE, tmp_path / 'outside')
    assert inside_first == outside_first
