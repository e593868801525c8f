"""The Orbit Ephemeris Message, read by others."""

import numpy as np
import pytest
from exchange.readers import by_orekit

from satdyn_ros.base import nanoseconds
from satdyn_ros.exchange.ccsds import Subject
from satdyn_ros.exchange.oem import OemWriter
from satdyn_ros.orbits import KeplerOrbit

ORBIT = KeplerOrbit(eccentricity=0.1, inclination=0.9, raan=0.4, argument_of_periapsis=-1.0)
T_S = np.arange(10) * 60.0
STAMPS_NS = 1_700_000_000_000_000_001 + (T_S * 1e9).astype(np.int64)


@pytest.fixture(scope='module')
def path(tmp_path_factory):
    path = tmp_path_factory.mktemp('oem') / 'orbit.oem'
    with open(path, 'w+') as file:
        writer = OemWriter(file, Subject('SAT', 'GCRF'))
        r_i, v_i = ORBIT.position_velocity(T_S)
        writer.write(STAMPS_NS[:4], r_i[:4], v_i[:4])
        writer.write(STAMPS_NS[4:], r_i[4:], v_i[4:])
        writer.end_segment()
    return path


def assert_true(r_i, v_i):
    """Assert that positions [m] and velocities [m/s] are the orbit's, to sixteen digits."""
    ours = ORBIT.position_velocity(T_S)
    np.testing.assert_allclose(r_i, ours[0], rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(v_i, ours[1], rtol=0.0, atol=1e-11)


def test_orekit_reads_the_orbit(path):
    """Positions, velocities and epochs, in one segment."""
    (rows,) = by_orekit(path)
    epochs, r_i, v_i = zip(*rows, strict=True)
    assert list(epochs) == nanoseconds.epochs(STAMPS_NS)
    assert_true(r_i, v_i)


def test_ccsds_ndm_reads_the_orbit(path):
    """The package of that name on PyPI: each component in its place."""
    ndm_io = pytest.importorskip('ccsds_ndm.ndm_io', reason='pip install "satdyn_ros[readers]"')
    (segment,) = ndm_io.NdmIo().from_path(path).body.segment
    rows = segment.data.state_vector
    assert [row.epoch for row in rows] == nanoseconds.epochs(STAMPS_NS)
    km = 1000.0
    r_i, v_i = (
        [[km * float(getattr(row, name + dot).value) for name in 'xyz'] for row in rows]
        for dot in ('', '_dot')
    )
    assert_true(r_i, v_i)


def test_the_oem_package_reads_the_orbit(path):
    """Its checks of keywords and order pass; km and km/s."""
    oem = pytest.importorskip('oem', reason='pip install "satdyn_ros[readers]"')
    (segment,) = oem.OrbitEphemerisMessage.open(path).segments
    states = list(segment.states)
    assert {(state.frame, state.center) for state in states} == {('GCRF', 'EARTH')}
    assert [state.epoch.utc.to_value('isot', 'date_hms')[:19] for state in states] == [
        epoch[:19] for epoch in nanoseconds.epochs(STAMPS_NS)
    ]
    km = 1000.0
    assert_true([s.position * km for s in states], [s.velocity * km for s in states])
