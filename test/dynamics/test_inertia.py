import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from satdyn_ros.base.sentences import refuse
from satdyn_ros.dynamics import bodies, inertia

MOMENTS = ([600.0, 800.0, 900.0], [900.0, 600.0, 800.0], [1.0, 1.0, 2.0], [2.0, 1.0, 2.0])


@pytest.mark.parametrize(
    'values',
    [
        [600, 800, 900],
        [600, 800, 900, 1.5, -2.5, 3.5],
        [600, 1.5, -2.5, 1.5, 800, 3.5, -2.5, 3.5, 900],
    ],
)
def test_three_six_and_nine_numbers_mean_the_tensor_they_say(values):
    """Moments, the six entries and the rows name the same matrix, products signed as in it."""
    I = inertia.entries(values)
    assert list(np.diagonal(I)) == [600.0, 800.0, 900.0]
    if len(values) > 3:
        assert (I[0, 1], I[0, 2], I[1, 2]) == (1.5, -2.5, 3.5)
    assert np.array_equal(I, I.T)


@pytest.mark.parametrize(
    ('values', 'why'),
    [
        ([1, 1, 0], 'must be positive'),
        ([1, 1, 1, 2, 0, 0], 'must be positive'),
        ([1, 2, 8], 'must not exceed the sum'),
        ([3, 3, 3, 2.9, 0, 0], 'must not exceed the sum'),
        ([3, 1, 0, 0, 3, 0, 0, 0, 3], 'must be symmetric'),
    ],
)
def test_what_no_body_has_is_refused_in_one_sentence(values, why):
    """Symmetry, positivity and the triangle inequality are each demanded."""
    with pytest.raises(ValueError, match=why) as refusal:
        refuse(inertia.checks(values))
    assert str(refusal.value).startswith('body.inertia is [')
    assert '\n' not in str(refusal.value)


@pytest.mark.parametrize('seed', range(20))
def test_a_flat_body_passes_the_triangle_inequality_in_any_axes(seed):
    """A plate has I3 = I1 + I2 exactly; rounding of a rotated tensor must not refuse it."""
    R = Rotation.random(random_state=seed).as_matrix()
    plate = bodies.rectangular_plate(3.0, 0.7, 1.1)
    refuse(inertia.checks(np.ravel(R @ plate @ R.T)))


@pytest.mark.parametrize('moments', [*MOMENTS, [1.0, 1.0, 1.0]])
def test_a_diagonal_tensor_keeps_its_axes_exactly(moments):
    """Whoever gives principal axes gets them back: the identity, bit for bit."""
    found, R = inertia.principal_axes(np.diag(moments))
    assert np.array_equal(found, moments)
    assert np.array_equal(R, np.eye(3))


@pytest.mark.parametrize('moments', [*MOMENTS, [1.0, 1.0 + 1e-9, 2.0], [1.0, 1.0, 1.0]])
@given(turn=arrays(float, 3, elements=st.floats(-3.0, 3.0)))
def test_principal_axes_diagonalise_and_turn_least(moments, turn):
    """
    R diag(moments) R^T gives the tensor back; no other labelling of the axes turns less.

    Tolerance: two products of 3 x 3 matrices, and 1e-13 for moments taken as equal.
    """
    Q = Rotation.from_rotvec(turn).as_matrix()
    I = Q @ np.diag(moments) @ Q.T
    I = (I + I.T) / 2.0
    found, R = inertia.principal_axes(I)
    assert R @ np.diag(found) @ R.T == pytest.approx(I, abs=3e-13 * max(moments))
    np.testing.assert_allclose(R.T @ R, np.eye(3), rtol=0.0, atol=1e-14)
    assert np.linalg.det(R) == pytest.approx(1.0, abs=1e-14)
    for relabel in Rotation.create_group('O').as_matrix():
        assert np.trace(R @ relabel) <= np.trace(R) + 1e-12


@given(angle=st.floats(-0.7, 0.7))
def test_equal_moments_keep_the_pair_closest_to_the_body_axes(angle):
    """Tilting a symmetry axis by an angle turns the principal axes by that angle and no more."""
    tilt = Rotation.from_euler('x', angle)
    I = tilt.as_matrix() @ np.diag([2.0, 2.0, 1.0]) @ tilt.as_matrix().T
    moments, R = inertia.principal_axes(I)
    np.testing.assert_allclose(R, tilt.as_matrix(), rtol=0.0, atol=1e-12)
    assert moments[0] == moments[1]


def brute_force(density_points):
    """Return the inertia and mean of equally heavy points (N, 3) of total mass 1."""
    r = density_points - density_points.mean(axis=0)
    square = np.einsum('ni,nj->ij', r, r) / len(r)
    return np.trace(square) * np.eye(3) - square


def _grid(*lengths, n=120):
    """Return the midpoints of n^3 (n^2, n) cells of a box about the origin."""
    sides = [length * ((np.arange(n) + 0.5) / n - 0.5) for length in lengths]
    return np.stack([axis.ravel() for axis in np.meshgrid(*sides, indexing='ij')], axis=-1)


def _flat(points):
    return np.column_stack([points, np.zeros(len(points))])


def _within(points, radius):
    return points[np.hypot(points[:, 0], points[:, 1]) <= radius]


def _cone_points():
    box = _grid(2.0, 2.0, 1.5)
    return box[np.hypot(box[:, 0], box[:, 1]) <= (0.75 - box[:, 2]) / 1.5]


ANGLES = 2.0 * np.pi * np.arange(100) / 100
SOLIDS = {
    'rod': (bodies.rod(1.0, 1.7), np.column_stack([np.zeros((5000, 2)), _grid(1.7, n=5000)])),
    'ring': (
        bodies.ring(1.0, 1.3),
        1.3 * np.stack([np.cos(ANGLES), np.sin(ANGLES), 0.0 * ANGLES], axis=-1),
    ),
    'disk': (bodies.disk(1.0, 1.0), _flat(_within(_grid(2.0, 2.0, n=1000), 1.0))),
    'annulus': (
        bodies.annulus(1.0, 0.4, 1.0),
        _flat([p for p in _within(_grid(2.0, 2.0, n=400), 1.0) if np.hypot(*p) >= 0.4]),
    ),
    'cylinder': (bodies.cylinder(1.0, 1.0, 1.5), _within(_grid(2.0, 2.0, 1.5), 1.0)),
    'sphere': (
        bodies.sphere(1.0, 1.0),
        np.array([p for p in _grid(2.0, 2.0, 2.0, n=60) if p @ p <= 1.0]),
    ),
    'plate': (bodies.rectangular_plate(1.0, 0.7, 1.9), _flat(_grid(0.7, 1.9, n=1000))),
    'cone': (bodies.cone(1.0, 1.0, 1.5), _cone_points()),
}


@pytest.mark.parametrize('solid', SOLIDS)
def test_the_catalogue_agrees_with_sums_over_points(solid):
    """
    Each formula equals the sum over a fine lattice of equal masses.

    Tolerance: the lattice's jagged rim, below 3e-3 of the largest moment.
    """
    formula, lattice = SOLIDS[solid]
    assert brute_force(np.asarray(lattice)) == pytest.approx(formula, abs=3e-3 * np.max(formula))


def test_points_are_the_definition():
    """Two points of mass m at distance d have m d^2 / 2 across and nothing along (42)."""
    assert bodies.points([3.0, 3.0], [[0, 0, 1], [0, 0, 3]]) == pytest.approx(
        np.diag([6.0, 6.0, 0.0])
    )


@pytest.mark.parametrize(
    ('body', 'offset', 'axis', 'moment'),
    [
        (bodies.rod(2.0, 3.0), [0, 0, 1.5], 0, 2.0 * 3.0**2 / 3),
        (bodies.sphere(2.0, 3.0), [3.0, 0, 0], 2, 7 * 2.0 * 3.0**2 / 5),
        (bodies.cylinder(2.0, 3.0, 5.0), [0, 0, 2.5], 0, 2.0 * (5.0**2 / 3 + 3.0**2 / 4)),
        (bodies.cone(2.0, 3.0, 5.0), [0, 0, 3.75], 0, 3 * 2.0 * (5.0**2 / 5 + 3.0**2 / 20)),
    ],
)
def test_parallel_axis_gives_the_textbook_moments(body, offset, axis, moment):
    """Rod about its end, sphere about a tangent, cylinder and cone about base and apex (42)."""
    at_point = inertia.parallel_axis(body, 2.0, offset)
    assert at_point[axis, axis] == pytest.approx(moment, rel=1e-14)


def test_parallel_axis_has_the_products_of_an_oblique_offset():
    """The tensor form carries products of inertia: a point mass at (1, 2, 3)."""
    expected = [[13.0, -2.0, -3.0], [-2.0, 10.0, -6.0], [-3.0, -6.0, 5.0]]
    assert inertia.parallel_axis(np.zeros((3, 3)), 1.0, [1, 2, 3]) == pytest.approx(
        np.array(expected)
    )


def test_two_halves_make_the_whole():
    """Two half cylinders stacked along z compose into the whole one."""
    half = bodies.cylinder(1.0, 0.5, 2.0)
    centres = np.array([[0.1, 0.2, -1.0], [0.1, 0.2, 1.0]])
    whole = bodies.compose([bodies.Body(1.0, centre, half) for centre in centres])
    assert whole.mass == 2.0
    assert whole.mass_centre == pytest.approx([0.1, 0.2, 0.0])
    assert whole.inertia == pytest.approx(bodies.cylinder(2.0, 0.5, 4.0), rel=1e-14)


def test_the_inertia_ellipsoid_touches_where_the_quadratic_form_is_one():
    """The tip of each semi-axis satisfies x . I x = 1; a rod's ellipsoid is a cylinder."""
    R = Rotation.from_rotvec([0.3, -0.2, 0.5]).as_matrix()
    I = R @ np.diag([2.0, 3.0, 4.0]) @ R.T
    tips = inertia.principal_axes(I)[1] * inertia.ellipsoid(I)
    assert tips.T @ I @ tips == pytest.approx(np.eye(3), abs=1e-13)
    assert inertia.ellipsoid(bodies.rod(12.0, 1.0)) == pytest.approx([1.0, 1.0, np.inf])


def test_the_moment_about_any_axis_is_the_sum_over_the_masses():
    """(42.16) with Steiner's theorem: sum m r^2, r the distance from a line in space."""
    random = np.random.default_rng(3)
    masses, positions = random.uniform(0.5, 2.0, 6), random.normal(size=(6, 3))
    I, centre = bodies.points(masses, positions), masses @ positions / np.sum(masses)
    through, axis = random.normal(size=3), random.normal(size=3)
    r = np.linalg.norm(np.cross(positions - through, axis / np.linalg.norm(axis)), axis=-1)
    moment = inertia.moment_about(I, axis, np.sum(masses), through - centre)
    assert moment == pytest.approx(masses @ r**2, rel=1e-13)


@pytest.mark.parametrize(
    ('shape', 'through', 'axis', 'expected'),
    [
        # exercises 15, 17 and 20, with m = 2, r = 0.5, h = 1.2
        (bodies.cylinder(2.0, 0.5, 1.2), [0, 0, 0.6], [1, 0, 0], 2.0 * (1.44 / 3 + 0.25 / 4)),
        (bodies.sphere(2.0, 0.5), [0, 0.5, 0], [1, 0, 0], 1.4 * 2.0 * 0.25),
        (bodies.cone(2.0, 0.5, 1.2), [0, 0, 0.9], [0, 1, 0], 6.0 * (1.44 / 5 + 0.25 / 20)),
    ],
)
def test_moments_of_the_exercises(shape, through, axis, expected):
    """The base's diameter of a cylinder, a sphere's tangent, across a cone's axis at the apex."""
    assert inertia.moment_about(shape, axis, 2.0, through) == pytest.approx(expected, rel=1e-14)


def test_the_tensor_in_space_gives_the_momentum_in_space():
    """R I R^T omega_space is the momentum turned into space, for a table of attitudes."""
    I = np.diag([1.0, 2.0, 2.5])
    q = Rotation.random(5, random_state=2).as_quat()
    omega = np.random.default_rng(4).normal(size=(5, 3))
    in_space = inertia.in_space(I, q)
    R = Rotation.from_quat(q)
    momenta = np.einsum('nij,nj->ni', in_space, R.apply(omega))
    np.testing.assert_allclose(momenta, R.apply(omega @ I), atol=1e-14)


def turned_copies(n, axis, positions):
    """Return the positions (M n, 3) with their turns by 2 pi / n about an axis."""
    turns = [Rotation.from_rotvec(2.0 * np.pi * k / n * np.asarray(axis)) for k in range(n)]
    return np.concatenate([turn.apply(positions) for turn in turns])


AXIS = np.array([0.36, 0.48, 0.8])


@pytest.mark.parametrize('n', [2, 3, 4, 5, 7])
def test_an_axis_of_symmetry_is_principal(n):
    """42.22, exercises 3 and 4: of order 2 principal; of order n > 2 one of rotation as well."""
    positions = turned_copies(n, AXIS, np.random.default_rng(n).normal(size=(3, 3)))
    I = bodies.points(np.ones(len(positions)), positions)
    assert np.linalg.norm(np.cross(AXIS, I @ AXIS)) < 1e-13 * np.max(I)
    moments = np.linalg.eigvalsh(I - (AXIS @ I @ AXIS) * np.outer(AXIS, AXIS))
    across = np.sort(np.abs(moments))[1:]
    if n > 2:
        assert across[0] == pytest.approx(across[1], rel=1e-13)
    else:
        assert across[1] - across[0] > 0.1


@pytest.mark.parametrize(
    ('orders', 'angle'),
    # two axes of order n > 2 (exercise 5); one of them of order 2 and askew (exercise 6): the
    # groups of the tetrahedron and of the cube
    [((3, 3), np.arccos(-1.0 / 3.0)), ((4, 4), np.pi / 2.0), ((3, 2), np.arccos(3.0**-0.5))],
)
def test_two_axes_of_symmetry_make_a_sphere(orders, angle):
    """Exercises 5 and 6: positions closed under the turns about both axes have one moment."""
    second = np.array([np.sin(angle), 0.0, np.cos(angle)])
    group = [np.eye(3)]
    generators = [
        Rotation.from_rotvec(2.0 * np.pi / n * axis).as_matrix()
        for n, axis in zip(orders, (np.array([0.0, 0.0, 1.0]), second), strict=True)
    ]
    for element in group:
        for generator in generators:
            image = generator @ element
            if min(np.max(np.abs(image - other)) for other in group) > 1e-9:
                group.append(image)
        assert len(group) <= 24
    position = np.array([0.3, -1.1, 0.7])
    positions = np.array([element @ position for element in group])
    moments = np.linalg.eigvalsh(bodies.points(np.ones(len(group)), positions))
    np.testing.assert_allclose(moments, np.mean(moments), rtol=1e-13)


@pytest.mark.parametrize('moments', [(1.0, 2.0, 2.5), (2.0, 2.0, 1.0)])
def test_symmetry_axes_of_one_body_and_many_vectors(moments):
    """One axis for each vector, or none, as if they came one by one."""
    vectors = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 3.0], [1.0, 0.0, 0.0]])
    I = np.diag(moments)
    found = inertia.symmetry_axes((I, I), (vectors, np.zeros(3)))
    one_by_one = [inertia.symmetry_axes((I, I), (v, np.zeros(3))) for v in vectors]
    np.testing.assert_array_equal(found, one_by_one)


def test_points_about_any_point():
    """The sum of m (x . x 1 - x x^T) from the point, and by default from the mass centre."""
    masses = np.array([1.0, 2.0, 0.5])
    positions = np.array([[1.0, 0.0, 0.2], [0.0, -1.0, 0.4], [0.3, 0.3, -2.0]])
    centre = masses @ positions / np.sum(masses)
    for about in (np.zeros(3), np.array([1.0, -2.0, 0.5]), centre):
        from_it = positions - about
        expected = sum(
            m * (x @ x * np.eye(3) - np.outer(x, x)) for m, x in zip(masses, from_it, strict=True)
        )
        np.testing.assert_allclose(bodies.points(masses, positions, about), expected, rtol=1e-12)
    np.testing.assert_allclose(
        bodies.points(masses, positions), bodies.points(masses, positions, centre), rtol=1e-12
    )


def test_the_normal_of_the_ellipsoid():
    """It is square to the ellipsoid's surface: to differences of near points on it."""
    body = np.array([[3.0, 0.2, -0.1], [0.2, 2.0, 0.3], [-0.1, 0.3, 2.5]])
    omega = np.array([0.4, -0.7, 0.9])

    def on_it(direction):
        return direction / np.sqrt(direction @ body @ direction)

    normal = inertia.ellipsoid_normal(body, omega)
    for k in range(3):
        step = 1e-6 * np.eye(3)[k]
        along = on_it(omega + step) - on_it(omega - step)
        assert normal @ along == pytest.approx(0.0, abs=1e-15)
    assert normal @ omega > 0.0


def test_a_refusal_of_a_rod_says_what_to_use():
    """A moment of zero is refused by a sentence that names the way out."""
    with pytest.raises(ValueError, match='use the moments of a cylinder'):
        refuse(inertia.checks(np.ravel(bodies.rod(2.0, 3.0))))
