"""The elliptic kit against mpmath, which computes with hundreds of digits."""

import mpmath as mp
import numpy as np
import pytest

from satdyn_ros.exact import elliptic

EPS = np.finfo(float).eps
# from the circle over the whole range to a separatrix closer than a double's 1 - m can resolve
M1 = [1.0, 0.7, 0.1, 1e-3, 1e-8, 1e-12, 1e-20, 1e-100]


@pytest.fixture(autouse=True)
def digits():
    """Work with enough digits for m = 1 - 1e-100."""
    with mp.workdps(130):
        yield


def true_K(m1):
    return mp.ellipk(1 - mp.mpf(m1))


def arguments(m1, periods):
    """Return times within and over many periods, and the places where signs turn."""
    rng = np.random.default_rng(7)
    quarter = float(true_K(m1))
    special = np.array([0.0, 1e-150, 1e-9, quarter, -quarter, 0.999999 * quarter, 3 * quarter])
    return np.concatenate([rng.uniform(-periods, periods, 12) * quarter, special])


def true_sncndn_am(u, m1):
    u, m, quarter = mp.mpf(u), 1 - mp.mpf(m1), true_K(m1)
    j = mp.nint(u / (2 * quarter))
    sign = -1 if int(j) % 2 else 1
    s, c, d = (mp.ellipfun(name, u - 2 * quarter * j, m=m) for name in ('sn', 'cn', 'dn'))
    return sign * s, sign * c, d, mp.atan2(s, c) + j * mp.pi


@pytest.mark.parametrize('m1', M1)
@pytest.mark.parametrize('periods', [1, 1000])
def test_sn_cn_dn_and_am_are_true_to_rounding(m1, periods):
    """
    Proves sn, cn, dn and am for every m1, far beyond where scipy.special.ellipj breaks down.

    Rounding u alone moves them by |u| eps; am has the derivative dn <= 1 but is itself rounded,
    and folding multiplies the rounding of K by the number of periods.
    """
    u = arguments(m1, periods)
    got = np.stack([*elliptic.sncndn(u, m1), elliptic.amplitude(u, m1)], axis=-1)
    for row, ui in zip(got, u, strict=True):
        for value, truth in zip(row, true_sncndn_am(float(ui), m1), strict=True):
            assert abs(value - truth) <= 2 * EPS * (1.0 + abs(ui) + abs(truth))


@pytest.mark.parametrize('m1', M1)
def test_small_cn_and_dn_keep_their_relative_accuracy(m1):
    """Proves that cn and dn, tiny near a separatrix, are not differences of large numbers."""
    u = np.linspace(-0.8, 0.8, 9) * float(true_K(m1))
    _, cn, dn = elliptic.sncndn(u, m1)
    for ui, ci, di in zip(u, cn, dn, strict=True):
        _, c, d, _ = true_sncndn_am(float(ui), m1)
        assert abs(ci / c - 1) <= 4 * EPS * (1 + abs(ui))
        assert abs(di / d - 1) <= 4 * EPS * (1 + abs(ui))


def test_on_the_separatrix_they_are_hyperbolic():
    """Proves m1 = 0 with times far beyond where cosh overflows."""
    u = np.array([0.0, 0.3, -2.0, 30.0, 400.0, -5000.0])
    sn, cn, dn = elliptic.sncndn(u, 0.0)
    for i, ui in enumerate(u):
        assert abs(sn[i] - mp.tanh(ui)) <= EPS
        assert abs(cn[i] - mp.sech(ui)) <= 4 * EPS * mp.sech(ui) * (1 + abs(ui)) + 1e-300
        assert dn[i] == cn[i]
        assert abs(elliptic.amplitude(ui, 0.0) - 2 * mp.atan(mp.tanh(ui / 2))) <= 2 * EPS
    assert elliptic.K(0.0) == np.inf


@pytest.mark.parametrize('m1', [*M1, 1e-300])
def test_quarter_period(m1):
    """Proves K for every m1."""
    with mp.workdps(330):
        assert abs(elliptic.K(m1) / true_K(m1) - 1) <= 4 * EPS


@pytest.mark.parametrize('m1', [*M1[:-1], 0.0])
def test_first_integral_from_an_angle(m1):
    """Proves F over many half turns; phi rounded moves it by phi eps / dn."""
    turns = 0 if m1 == 0.0 else 5
    for phi in np.array([0.0, 1e-9, 0.7, -1.2, 1.5]) + turns * np.pi:
        truth = mp.ellipf(mp.mpf(float(phi)), 1 - mp.mpf(m1))
        slope = 1 / mp.sqrt(mp.mpf(m1) + (1 - mp.mpf(m1)) * mp.cos(float(phi)) ** 2)
        assert abs(elliptic.F(phi, m1) - truth) <= 8 * EPS * (abs(truth) + abs(phi) * slope)


@pytest.mark.parametrize('m1', [*M1, 0.0])
def test_first_integral_inverts_sn_cn_dn(m1):
    """Proves that the phase comes back from sn, cn and dn, also next to K."""
    quarter = 20.0 if m1 == 0.0 else float(elliptic.K(m1))
    u = np.linspace(-0.999, 0.999, 41) * quarter
    sn, cn, dn = elliptic.sncndn(u, m1)
    np.testing.assert_allclose(elliptic.F_sncndn(sn, cn, dn), u, rtol=0, atol=1e-14 * quarter)


@pytest.mark.parametrize('m1', [1.0, 0.7, 0.1, 1e-3, 1e-8, 1e-12, 1e-20])
@pytest.mark.parametrize('nn', [-1e6, -3.0, -1e-9, 0.0, 0.4, 0.99])
def test_third_integral(m1, nn):
    """
    Proves L against Legendre's integrals, over several periods.

    Its slope sn^2 / (1 - nn sn^2) is at most 1 / (1 - nn): what rounding u and K can do.
    """
    m, nn_, quarter = 1 - mp.mpf(m1), mp.mpf(nn), true_K(m1)

    def first_half_turn(ur):
        sn, cn, _, am = true_sncndn_am(ur, m1)
        if nn:
            return (mp.ellippi(nn_, am, m) - ur) / nn_
        return (ur - mp.ellipe(am, m)) / m if m else (ur - sn * cn) / 2

    for u in np.array([1e-3, 0.3, -0.9, 0.999, 2.4, 9.3]) * float(quarter):
        j = mp.nint(mp.mpf(float(u)) / (2 * quarter))
        truth = first_half_turn(u - 2 * quarter * j) + 2 * j * first_half_turn(quarter)
        slope = 1 / (1 - nn)
        assert abs(elliptic.L(u, nn, m1) - truth) <= 8 * EPS * (abs(truth) + abs(u) * slope)


@pytest.mark.parametrize('nn', [-2.0, 0.4])
def test_third_integral_on_the_separatrix(nn):
    """Proves L at m1 = 0, where it grows without bound, against its elementary form."""
    root = mp.sqrt(mp.mpf(-nn)) if nn < 0 else mp.sqrt(mp.mpf(nn))
    arc = mp.atan if nn < 0 else mp.atanh
    for u in [0.0, 1e-3, 1.0, 39.0, 41.0, 1000.0]:
        truth = (mp.mpf(u) - arc(root * mp.tanh(u)) / root) / (1 - mp.mpf(nn))
        assert abs(elliptic.L(u, nn, 0.0) - truth) <= 4 * EPS * max(abs(truth), u)


def test_parameters_broadcast_with_arguments():
    """Proves that a row of m1 against a column of u gives what each pair gives alone."""
    m1, u = np.array([0.0, 1e-12, 0.5, 1.0]), np.array([[0.3], [-7.0]])
    for function in (elliptic.amplitude, elliptic.F, lambda u, m1: elliptic.L(u, -0.5, m1)):
        if function is elliptic.F:
            u = np.array([[0.3], [-1.5]])
        table = function(u, m1)
        alone = [[function(float(ui), float(mi)) for mi in m1] for ui in u[:, 0]]
        np.testing.assert_allclose(table, alone, rtol=4 * EPS, atol=0)
