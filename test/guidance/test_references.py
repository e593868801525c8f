"""References point where others have what they point at, and turn as their differences say."""

from types import SimpleNamespace

import numpy as np
import pytest
from environment import truth
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from satdyn_ros import Scenario, Simulation, guidance
from satdyn_ros.base.nanoseconds import SECOND_NS, epoch, stamp_ns
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import KeplerOrbit

EPOCH_NS = stamp_ns('2020-12-16T12:30:00')
ORBIT = KeplerOrbit(
    semi_major_axis=7.2e6, eccentricity=0.05, inclination=1.7, raan=0.4, true_anomaly=1.1
)
NAMES = 'latitude', 'longitude'
MUNICH = '48.137 deg', '11.575 deg'
REFERENCES = {
    'nadir': guidance.nadir,
    'sun': guidance.sun(),
    'sun by -y': guidance.sun((0.0, -1.0, 0.2)),
    'target': guidance.target(*MUNICH),
    'inertial': guidance.inertial([0.5, -0.5, 0.5, 1.5]),
}

each_reference = pytest.mark.parametrize('reference', REFERENCES.values(), ids=REFERENCES)


def orbit_state(t_s, orbit=ORBIT):
    """Return what a reference asks of a sample, at a time from the epoch."""
    r_i, v_i = orbit.position_velocity(t_s)
    return SimpleNamespace(r_i=r_i, v_i=v_i, stamp_ns=EPOCH_NS + round(t_s * SECOND_NS))


def turned_by(reference, t_s, step_s):
    """Return rate and acceleration at a time, from attitudes around it, both in axes r."""
    before, now, after = (reference(orbit_state(t_s + k * step_s)).q_ir for k in (-1, 0, 1))
    to, on = (
        rotation.to_vector(rotation.multiply(rotation.conjugate(now), q)) for q in (before, after)
    )
    return (on - to) / (2.0 * step_s), (on + to) / step_s**2


@each_reference
def test_rate_and_acceleration_are_those_of_the_attitude(reference):
    """
    By differences of attitudes over a second, at forty positions of an eccentric orbit.

    Tolerance: the differences are off by a sixth and a twelfth of the third and the fourth
    derivative, and of an attitude known to 2e-16, by 4e-16/s^2; the rate goes up to 0.01 rad/s.
    """
    fastest = 0.0
    for t_s in np.linspace(0.0, 6000.0, 40):
        _, omega, alpha = reference(orbit_state(t_s))
        rate, acceleration = turned_by(reference, t_s, 1.0)
        fastest = max(fastest, float(np.linalg.norm(omega)))
        assert_allclose(rate, omega, rtol=0.0, atol=2e-4 * fastest**2 + 1e-9)
        assert_allclose(acceleration, alpha, rtol=0.0, atol=1e-3 * fastest**2 + 1e-12)
    assert (fastest > 1e-9) == (reference is not REFERENCES['inertial'])


def test_nadir_is_lvlh_and_turns_as_the_true_anomaly_grows():
    """
    Kepler: about minus the normal, by h / r^2, which grows as r falls.

    Tolerance: rounding of what is 1e-3 rad/s and 1e-7 rad/s^2 large.
    """
    for t_s in (0.0, 1000.0, 4000.0):
        at = orbit_state(t_s)
        reference = guidance.nadir(at)
        r, h = np.linalg.norm(at.r_i), np.linalg.norm(np.cross(at.r_i, at.v_i))
        growing = -2.0 * h / r**3 * (at.r_i @ at.v_i) / r
        assert rotation.angle_between(reference.q_ir, ORBIT.lvlh(t_s)) < 1e-14
        assert_allclose(reference.omega_ri_r, [0.0, -h / r**2, 0.0], rtol=0.0, atol=1e-17)
        assert_allclose(reference.alpha_ri_r, [0.0, -growing, 0.0], rtol=0.0, atol=1e-20)


def test_nadir_of_two_satellites_side_by_side():
    """Rows of orbit states give rows of references."""
    one, other = orbit_state(0.0), orbit_state(900.0)
    both = SimpleNamespace(
        r_i=np.stack([one.r_i, other.r_i]), v_i=np.stack([one.v_i, other.v_i]), stamp_ns=0
    )
    for found, *rows in zip(guidance.nadir(both), *map(guidance.nadir, (one, other)), strict=True):
        assert_allclose(found, rows, rtol=1e-15, atol=1e-20)


def reference_states():
    """Return samples at the reference's positions; it has no velocities, which are ours."""
    positions = zip(truth.points('r_gcrs'), truth.points('epoch_ns'), strict=True)
    return [
        SimpleNamespace(r_i=r_i, v_i=np.cross([1e-3, 2e-4, -1e-4], r_i), stamp_ns=int(at_ns))
        for r_i, at_ns in positions
    ]


def test_the_sun_is_where_the_reference_has_it():
    """
    Body z points to it; the second axis lies between it and the normal, on the normal's side.

    Tolerance: the same ephemeris, and an attitude's rounding.
    """
    axis_b = np.array([0.6, -0.8, 0.0])
    for at, sun_i in zip(reference_states(), truth.points('sun_from_body'), strict=True):
        q_ir = guidance.sun(axis_b)(at).q_ir
        second_i, normal = rotation.rotate(q_ir, axis_b), np.cross(at.r_i, at.v_i)
        assert_allclose(rotation.rotate(q_ir, [0.0, 0.0, 1.0]), sun_i, rtol=0.0, atol=2e-15)
        assert abs(np.cross(sun_i, normal) @ second_i) < 1e-14 * np.linalg.norm(normal)
        assert second_i @ normal > 0.0


def test_the_point_below_is_against_the_vertical():
    """
    Straight below, at the latitude and longitude that the reference has, is the target.

    Tolerance: from 100 km on, a point on the ground that is known to 1e-9 m.
    """
    low = truth.points('height_m') > 1e5
    latitudes, longitudes = (np.radians(truth.points(f'{name}_deg')) for name in NAMES)
    vertical_t = np.stack(
        [
            np.cos(latitudes) * np.cos(longitudes),
            np.cos(latitudes) * np.sin(longitudes),
            np.sin(latitudes),
        ],
        axis=-1,
    )
    vertical_i = np.einsum('nij,ni->nj', truth.points('gcrs_to_itrs'), vertical_t)
    rows = zip(reference_states(), latitudes, longitudes, vertical_i, low, strict=True)
    assert np.count_nonzero(low) > 10
    for at, latitude, longitude, up_i, is_high in rows:
        if is_high:
            q_ir = guidance.target(latitude, longitude)(at).q_ir
            assert_allclose(rotation.rotate(q_ir, [0.0, 0.0, 1.0]), -up_i, rtol=0.0, atol=1e-13)


@pytest.mark.long
def test_sun_and_ground_as_astropy_has_them():
    """
    The line to Munich and to the Sun, over a pass.

    UT1 - UTC and polar motion are left out: in 2020 the ground is off by less than 100 m, 2e-4 rad
    from 500 km.  The Sun is the same ephemeris, called elsewhere: 1e-8 rad.
    """
    coordinates = pytest.importorskip('astropy.coordinates')
    time = pytest.importorskip('astropy.time')
    units = pytest.importorskip('astropy.units')
    pytest.importorskip('astropy.utils.iers').conf.auto_download = False
    munich = coordinates.EarthLocation.from_geodetic(11.575, 48.137, 0.0)
    for t_s in (0.0, 300.0, 2000.0):
        at = orbit_state(t_s)
        then = time.Time(epoch(at.stamp_ns), scale='utc')
        ground_i = munich.get_gcrs(then).cartesian.xyz.to_value(units.m)
        earth, sun = (
            coordinates.get_body_barycentric(name, then).xyz.to_value(units.m)
            for name in ('earth', 'sun')
        )
        for reference, target_i, allowed in (
            (guidance.target(*MUNICH), ground_i, 2e-4),
            (guidance.sun(), sun - earth, 1e-8),
        ):
            line = target_i - at.r_i
            z_i = rotation.rotate(reference(at).q_ir, [0.0, 0.0, 1.0])
            assert np.linalg.norm(np.cross(z_i, line)) < allowed * np.linalg.norm(line)
            assert z_i @ line > 0.0


HEAD = """CCSDS_AEM_VERS = 2.0
CREATION_DATE = 2020-12-16T00:00:00
ORIGINATOR = TEST
META_START
OBJECT_NAME = SAT
OBJECT_ID = 2020-000A
REF_FRAME_A = EME2000
REF_FRAME_B = SC_BODY_1
TIME_SYSTEM = UTC
START_TIME = {begin}
STOP_TIME = {end}
ATTITUDE_TYPE = QUATERNION/ANGVEL
ANGVEL_FRAME = SC_BODY_1
INTERPOLATION_METHOD = HERMITE
INTERPOLATION_DEGREE = 7
META_STOP
DATA_START
"""


def test_a_file_is_followed_between_its_rows(tmp_path):
    """
    A turn about one axis that becomes faster: angle, rate and acceleration are its polynomial's.

    Tolerance: the remainder of Hermite's polynomial over rows 2 s apart, and a difference of the
    rates over 0.1 s.
    """
    axis, begin = np.array([2.0, -1.0, 2.0]) / 3.0, Rotation.from_quat([0.1, -0.3, 0.2, 0.9])

    def turn(t_s):
        return begin * Rotation.from_rotvec((0.01 * t_s + 0.001 * t_s**2) * axis)

    rows = [
        f'{epoch(EPOCH_NS + round(t_s * SECOND_NS))} '
        + ' '.join(f'{x:.16e}' for x in (*turn(t_s).as_quat(), *np.degrees(rate) * axis))
        for t_s, rate in ((t_s, 0.01 + 0.002 * t_s) for t_s in np.arange(0.0, 21.0, 2.0))
    ]
    path = tmp_path / 'turn.aem'
    head = HEAD.format(begin=rows[0].split()[0], end=rows[-1].split()[0])
    path.write_text('\n'.join([head.rstrip(), *rows, 'DATA_STOP\n']))
    reference = guidance.from_aem(path)
    for t_s in (0.0, 0.7, 9.0, 20.0):
        q_ir, omega, alpha = reference(orbit_state(t_s))
        assert (turn(t_s).inv() * Rotation.from_quat(q_ir)).magnitude() < 1e-9
        assert_allclose(omega, (0.01 + 0.002 * t_s) * axis, rtol=0.0, atol=1e-9)
        assert_allclose(alpha, 0.002 * axis, rtol=0.0, atol=1e-7)
    with pytest.raises(ValueError, match=r'turn\.aem has no attitude at .*; the nearest is'):
        reference(orbit_state(21.0))


def test_a_sample_of_a_simulation_is_an_orbit_state():
    """Where a run begins in LVLH, nadir is its attitude; so is the Sun where it begins at that."""
    values = {
        'orbit.type': 'kepler',
        'orbit.eccentricity': 0.01,
        'orbit.inclination': 0.9,
        'environment.sun': 'ephemeris',
        'time.epoch': '2020-12-16T12:30:00Z',
    }
    for pointing, reference in (('nadir', guidance.nadir), ('sun', guidance.sun())):
        simulation = Simulation(Scenario(values | {'initial.pointing': pointing}))
        simulation.advance(1)
        sample = simulation.sample
        assert rotation.angle_between(reference(sample).q_ir, sample.q_ib) < 1e-14


@pytest.mark.parametrize(
    ('make', 'reason'),
    [
        (lambda: guidance.sun((0, 0, 1)), 'second_axis is .*; it must be 3 numbers, not along z'),
        (lambda: guidance.sun((1, 0)), 'second_axis is .*; it must be 3 numbers'),
        (lambda: guidance.target(1.6, 0.0), 'latitude is 1.6; it must be .* between -90 and 90'),
        (lambda: guidance.target('48 m', 0.0), 'latitude is 48 m; it must be .* such as 48.1 deg'),
        (lambda: guidance.target(0.0, '400 deg'), 'longitude is 400 deg; it must be '),
        (lambda: guidance.inertial([0, 0, 0, 0]), 'q is .*; it must be 4 numbers'),
    ],
)
def test_what_is_no_reference_is_refused(make, reason):
    """In one sentence that says what was given and what is allowed."""
    with pytest.raises(ValueError, match=reason):
        make()


def test_without_an_orbit_there_is_no_nadir():
    """Of orbit.type fixed position and velocity are zero."""
    nowhere = SimpleNamespace(r_i=np.zeros(3), v_i=np.zeros(3), stamp_ns=0)
    with pytest.raises(ValueError, match='the sample has no position'):
        guidance.nadir(nowhere)
