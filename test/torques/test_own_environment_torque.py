"""A torque of the environment that one file adds, beside the others in a copy of the package."""

import csv
from pathlib import Path

import numpy as np
import pytest
from package_with import PackageWith
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

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
def own(tmp_path_factory):
    own = PackageWith(tmp_path_factory.mktemp('own'), Path(__file__).parent / FILE)
    own.write('sheet', SHEET)
    own.write('no_field', SHEET | {'environment.magnetic_field': 'none'})
    return own


def test_it_flies_and_its_bag_verifies(own):
    """Its topic has k (omega x B) x B, and the rate under it is another integrator's."""
    own.satdyn('simulate', 'sheet.yaml', '--duration', str(DURATION_S), '-o', 'bag')
    assert 'the same byte for byte' in own.satdyn('verify', 'bag')
    own.satdyn('export', 'bag', '-o', 'bag.csv')
    with (own.folder / 'bag.csv').open() as file:
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


def test_what_pages_and_warnings_say(own):
    """The report has a panel of it; without its field its key has no effect, and that is said."""
    own.satdyn('report', 'bag', '-o', 'page.html')
    assert 'torque of eddy currents' in (own.folder / 'page.html').read_text()
    said = own.satdyn('describe', 'no_field.yaml')
    assert (
        'body.eddy_currents is given, but without environment.magnetic_field it has no effect'
        in said
    )
    said = own.satdyn('describe', 'sheet.yaml')
    assert 'closed forms do not know the torque eddy_currents' in said
