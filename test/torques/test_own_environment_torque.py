"""A torque of the environment that one file adds, beside the others in a copy of the package."""

import csv
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

ROOT = Path(__file__).parents[2]
FILE = 'eddy_currents.py'
# A sphere, on which gravity makes no torque.
MOMENT, K, DURATION_S = 2.0, 1e5, 200
SHEET = {
    'publish.rate': 1.0,
    'publish.topics': ['attitude', 'angular_velocity', 'magnetic_field', 'eddy_currents_torque'],
    'time.epoch': '2026-03-01T00:00:00Z',
    'body.inertia': [MOMENT] * 3,
    'body.eddy_currents': K,
    'environment.magnetic_field': 'dipole',
    'initial.frame': 'inertial',
    'initial.angular_velocity': [0.02, -0.01, 0.03],
}


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return a folder with the package and the one file, which processes then import."""
    folder = tmp_path_factory.mktemp('own')
    skipped = shutil.ignore_patterns('__pycache__')
    shutil.copytree(ROOT / 'satdyn_ros', folder / 'satdyn_ros', ignore=skipped)
    shutil.copy(Path(__file__).parent / FILE, folder / 'satdyn_ros' / 'torques')
    lines = ''.join(f'    {key}: {value}\n' for key, value in SHEET.items())
    text = f'/**:\n  ros__parameters:\n{lines.replace(chr(39), "")}'
    (folder / 'sheet.yaml').write_text(text)
    (folder / 'no_field.yaml').write_text(text.replace('dipole', 'none'))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv('PYTHONPATH', f'{folder}{os.pathsep}{os.environ.get("PYTHONPATH", "")}')
        yield folder


def satdyn(folder, *arguments, code=0):
    """Return what the command satdyn prints."""
    command = [sys.executable, '-m', 'satdyn_ros.cli.main', *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout + done.stderr


def test_it_flies_and_its_bag_verifies(folder):
    """Its topic has k (omega x B) x B, and the rate under it is another integrator's."""
    satdyn(folder, 'simulate', 'sheet.yaml', '--duration', str(DURATION_S), '-o', 'bag')
    assert 'the same byte for byte' in satdyn(folder, 'verify', 'bag')
    satdyn(folder, 'export', 'bag', '-o', 'bag.csv')
    with (folder / 'bag.csv').open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith('#')))

    def columns(name, unit):
        return np.array([[float(row[f'{name}_{axis}{unit}']) for axis in 'xyz'] for row in rows])

    omega, B = columns('omega_bi_b', '_rad_s'), columns('magnetic_field_b', '_t')
    torque = columns('eddy_currents_torque_b', '_n_m')
    np.testing.assert_allclose(torque, K * np.cross(np.cross(omega, B), B), rtol=1e-12, atol=0.0)
    # In inertial axes, where the field changes slowly: I omega' = torque, of a sphere.
    q_ib = np.array([[float(row[f'q_ib_{axis}']) for axis in 'xyzw'] for row in rows])
    to_inertial = Rotation.from_quat(q_ib)
    t_s = np.arange(float(len(rows)))
    field = CubicSpline(t_s, to_inertial.apply(B))

    def rate(t, w):
        return K / MOMENT * np.cross(np.cross(w, field(t)), field(t))

    omega_i = to_inertial.apply(omega)
    true = solve_ivp(rate, (0.0, t_s[-1]), omega_i[0], 'DOP853', t_s, rtol=1e-12, atol=1e-15).y.T
    # The spline between the ticks: a few (dt)^4 of a field that turns by 1e-3 a second.
    np.testing.assert_allclose(omega_i, true, rtol=0.0, atol=1e-12)
    # 1e5 (3e-5)^2 / 2 a second, of what is across the field: percents of the rate.
    assert np.linalg.norm(omega[-1]) < 0.999 * np.linalg.norm(omega[0])


def test_what_pages_and_warnings_say(folder):
    """The report has a panel of it; without its field its key has no effect, and that is said."""
    satdyn(folder, 'report', 'bag', '-o', 'page.html')
    assert 'torque of eddy currents' in (folder / 'page.html').read_text()
    said = satdyn(folder, 'describe', 'no_field.yaml')
    assert (
        'body.eddy_currents is given, but without environment.magnetic_field it has no effect'
        in said
    )
    said = satdyn(folder, 'describe', 'sheet.yaml')
    assert 'closed forms do not know the torque eddy_currents' in said


def test_one_file_is_all(folder):
    """Nothing of the package but the file is other than it is shipped."""
    names = {path.relative_to(folder) for path in (folder / 'satdyn_ros').rglob('*.py')}
    shipped = {path.relative_to(ROOT) for path in (ROOT / 'satdyn_ros').rglob('*.py')}
    assert names - shipped == {Path('satdyn_ros', 'torques', FILE)}
    assert all((folder / name).read_bytes() == (ROOT / name).read_bytes() for name in shipped)
