"""A kind of modes that one file adds, put beside the others in a copy of the package."""

import csv
from pathlib import Path

import numpy as np
import pytest
from package_with import PackageWith
from scipy.integrate import solve_ivp

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
def own(tmp_path_factory):
    own = PackageWith(tmp_path_factory.mktemp('own'), Path(__file__).parent / FILE)
    own.write('sheet', SHEET)
    own.write('heavy', SHEET | {'hardening.boom.coupling': [0.2, 1.5, 0.1]})
    own.write('namesakes', SHEET | {'hardening.names': ['panel', 'boom']})
    return own


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


def test_it_flies_and_its_bag_verifies(own):
    """With a mode that is shipped beside it; the boom swings as another integrator says."""
    own.satdyn('simulate', 'sheet.yaml', '--duration', str(DURATION_S), '-o', 'bag')
    assert 'the same byte for byte' in own.satdyn('verify', 'bag')
    own.satdyn('export', 'bag', '-o', 'bag.csv')
    with (own.folder / 'bag.csv').open() as file:
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
    own.satdyn('report', 'bag', '-o', 'page.html')
    assert 'boom' in (own.folder / 'page.html').read_text()


def test_what_it_conserves_and_how_it_is_commanded(own):
    """Energy, with that of its spring, and momentum; each step has the bits of a motion anew."""
    assert float(own.run('-c', PROGRAM)) < 1e-10


def test_what_sentences_say(own):
    """Closed forms do not know it; it takes of the body's inertia; each mode has its own name."""
    said = own.satdyn('describe', 'sheet.yaml')
    assert 'closed forms do not know the flexible parts panel, boom' in said
    said = own.satdyn('describe', 'heavy.yaml', code=2)
    assert 'hardening.boom.coupling is [0.2, 1.5, 0.1], of length' in said
    said = own.satdyn('describe', 'namesakes.yaml', code=2)
    assert "hardening.names has 'panel', which is in flexible.names too; each mode needs" in said
