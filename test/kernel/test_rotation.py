from functools import partial

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from satdyn_ros.kernel import rotation

close = partial(assert_allclose, rtol=0.0)

# Products and norms of four numbers of order one.
ROUNDING = 1e-15

vectors = arrays(float, 3, elements=st.floats(-10.0, 10.0))
angles = st.floats(-6.0, 6.0)


@st.composite
def attitudes(draw):
    """Draw unit quaternions, those with zeros among them."""
    q = draw(arrays(float, 4, elements=st.floats(-1.0, 1.0)))
    assume(np.linalg.norm(q) > 1e-3)
    return rotation.normalise(q)


def test_i_times_j_is_k():
    """The product is Hamilton's: i j = k, and not JPL's i j = -k."""
    i, j, k = np.eye(4)[:3]
    close(rotation.multiply(i, j), k)
    close(rotation.multiply(j, i), -k)
    for unit in (i, j, k):
        close(rotation.multiply(unit, unit), -rotation.IDENTITY)


def test_a_quarter_turn_about_z_brings_body_x_to_inertial_y():
    """The attitude is active from body to inertial: v_i = q_ib v_b q_ib*."""
    q_ib = np.array([0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5)])
    close(rotation.rotate(q_ib, [1, 0, 0]), [0, 1, 0], atol=ROUNDING)
    close(rotation.matrix(q_ib) @ [1, 0, 0], [0, 1, 0], atol=ROUNDING)


@given(q=attitudes(), v=vectors)
def test_rotate_is_the_sandwich_product(q, v):
    """rotate(q, v) = q v q*, computed with the product alone."""
    sandwich = rotation.multiply(rotation.multiply(q, [*v, 0.0]), rotation.conjugate(q))
    close(rotation.rotate(q, v), sandwich[:3], atol=40 * ROUNDING)
    assert sandwich[3] == pytest.approx(0.0, abs=40 * ROUNDING)


@given(q=attitudes(), p=attitudes(), v=vectors)
def test_agreement_with_scipy(q, p, v):
    """Product, rotation and matrix are those of scipy.spatial.transform.Rotation."""
    Rq, Rp = Rotation.from_quat(q), Rotation.from_quat(p)
    close(rotation.matrix(q), Rq.as_matrix(), atol=4 * ROUNDING)
    close(rotation.rotate(q, v), Rq.apply(v), atol=40 * ROUNDING)
    product = rotation.multiply(q, p)
    assert abs(product @ (Rq * Rp).as_quat()) == pytest.approx(1.0, abs=4 * ROUNDING)
    # A half-angle near 0 or pi is known to the square root of rounding from a cosine, so compare
    # sines.
    angle = (Rq.inv() * Rp).magnitude()
    assert rotation.angle_between(q, p) == pytest.approx(angle, abs=1e-14)


@given(q=attitudes())
def test_matrix_round_trip(q):
    """The quaternion of the matrix of q is q or -q, also where w or others vanish."""
    back = rotation.from_matrix(rotation.matrix(q))
    close(back * np.sign(back @ q), q, atol=4 * ROUNDING)


@pytest.mark.parametrize('axis', np.eye(3))
@pytest.mark.parametrize('angle', [0.0, 1e-9, np.pi / 2, np.pi, 1.5 * np.pi])
def test_matrix_round_trip_of_half_turns(axis, angle):
    """Half turns, where w = 0, and turns of 1e-9 keep full precision."""
    q = rotation.about(axis, angle)
    back = rotation.from_matrix(rotation.matrix(q))
    close(back * np.sign(back @ q), q, atol=4 * ROUNDING)


@given(axis=vectors, angle=angles)
def test_about_is_the_rotation_vector(axis, angle):
    """The half-angle formula turns by the angle, right-handed, as scipy's rotation vector."""
    assume(np.linalg.norm(axis) > 1e-3)
    axis = axis / np.linalg.norm(axis)
    close(
        rotation.matrix(rotation.about(axis, angle)),
        Rotation.from_rotvec(angle * axis).as_matrix(),
        atol=10 * ROUNDING,
    )


@given(q=attitudes())
def test_roll_pitch_yaw_is_scipys_intrinsic_zyx(q):
    """The angles rebuild the attitude, and are scipy's away from the pitch of +-90 deg."""
    roll, pitch, yaw = rotation.roll_pitch_yaw(q)
    back = rotation.from_roll_pitch_yaw(roll, pitch, yaw)
    # Within 1e-12 of the pole the roll is set to 0.
    assert rotation.angle_between(q, back) < 1e-11
    assert np.max(np.abs([roll, pitch, yaw])) <= np.pi + ROUNDING
    if np.cos(pitch) > 1e-3:
        expected = Rotation.from_quat(q).as_euler('ZYX')[::-1]
        difference = np.array([roll, pitch, yaw]) - expected
        close(np.sin(difference / 2.0), 0.0, atol=1e-12)


@pytest.mark.parametrize('sign', [1.0, -1.0])
def test_roll_is_zero_at_the_pole(sign):
    """At a pitch of +-90 deg all of the turn is yaw."""
    q = rotation.from_roll_pitch_yaw(0.2, sign * np.pi / 2, 0.5)
    close(rotation.roll_pitch_yaw(q), [0.0, sign * np.pi / 2, 0.5 - sign * 0.2], atol=1e-7)


def test_continuous_keeps_the_rotation_and_never_jumps():
    """A turn of two revolutions with scrambled signs comes back without sign changes."""
    turn = rotation.about([0.6, 0.0, 0.8], np.linspace(0.0, 4.0 * np.pi, 50))
    scrambled = turn * np.where(np.arange(50) % 3 == 1, -1.0, 1.0)[:, None]
    close(rotation.continuous(scrambled), turn)


@given(q=attitudes())
def test_arrays_give_what_single_quaternions_give(q):
    """Every function works on the last axis of a table."""
    table = np.stack([q, rotation.IDENTITY])
    for function in (rotation.matrix, rotation.conjugate, rotation.roll_pitch_yaw):
        assert np.array_equal(function(table)[0], function(q))
    assert np.array_equal(rotation.multiply(table, q)[0], rotation.multiply(q, q))
    assert np.array_equal(
        rotation.from_matrix(rotation.matrix(table))[0], rotation.from_matrix(rotation.matrix(q))
    )


@given(arrays(float, 3, elements=st.floats(-np.pi / 2.0, np.pi / 2.0)))
def test_rotation_vectors_are_those_of_scipy(vector):
    """To and from the vector of a rotation, by another's program, small ones among them."""
    for v in (vector, vector * 1e-9, vector * 0.0):
        q = rotation.from_vector(v)
        close(q, Rotation.from_rotvec(v).as_quat(), atol=ROUNDING)
        close(rotation.to_vector(q), v, atol=4.0 * ROUNDING)
        close(rotation.to_vector(-q), v, atol=4.0 * ROUNDING)


MANY = 10_000


def tables():
    """Return tables of quaternions and vectors of every layout, with rows enough for many."""
    rng = np.random.default_rng(1)
    rows = MANY
    q, v = rng.normal(size=(rows, 4)), rng.normal(size=(rows, 3))
    side_by_side = rotation.from_components(rng.normal(size=(4, 30, rows // 10)))
    return [
        (q, v),
        (q, v[0]),
        (q[0], v),
        (side_by_side, v[: rows // 10]),
        (side_by_side[:, ::2], rng.normal(size=(30, 1, 3))),
        (side_by_side.reshape(3, 10, -1, 4), v[: rows // 10]),
    ]


@pytest.mark.parametrize(('q', 'v'), tables())
def test_many_rows_are_as_one_by_one(q, v):
    """A row has the same bits alone and among many."""
    for product, b in (
        (rotation.rotate, v),
        (rotation.multiply, np.concatenate([v, v[..., :1]], axis=-1)),
    ):
        many = product(q, b)
        rows = (
            np.broadcast_to(q, (*many.shape[:-1], 4)),
            np.broadcast_to(b, (*many.shape[:-1], b.shape[-1])),
        )
        assert max(q.size, b.size) >= MANY
        for i in range(0, len(many.reshape(-1, many.shape[-1])), 997):
            at = np.unravel_index(i, many.shape[:-1])
            np.testing.assert_array_equal(many[at], product(rows[0][at], rows[1][at]))
