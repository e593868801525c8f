"""A kind of modes that one file adds, put beside the others in a copy of the package."""

import csv
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

ROOT = Path(__file__).parents[2]
FILE = 'hardening.py'
INERTIA, OMEGA = np.array([3.0, 2.0, 4.0]), np.array([0.05, 0.4, -0.1])
# A boom that gets harder, and a panel as it is shipped.
D = np.array([[0.2, 0.5, 0.1], [0.0, -0.3, 0.6]])
W, GROWTH = np.array([1.0, 1.7]), np.array([40.0, 0.0])
ETA, ETA_RATE = np.array([0.2, 0.05]), np.array([-0.1, 0.0])
DURATION_S = 60
SHEET = {
    'publish.rate': 10.0,
    'publish.topics': ['attitude', 'angular_velocity', 'hardening', 'flexible'],
    'orbit.type': 'fixed',
    'body.inertia': INERTIA.tolist(),
    'initial.attitude': [0.0, 0.0, 0.0, 1.0],
    'initial.angular_velocity': OMEGA.tolist(),
    'hardening.names': ['boom'],
    'hardening.boom.growth': GROWTH[0],
    'flexible.names': ['panel'],
    **{
        f'{mode}.{leaf}': values[n]
        for n, mode in enumerate(['hardening.boom', 'flexible.panel'])
        for leaf, values in {
            'frequency': W.tolist(),
            'coupling': D.tolist(),
            'displacement': ETA.tolist(),
            'rate': ETA_RATE.tolist(),
        }.items()
    },
}
PROGRAM = """
import numpy as np
from satdyn_ros import Scenario, Simulation
from satdyn_ros.dynamics.integrals import relative_drift

NAMES = 'hardening.boom', 'flexible.panel'
scenario = Scenario.from_yaml('sheet.yaml')
drifts = relative_drift(scenario.system, scenario.motion().at(np.linspace(0.0, 60.0, 61)))
assert {'energy', 'momentum'} <= drifts.keys(), drifts.keys()
print(max(np.abs(drift).max() for drift in drifts.values()))


class AnewEachTime(Simulation):
    def _new_stepper(self):
        return None


mine, other = Simulation(scenario), AnewEachTime(scenario)
for tick in range(20):
    a, b = (each.step(torque_b=(1e-3 * (tick // 2), 0.0, 0.0)) for each in (mine, other))
    assert a.omega_bi_b.tobytes() == b.omega_bi_b.tobytes()
    assert a.inner == b.inner
    assert {*a.inner} == {f'{name}.{x}' for name in NAMES for x in ('displacement', 'rate')}
"""


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return a folder with the package and the one file, which processes then import."""
    folder = tmp_path_factory.mktemp('own')
    skipped = shutil.ignore_patterns('__pycache__')
    shutil.copytree(ROOT / 'satdyn_ros', folder / 'satdyn_ros', ignore=skipped)
    shutil.copy(Path(__file__).parent / FILE, folder / 'satdyn_ros' / 'dynamics')
    lines = ''.join(f'    {key}: {value}\n' for key, value in SHEET.items())
    text = f'/**:\n  ros__parameters:\n{lines.replace(chr(39), "")}'
    (folder / 'sheet.yaml').write_text(text)
    (folder / 'heavy.yaml').write_text(text.replace('[0.2, 0.5, 0.1]', '[0.2, 1.5, 0.1]'))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv('PYTHONPATH', f'{folder}{os.pathsep}{os.environ.get("PYTHONPATH", "")}')
        yield folder


def run(folder, *arguments, code=0):
    """Return what a program of Python, or the command satdyn, prints."""
    done = subprocess.run([sys.executable, *arguments], cwd=folder, capture_output=True, text=True)
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout + done.stderr


def satdyn(folder, *arguments, code=0):
    return run(folder, '-m', 'satdyn_ros.cli.main', *arguments, code=code)


def swung(t_s):
    """Return rate, displacements and their rates by Lagrange's equations, (N, 7), by SciPy."""
    masses = np.block([[np.diag(INERTIA), D.T], [D, np.eye(2)]])

    def rates(t, y):
        omega, eta, eta_rate = y[:3], y[3:5], y[5:]
        H = INERTIA * omega + eta_rate @ D
        forces = [*np.cross(H, omega), *(-(W**2 + GROWTH * eta**2) * eta)]
        accelerations = np.linalg.solve(masses, forces)
        return [*accelerations[:3], *eta_rate, *accelerations[3:]]

    begin = [*OMEGA, *ETA, *ETA_RATE]
    return solve_ivp(rates, (0.0, t_s[-1]), begin, 'DOP853', t_s, rtol=1e-12, atol=1e-13).y.T


def test_it_flies_and_its_bag_verifies(folder):
    """With a mode that is shipped beside it; the boom swings as another integrator says."""
    satdyn(folder, 'simulate', 'sheet.yaml', '--duration', str(DURATION_S), '-o', 'bag')
    assert 'the same byte for byte' in satdyn(folder, 'verify', 'bag')
    satdyn(folder, 'export', 'bag', '-o', 'bag.csv')
    with (folder / 'bag.csv').open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith('#')))
    names = [f'omega_bi_b_{axis}_rad_s' for axis in 'xyz']
    names += [f'{name}_displacement_sqrt_kg_m' for name in ('boom', 'panel')]
    names += [f'{name}_rate_sqrt_kg_m_s' for name in ('boom', 'panel')]
    found = np.array([[float(row[name]) for name in names] for row in rows])
    true = swung(0.1 * np.arange(len(rows)))
    # That of SciPy's at its tolerance, after some twenty swings.
    np.testing.assert_allclose(found, true, rtol=0.0, atol=1e-9)
    # The cubic part counts: at its largest it is more than the linear one.
    assert GROWTH[0] * np.max(found[:, 3] ** 2) > W[0] ** 2
    satdyn(folder, 'report', 'bag', '-o', 'page.html')
    assert 'boom' in (folder / 'page.html').read_text()


def test_what_it_conserves_and_how_it_is_commanded(folder):
    """Energy, with that of its spring, and momentum; each step has the bits of a motion anew."""
    assert float(run(folder, '-c', PROGRAM)) < 1e-10


def test_what_sentences_say(folder):
    """Closed forms do not know it, and the body must have the inertia that it takes."""
    said = satdyn(folder, 'describe', 'sheet.yaml')
    assert 'closed forms do not know the flexible parts panel, boom' in said
    said = satdyn(folder, 'describe', 'heavy.yaml', code=2)
    assert 'hardening.boom.coupling is [0.2, 1.5, 0.1], of length' in said


def test_one_file_is_all(folder):
    """Nothing of the package but the file is other than it is shipped."""
    names = {path.relative_to(folder) for path in (folder / 'satdyn_ros').rglob('*.py')}
    shipped = {path.relative_to(ROOT) for path in (ROOT / 'satdyn_ros').rglob('*.py')}
    assert names - shipped == {Path('satdyn_ros', 'dynamics', FILE)}
    assert all((folder / name).read_bytes() == (ROOT / name).read_bytes() for name in shipped)
