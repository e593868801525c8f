"""Types of orbits that one file adds, put beside the others in a copy of the package."""

import csv
from pathlib import Path

import numpy as np
import pytest
from package_with import PackageWith
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

FILES = 'forced_circle.py', 'fly_by.py'
MU, INERTIA = 3.986004418e14, np.array([800.0, 900.0, 600.0])
BEGIN, OMEGA = np.array([0.1, -0.2, 0.3, 0.9273618495495703]), np.array([1e-3, 2e-3, -1e-3])
DURATION_S = 2000
R, RATE = 7e6, 3e-3
FROM, ALONG = np.array([7e6, -6e6, 1e6]), np.array([0.0, 6e3, 0.0])
FORCED = {'orbit.type': 'forced', 'orbit.semi_major_axis': R, 'orbit.turn_rate': RATE}
# A torque that varies along the orbit, so that the position on it is integrated too; it is too
# small to be seen.
TURNED = {
    'time.epoch': '2026-03-01T00:00:00Z',
    'environment.magnetic_field': 'dipole',
    'body.dipole': [1e-9, 0.0, 0.0],
}
LINE = {'orbit.type': 'line', 'orbit.position': FROM.tolist(), 'orbit.velocity': ALONG.tolist()}


def on_circle(t_s):
    return R * np.array([np.cos(RATE * t_s), np.sin(RATE * t_s), 0.0 * t_s])


def on_line(t_s):
    return FROM[:, None] + ALONG[:, None] * t_s


# By name what is flown, and where that is at times.
FLOWN = {
    'circle': (FORCED, on_circle),
    'circle_and_field': (FORCED | TURNED, on_circle),
    'line': (LINE, on_line),
}


@pytest.fixture(scope='module')
def own(tmp_path_factory):
    here = Path(__file__).parent
    own = PackageWith(tmp_path_factory.mktemp('own'), *(here / file for file in FILES))
    for name, (given, _) in FLOWN.items():
        sheet = {
            'publish.rate': 0.1,
            'publish.topics': ['odometry', 'attitude_lvlh', 'gravity_gradient'],
            'body.inertia': INERTIA.tolist(),
            'initial.frame': 'inertial',
            'initial.attitude': BEGIN.tolist(),
            'initial.angular_velocity': OMEGA.tolist(),
            **given,
        }
        own.write(name, sheet)
    return own


def attitudes(position, t_s):
    """Return q_ib by SciPy's integrator, of Euler's equations with the gravity gradient."""

    def rates(t, y):
        q, omega = y[:4], y[4:]
        r_i = position(np.array([t]))[:, 0]
        r_b = Rotation.from_quat(q).inv().apply(r_i)
        r = np.linalg.norm(r_b)
        torque = 3.0 * MU / r**5 * np.cross(r_b, INERTIA * r_b)
        x, y_, z, w = q
        turn = np.array([[w, -z, y_], [z, w, -x], [-y_, x, w], [-x, -y_, -z]]) @ omega / 2.0
        return [*turn, *((torque - np.cross(omega, INERTIA * omega)) / INERTIA)]

    span, begin = (0.0, t_s[-1]), [*BEGIN, *OMEGA]
    return solve_ivp(rates, span, begin, 'DOP853', t_s, rtol=1e-12, atol=1e-13).y[:4].T


@pytest.mark.parametrize('name', FLOWN)
def test_it_flies_and_its_bag_verifies(own, name):
    """Position and attitude are another integrator's, and the run is repeated from the bag."""
    own.satdyn('simulate', f'{name}.yaml', '--duration', str(DURATION_S), '-o', name)
    assert 'the same byte for byte' in own.satdyn('verify', name)
    own.satdyn('export', name, '-o', f'{name}.csv')
    with (own.folder / f'{name}.csv').open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith('#')))

    def columns(*names):
        return np.array([[float(row[name]) for name in names] for row in rows])

    t_s = 10.0 * np.arange(len(rows))
    _, position = FLOWN[name]
    r_i = columns('r_i_x_m', 'r_i_y_m', 'r_i_z_m')
    np.testing.assert_allclose(r_i, position(t_s).T, rtol=0.0, atol=1e-6)
    q_ib = columns('q_ib_x', 'q_ib_y', 'q_ib_z', 'q_ib_w')
    true = attitudes(position, t_s)
    true *= np.sign(np.sum(true * q_ib, axis=1))[:, None]
    # That of SciPy's at its tolerance.
    np.testing.assert_allclose(q_ib, true, rtol=0.0, atol=1e-9)
    q_lb = columns('q_lb_x', 'q_lb_y', 'q_lb_z', 'q_lb_w')
    nadir_b = Rotation.from_quat(q_lb).inv().apply([0.0, 0.0, 1.0])
    nadir_i = Rotation.from_quat(q_ib).apply(nadir_b)
    expected = -r_i / np.linalg.norm(r_i, axis=1)[:, None]
    np.testing.assert_allclose(nadir_i, expected, rtol=0.0, atol=1e-12)


def test_what_theory_says(own):
    """It knows no closed form there, and says so."""
    for name in ('circle', 'line'):
        said = own.satdyn('describe', f'{name}.yaml')
        assert 'no closed form: the orbit is not a circle' in said


def test_its_keys_belong_to_it(own):
    """With another type its key is refused, and the sentence names its own."""
    text = (own.folder / 'circle.yaml').read_text()
    (own.folder / 'other.yaml').write_text(text.replace('type: forced', 'type: kepler'))
    found = own.satdyn('describe', 'other.yaml', code=2)
    assert 'orbit.turn_rate is 0.003; with orbit.type kepler only its default' in found
    assert 'it belongs to forced' in found
