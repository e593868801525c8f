"""Sun sensor, coarse sun sensor, and a star tracker that the Sun blinds."""

import numpy as np
import pytest
from environment import truth
from numpy.testing import assert_allclose
from scipy import stats
from scipy.spatial.transform import Rotation
from sensors.truth import at_tick_0, everywhere, turning

from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import KeplerOrbit
from satdyn_ros.orbits.kepler import EARTH_MU
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.sensors import CoarseSunSensor, StarTracker, SunSensor

AU_M, J2000_UNIX_S = 149_597_870_700.0, 946_728_000
NOISE = 2e-3
MOUNTING = rotation.about([0.6, 0.0, 0.8], 2.0)
# It begins between Earth and Sun, which is along x; half an orbit later it is dark.
ORBIT = KeplerOrbit(mu=EARTH_MU, semi_major_axis=7e6)
HALF_ORBIT_S = np.pi * np.sqrt(7e6**3 / EARTH_MU)


def flown(count, q_ib=rotation.IDENTITY, interval_s=0.01, sun_i=(AU_M, 0.0, 0.0)):
    """Return the states of a body at rest, the Sun ahead of it along x."""
    return turning(count, np.zeros(3), interval_s, ORBIT, q_ib, everywhere(sun=sun_i))


def measured(sensor, states, blocks=(None,)):
    """Return exposures and values of consecutive states, in blocks that end at `blocks`."""
    memory, found, begin = sensor.memory, [], 0
    for end in [*(len(states) if end is None else end for end in blocks)]:
        some, memory = sensor.measure(range(begin, end), states.rows(slice(begin, end)), memory)
        found.append(some)
        begin = end
    return [
        np.concatenate([getattr(some, name) for some in found]) for name in ('exposed', 'values')
    ]


def looking_at(direction_b):
    """Return the mounting of a sensor whose z axis looks along a direction in body axes."""
    turn, _ = Rotation.align_vectors([direction_b], [[0.0, 0.0, 1.0]])
    return turn.as_quat()


def test_angles_are_chi_square_of_two_axes():
    """The squared angle to the Sun over sigma squared is, and is not where sigma is 5% off."""
    _, values = measured(SunSensor(3, 7, mounting=MOUNTING, noise=NOISE), flown(20_000))
    true = Rotation.from_quat(MOUNTING).inv().apply([1.0, 0.0, 0.0])
    angles = np.linalg.norm(np.cross(true, values), axis=-1)
    for factor, is_right in [(1.0, True), (1.05, False)]:
        squares = (angles / NOISE / factor) ** 2
        assert (stats.kstest(squares, 'chi2', args=(2,)).pvalue > 1e-3) == is_right
    assert_allclose(np.linalg.norm(values, axis=-1), 1.0, rtol=1e-14)


@pytest.mark.parametrize(('view_deg', 'sees'), [(0.0, True), (59.9, False), (60.1, True)])
def test_it_sees_nothing_out_of_its_view(view_deg, sees):
    """The Sun is 60 deg from its z axis; without a field of view it sees everywhere."""
    away = looking_at([np.cos(np.pi / 3.0), np.sin(np.pi / 3.0), 0.0])
    sensor = SunSensor(3, 7, mounting=away, field_of_view=np.radians(view_deg))
    assert len(measured(sensor, flown(5))[0]) == (5 if sees else 0)


def test_it_sees_nothing_in_the_shadow():
    """
    Over one orbit it is silent while less than half of the disc is free.

    Half of it is free where the Sun's centre is at the Earth's edge, within the 2e-5 rad by which
    that is not straight: the angle from the shadow's axis is then asin(R / r), to 0.3 mrad, which
    is a tenth of what the body moves from sample to sample.
    """
    count = 2000
    states = flown(count, interval_s=2.0 * HALF_ORBIT_S / count)
    exposed, _ = measured(SunSensor(3, 7), states)
    dark = np.setdiff1d(np.arange(count), exposed)
    step = 2.0 * np.pi / count
    half_angle = np.arcsin(6378137.0 / 7e6)
    assert np.array_equal(np.diff(dark), np.ones(len(dark) - 1))
    assert_allclose([dark[0], dark[-1]], (np.pi + half_angle * np.array([-1, 1])) / step, atol=1.1)


def test_blocks_do_not_show():
    """Tick by tick, in blocks or at once, with samples anywhere in them: the same bits."""
    states = flown(100, interval_s=HALF_ORBIT_S / 50)
    for sensor in (
        SunSensor(3, 7, divisor=3, noise=NOISE, field_of_view=1.0, mounting=looking_at([1, 0, 0])),
        CoarseSunSensor(3, 7, divisor=3, noise=NOISE),
    ):
        whole = measured(sensor, states)
        assert len(whole[0]) > 20
        for blocks in (range(1, 101), (2, 31, 32, None)):
            for part, expected in zip(measured(sensor, states, blocks), whole, strict=True):
                assert np.array_equal(part, expected)


@pytest.mark.parametrize(
    ('angle_deg', 'far', 'expected'),
    [(0.0, 1.0, 128_000.0), (60.0, 1.0, 64_000.0), (100.0, 1.0, 0.0), (60.0, 1.016, 62_000.12)],
)
def test_a_cell_has_the_cosine_of_the_light(angle_deg, far, expected):
    """By hand: 128000 lx at 1 au, the cosine of the angle, the square of the distance."""
    angle = np.radians(angle_deg)
    sensor = CoarseSunSensor(3, 7, mounting=looking_at([np.cos(angle), 0.0, np.sin(angle)]))
    _, values = measured(sensor, flown(2, sun_i=(far * AU_M + 7e6, 0.0, 0.0)))
    assert_allclose(values, expected, rtol=1e-6, atol=1e-9)


def test_a_cell_scatters_as_it_says():
    """Kolmogorov and Smirnov's test of lit samples and, about zero, of those in the shadow."""
    states = flown(20_000, interval_s=HALF_ORBIT_S / 10_000)
    sensor = CoarseSunSensor(3, 7, mounting=looking_at([1.0, 0.0, 0.0]), noise=1e3)
    _, values = measured(sensor, states)
    _, true = measured(sensor.perfect(), states)
    assert 2000 < np.count_nonzero(true == 0.0) < 8000
    deviates = (values - true) / np.sqrt(sensor.variances[0])
    assert stats.kstest(deviates, 'norm').pvalue > 1e-3
    assert stats.kstest(deviates[true == 0.0], 'norm').pvalue > 1e-3


@pytest.mark.parametrize('name', ['srp_geo', 'srp_sun_sync', 'all_two_wheels'])
def test_the_sun_is_the_references(name):
    """
    In a run the direction at tick 0 is a reference case's, and the light is the formula's.

    With the reference's lit fraction, and the distance of the Sun by the low-precision formula of
    the Astronomical Almanac, which is good to 1e-4 au: the light to 2e-4.
    """
    case = next(case for case in truth.cases('sun_b') if case['name'] == name)
    sensors = {
        'names': ['sun', 'cell'],
        'sun': {'type': 'sun_sensor', 'mounting': MOUNTING.tolist()},
        'cell': {'type': 'coarse_sun_sensor', 'mounting': MOUNTING.tolist()},
    }
    scenario = Scenario.from_dict({**case['scenario'], 'sensors': sensors})
    states = at_tick_0(scenario)
    field, sun, cell = case['fields'][0], scenario.sensors['sun'], scenario.sensors['cell']
    in_sensor = Rotation.from_quat(MOUNTING).inv().apply(field['sun_b'])
    assert_allclose(sun.truth(states)[0], in_sensor, rtol=0.0, atol=1e-9)
    days = (case['scenario']['time']['epoch_ns'] * 1e-9 - J2000_UNIX_S) / 86400.0
    g = np.radians(357.528 + 0.9856003 * days)
    of_earth_au = 1.00014 - 0.01671 * np.cos(g) - 0.00014 * np.cos(2.0 * g)
    r_b = Rotation.from_quat(states.q_ib[0]).inv().apply(case['orbit'][0]['r_i'])
    au = of_earth_au - r_b @ field['sun_b'] / AU_M
    expected = field['lit'] * 128_000.0 / au**2 * max(0.0, in_sensor[2])
    found, _ = cell.measure(range(1), states, cell.memory)
    assert_allclose(found.values, [expected], rtol=2e-4)


@pytest.mark.parametrize(('angle_deg', 'sees'), [(29.9, False), (30.1, True)])
def test_the_sun_blinds_a_star_tracker(angle_deg, sees):
    """Nothing is published with the Sun within the half-angle of the boresight."""
    angle = np.radians(angle_deg)
    boresight = looking_at([np.cos(angle), np.sin(angle), 0.0])
    tracker = StarTracker(1, mounting=boresight, sun_exclusion=np.radians(30.0))
    assert len(measured(tracker, flown(4))[0]) == (4 if sees else 0)


@pytest.mark.parametrize(
    ('changes', 'sentence'),
    [
        (
            {'sensors.names': ['sun_sensor']},
            r'sensors\.names has sun_sensor, a sun_sensor, and environment\.sun is none; give',
        ),
        (
            {'sensors.names': ['cell'], 'sensors.cell.type': 'coarse_sun_sensor'},
            r'sensors\.names has cell, a coarse_sun_sensor, and environment\.sun is none; give',
        ),
        (
            {'sensors.names': ['star_tracker'], 'sensors.star_tracker.sun_exclusion': 0.5},
            r'sensors\.star_tracker\.sun_exclusion is 0\.5, and environment\.sun is none; give',
        ),
    ],
)
def test_without_the_sun_they_are_refused(changes, sentence):
    """In one sentence, which names both keys."""
    with pytest.raises(ValueError, match=sentence):
        Scenario(changes)
