"""SPK kernels that CSPICE wrote fly as CSPICE evaluates them."""

import numpy as np
import pytest
from exchange.readers import LEAP_SECONDS
from numpy.testing import assert_allclose
from orbits.test_ephemeris import EPOCH_NS, KEPLER, at

from satdyn_ros import Scenario
from satdyn_ros.orbits.ephemeris import EphemerisOrbit
from satdyn_ros.orbits.spk import oem_of_spk

spiceypy = pytest.importorskip('spiceypy')
pytest.importorskip('erfa')

SATELLITE = -125544
MINUTES = 60.0 * np.arange(-10, 200)
T_S = np.random.default_rng(7).uniform(-600.0, 11940.0, 100)
ISS = (
    '1 25544U 98067A   26060.50000000  .00016717  00000-0  30571-3 0  9997',
    '2 25544  51.6400 208.9163 0006317  69.9862 290.2011 15.49560532    14',
)
# What SGP4 has of the Earth (WGS 72): J2, J3, J4, ke, two heights, its radius and a unit.
WGS_72 = [1.082616e-3, -2.53881e-6, -1.65597e-6, 7.43669161e-2, 120.0, 78.0, 6378.135, 1.0]


@pytest.fixture(autouse=True)
def leap_seconds(tmp_path):
    """Let SPICE know them."""
    (tmp_path / 'leap_seconds.tls').write_text(LEAP_SECONDS)
    spiceypy.furnsh(str(tmp_path / 'leap_seconds.tls'))
    yield
    spiceypy.kclear()


def ephemeris_time(t_s):
    """Return SPICE's instants of times from tick 0."""
    return np.array([spiceypy.utc2et(at(t)) for t in np.atleast_1d(t_s)])


def states(t_s):
    """Return states of KEPLER (N, 6) [km, km/s]."""
    return np.hstack(KEPLER.position_velocity(np.asarray(t_s))) / 1e3


def written(path, *segments):
    """Write a kernel of segments, each a function of its handle, and return its path."""
    handle = spiceypy.spkopn(str(path), 'TEST', 0)
    for segment in segments:
        segment(handle)
    spiceypy.spkcls(handle)
    return path


def of_states(t_s, kind=13, degree=7, body=SATELLITE, center=399, frame='J2000', off_km=0.0):
    """Return a segment of type 9 or 13, of states at times from tick 0."""

    def write(handle):
        et_s, rows = ephemeris_time(t_s), states(t_s)
        rows[:, 0] += off_km
        {9: spiceypy.spkw09, 13: spiceypy.spkw13}[kind](
            handle, body, center, frame, et_s[0], et_s[-1], 'X', degree, len(rows), rows, et_s
        )

    return write


def of_polynomials(handle):
    """Write a segment of type 2: Chebyshev's polynomials over 600 s each."""
    begin = ephemeris_time(-600.0)[0]
    count, terms = 21, 16
    nodes = np.polynomial.chebyshev.chebpts1(terms)
    found = []
    for k in range(count):
        rows = states(-600.0 + 600.0 * k + 300.0 * (nodes + 1.0))[:, :3]
        found.append(np.polynomial.chebyshev.chebfit(nodes, rows, terms - 1).T.ravel())
    series = np.ravel(found)
    spiceypy.spkw02(
        handle, SATELLITE, 399, 'J2000', begin, begin + 600.0 * count, 'X',
        600.0, count, terms - 1, series, begin,
    )  # fmt: skip


def of_elements(handle):
    """Write a segment of type 10: an element set and SGP4."""
    epoch, elements = spiceypy.getelm(1957, ISS)
    et_s = ephemeris_time([-600.0, 12000.0])
    spiceypy.spkw10(
        handle, SATELLITE, 399, 'J2000', et_s[0], et_s[1], 'X', WGS_72, 1, elements, [epoch]
    )


def flown(path):
    return EphemerisOrbit(oem_of_spk(path), EPOCH_NS)


@pytest.mark.parametrize(
    'segment',
    [of_states(MINUTES), of_states(MINUTES, 9, 9), of_polynomials, of_elements],
    ids=['hermite', 'lagrange', 'chebyshev', 'sgp4'],
)
def test_each_type_flies_as_cspice_evaluates_it(tmp_path, segment):
    """Within the half centimetre that the rows are made for, and what a time of SPICE resolves."""
    path = written(tmp_path / 'sat.bsp', segment)
    r_i, v_i = flown(path).position_velocity(T_S)
    spiceypy.furnsh(str(path))
    right = np.array(
        [spiceypy.spkgeo(SATELLITE, at_s, 'J2000', 399)[0] for at_s in ephemeris_time(T_S)]
    )
    assert_allclose(r_i, 1e3 * right[:, :3], rtol=0.0, atol=6e-3)
    assert_allclose(v_i, 1e3 * right[:, 3:], rtol=0.0, atol=1e-3)
    if segment is not of_elements:
        # Polynomials of even length in TDB, against which TT is 3e-6 s late at their end.
        allowed = 0.03 if segment is of_polynomials else 6e-3
        assert_allclose(r_i, KEPLER.position_velocity(T_S)[0], rtol=0.0, atol=allowed)


def test_axes_that_do_not_turn_are_turned_into_j2000(tmp_path):
    """Those of the ecliptic."""
    path = written(tmp_path / 'sat.bsp', of_states(MINUTES, frame='ECLIPJ2000'))
    r_i, _ = flown(path).position_velocity(T_S)
    right = KEPLER.position_velocity(T_S)[0] @ spiceypy.pxform('ECLIPJ2000', 'J2000', 0.0).T
    assert_allclose(r_i, right, rtol=0.0, atol=6e-3)


def test_of_segments_that_overlap_the_last_is_in_force(tmp_path):
    """As in SPICE; a jump from one to the next is no gap, and not interpolated across."""
    later = of_states(MINUTES[100:120], off_km=1.0)
    path = written(tmp_path / 'sat.bsp', of_states(MINUTES), later)
    orbit = flown(path)
    assert len(orbit.spans) == 3
    begin_s, end_s = MINUTES[100], MINUTES[119]
    off = orbit.position_velocity(T_S)[0] - KEPLER.position_velocity(T_S)[0]
    inside = (T_S > begin_s) & (T_S < end_s)
    assert inside.any()
    assert_allclose(off[:, 0], np.where(inside, 1e3, 0.0), rtol=0.0, atol=6e-3)


def test_a_scenario_names_the_kernel_and_its_bag_needs_none(tmp_path):
    """The value is the text of an OEM, which is the same each time."""
    written(tmp_path / 'sat.bsp', of_states(MINUTES), of_states(MINUTES, body=301))
    (tmp_path / 'sat.yaml').write_text(
        '/**:\n  ros__parameters:\n    orbit: {type: oem, file: sat.bsp}\n'
        f'    time: {{epoch: "{at(0.0)}Z"}}\n'
    )
    scenario = Scenario.from_yaml(tmp_path / 'sat.yaml')
    assert scenario['orbit.file'].startswith('CCSDS_OEM_VERS = 2.0\n')
    r_i, _ = scenario.system.orbit.position_velocity(100.0)
    assert_allclose(r_i, KEPLER.position_velocity(100.0)[0], rtol=0.0, atol=6e-3)
    assert Scenario.from_yaml(tmp_path / 'sat.yaml') == scenario


@pytest.mark.parametrize(
    ('segments', 'reason'),
    [
        (
            [of_states(MINUTES, center=10)],
            'it has no satellite about the Earth, 399; .* segments: 10$',
        ),
        ([of_states(MINUTES, body=301)], 'it has no satellite about the Earth'),
        (
            [of_states(MINUTES), of_states(MINUTES, body=-9)],
            'it has 2 satellites, -125544, -9; it must have one',
        ),
        ([of_states(MINUTES, frame='IAU_EARTH')], 'its axes are IAU_EARTH, which turn'),
        ([of_states(MINUTES[:4], 9, 1)], 'its positions or velocities jump at 2026-.* TT$'),
    ],
)
def test_what_is_no_ephemeris_of_a_satellite_is_refused(tmp_path, segments, reason):
    """In one sentence with the file."""
    written(tmp_path / 'sat.bsp', *segments)
    values = {'orbit': {'type': 'oem', 'file': str(tmp_path / 'sat.bsp')}}
    with pytest.raises(ValueError, match=rf'^orbit.file /\S*/sat.bsp: {reason}'):
        Scenario.from_dict(values)


def test_a_damaged_kernel_is_refused(tmp_path):
    """What SPICE says of it, on one line."""
    path = written(tmp_path / 'sat.bsp', of_states(MINUTES))
    content = path.read_bytes()
    for name, damaged in (('short', content[:1500]), ('none', b'DAF/SPK \xff' * 300)):
        (tmp_path / f'{name}.bsp').write_bytes(damaged)
        values = {'orbit': {'type': 'oem', 'file': str(tmp_path / f'{name}.bsp')}}
        with pytest.raises(ValueError, match=r'^orbit.file \S*: SPICE says: [^\n]*$'):
            Scenario.from_dict(values)
