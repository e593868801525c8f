"""The C-kernel, its clock and its frame, read by CSPICE."""

import sys

import flights
import numpy as np
import pytest
from exchange.readers import LEAP_SECONDS
from scipy.spatial.transform import Rotation

from satdyn_ros import Scenario
from satdyn_ros.bag.export import Options, export, table
from satdyn_ros.base.nanoseconds import epochs, stamp_ns
from satdyn_ros.exchange.ccsds import Subject
from satdyn_ros.exchange.spice_kernels import CkWriter
from satdyn_ros.run.events import Request

spiceypy = pytest.importorskip('spiceypy')
pytest.importorskip('erfa')

TICKS, RESTART = 150, 60
# SPICE gives instants as doubles of seconds from 2000 on.
RESOLUTION_S = 1.2e-7


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    events = [Request(RESTART, {'initial.angular_velocity': [0.0, 0.1, 0.0]})]
    folder = tmp_path_factory.mktemp('spice')
    return flights.record(folder / 'sat', ticks=TICKS, events=events)


@pytest.fixture
def loaded(tmp_path):
    """Load kernels, and SPICE's leap seconds; all are unloaded after the test."""

    def load(path):
        (tmp_path / 'leap_seconds.tls').write_text(LEAP_SECONDS)
        files = [tmp_path / 'leap_seconds.tls', *(path.with_suffix(s) for s in ('.tsc', '.tf'))]
        for file in (*files, path):
            spiceypy.furnsh(str(file))
        satellite = spiceypy.bodn2c('SAT')
        return satellite, spiceypy.namfrm('SAT_BODY')

    yield load
    spiceypy.kclear()


def assert_right(found, q_ib, allowed=1e-12):
    """Assert that a matrix, inertial to body, is that of a quaternion, body to inertial."""
    right = Rotation.from_quat(q_ib).as_matrix().T
    np.testing.assert_allclose(found, right, rtol=0.0, atol=allowed)


def test_rows_are_at_their_own_ticks(bag, tmp_path, loaded):
    """Attitude and rate by ckgpav with no tolerance, by ckgp without rates: to 1e-12."""
    states = table(bag)
    q_ib = np.stack([states[f'q_ib_{name}'] for name in 'xyzw'], axis=-1)
    omega = np.stack([states[f'omega_bi_b_{name}_rad_s'] for name in 'xyz'], axis=-1)
    for with_rates in (True, False):
        path = tmp_path / f'rates{with_rates}.bc'
        assert export(bag, path, Options(with_rates=with_rates)) == TICKS
        _, axes = loaded(path)
        for row, at_ns in enumerate(states['stamp_ns']):
            tick = float(at_ns - states['stamp_ns'][0])
            if with_rates:
                found, rate, clock = spiceypy.ckgpav(axes, tick, 0.0, 'J2000')
                right = Rotation.from_quat(q_ib[row]).apply(omega[row])
                np.testing.assert_allclose(rate, right, rtol=0.0, atol=1e-15)
            else:
                found, clock = spiceypy.ckgp(axes, tick, 0.0, 'J2000')
            assert clock == tick
            assert_right(found, q_ib[row])
        spiceypy.kclear()


def test_nothing_is_interpolated_across_a_request(bag, tmp_path, loaded):
    """Between rows there is an attitude, but not between the last before it and the first."""
    path = tmp_path / 'sat.bc'
    export(bag, path)
    _, axes = loaded(path)
    between = [(row + 0.5) * 1e9 / 30.0 for row in range(TICKS - 1)]
    found = [row for row, tick in enumerate(between) if has_attitude(axes, tick)]
    assert found == [row for row in range(TICKS - 1) if row != RESTART - 1]


def has_attitude(axes, tick):
    try:
        spiceypy.ckgp(axes, tick, 0.0, 'J2000')
    except spiceypy.exceptions.NotFoundError:
        return False
    return True


def test_an_epoch_finds_the_attitude_by_the_names(bag, tmp_path, loaded):
    """By UTC, clock and frame: as far as an instant of SPICE resolves."""
    states = table(bag)
    path = tmp_path / 'sat.bc'
    export(bag, path, Options(with_rates=True))
    satellite, _ = loaded(path)
    for row in (1, 40, 110, 148):
        (text,) = epochs(states['stamp_ns'][row : row + 1])
        at = spiceypy.utc2et(text)
        tick = states['stamp_ns'][row] - states['stamp_ns'][0]
        assert abs(spiceypy.sce2c(satellite, at) - tick) < RESOLUTION_S * 1e9
        q_ib = [states[f'q_ib_{name}'][row] for name in 'xyzw']
        assert_right(spiceypy.pxform('J2000', 'SAT_BODY', at), q_ib, 0.2 * RESOLUTION_S)
    assert spiceypy.scs2e(satellite, '1/0000000001.000000000') == pytest.approx(
        spiceypy.utc2et(epochs(states['stamp_ns'][30:31])[0]), abs=RESOLUTION_S
    )


def test_rows_of_several_writes_join(tmp_path, loaded):
    """As those of one: a bag is read in blocks."""
    motion = Scenario.from_dict({'initial': {'angular_velocity': [0.01, -0.02, 0.03]}}).motion()
    states = motion.at(np.arange(9.0))
    stamps_ns = 10**18 + 10**9 * np.arange(9)
    writer = CkWriter(tmp_path / 'sat.bc', Subject('SAT'))
    for rows in (slice(0, 4), slice(4, 5), slice(5, 9)):
        writer.write(stamps_ns[rows], states.q_ib[rows], states.omega_bi_b[rows])
    writer.close()
    (tmp_path / 'sat.tsc').write_text(writer.clock_kernel)
    (tmp_path / 'sat.tf').write_text(writer.frame_kernel)
    _, axes = loaded(tmp_path / 'sat.bc')
    for t_s in np.arange(0.0, 8.1, 0.5):
        found, _ = spiceypy.ckgp(axes, t_s * 1e9, 0.0, 'J2000')
        # Where the rate changes by 3e-4 rad/s in a second, a steady turn misses an eighth of it.
        assert_right(found, motion.at(np.array([t_s])).q_ib[0], 4e-5 if t_s % 1.0 else 1e-12)


def test_the_clock_knows_the_leap_second(tmp_path, loaded):
    """Which stamps do not count: beyond it an epoch is still at its own stamp."""
    begin_ns = stamp_ns('2016-12-31T23:59:58')
    stamps_ns = begin_ns + 10**9 * np.arange(5)
    writer = CkWriter(tmp_path / 'sat.bc', Subject('SAT'))
    writer.write(stamps_ns, np.tile([0.0, 0.0, 0.0, 1.0], (5, 1)), np.zeros((5, 3)))
    writer.close()
    (tmp_path / 'sat.tsc').write_text(writer.clock_kernel)
    (tmp_path / 'sat.tf').write_text(writer.frame_kernel)
    satellite, _ = loaded(tmp_path / 'sat.bc')
    for row, text in enumerate(epochs(stamps_ns)):
        assert spiceypy.sce2c(satellite, spiceypy.utc2et(text)) == pytest.approx(
            1e9 * row, abs=1e9 * RESOLUTION_S
        )


def test_two_satellites_have_numbers_of_their_own(bag, tmp_path):
    """And long names are cut to what SPICE takes."""
    one, other = (CkWriter(tmp_path / 'x.bc', Subject('SAT' * n)) for n in (1, 20))
    assert 'NAIF_BODY_CODE' in one.frame_kernel
    assert one.frame_kernel.split('CODE')[1][:16] != other.frame_kernel.split('CODE')[1][:16]
    assert max(map(len, other.frame_kernel.splitlines())) < 132


def test_what_spice_refuses_is_one_sentence(bag, tmp_path, monkeypatch):
    """No file is left; and who has not the extra is given its name."""
    far = tmp_path / ('d' * 200) / ('e' * 60)
    far.mkdir(parents=True)
    with pytest.raises(ValueError, match=r'^the path /.* has .* SPICE writes no file beyond 255$'):
        export(bag, far / 'sat.bc')
    assert list(far.iterdir()) == []
    with pytest.raises(FileNotFoundError):
        export(bag, tmp_path / 'nowhere' / 'sat.bc')
    with pytest.raises(ValueError, match=r'^--frame is for \.aem and'):
        export(bag, tmp_path / 'sat.bc', Options(frame='GCRF'))
    monkeypatch.setitem(sys.modules, 'spiceypy', None)
    with pytest.raises(ValueError, match='needs spiceypy, which the extra `spice` brings'):
        export(bag, tmp_path / 'sat.bc')
    assert list(tmp_path.glob('sat*')) == []
