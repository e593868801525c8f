"""Vectors and quaternions as tuples of floats, of symbols, or of columns of NumPy."""

from typing import Any

Vector = tuple[Any, ...]


def add(a: Vector, b: Vector) -> Vector:
    """Return a + b."""
    return tuple(x + y for x, y in zip(a, b, strict=True))


def subtract(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return tuple(x - y for x, y in zip(a, b, strict=True))


def scale(s: Any, a: Vector) -> Vector:
    """Return s a."""
    return tuple(s * x for x in a)


def dot(a: Vector, b: Vector) -> Any:
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Return a x b."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def apply(M: tuple[Any, ...], a: Vector) -> Vector:
    """Return M a for a matrix of three row tuples, or of the three numbers of its diagonal."""
    return tuple(
        dot(row, a) if isinstance(row, tuple) else row * x for row, x in zip(M, a, strict=True)
    )


def product(q: Vector, p: Vector) -> Vector:
    """Return the Hamilton product q p; i j = k."""
    x1, y1, z1, w1 = q
    x2, y2, z2, w2 = p
    return (
        w1 * x2 + x1 * w2 + y1 * z2 - z1 * y2,
        w1 * y2 - x1 * z2 + y1 * w2 + z1 * x2,
        w1 * z2 + x1 * y2 - y1 * x2 + z1 * w2,
        w1 * w2 - x1 * x2 - y1 * y2 - z1 * z2,
    )


def rotate(q_ab: Vector, v_b: Vector) -> Vector:
    """Return v_a = q_ab v_b q_ab*."""
    x, y, z, w = q_ab
    a, b, c = v_b
    t_x, t_y, t_z = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    return (
        a + w * t_x + (y * t_z - z * t_y),
        b + w * t_y + (z * t_x - x * t_z),
        c + w * t_z + (x * t_y - y * t_x),
    )


def to_body(q_ib: Vector, v_i: Vector) -> Vector:
    """Return v_b = q_ib* v_i q_ib."""
    return rotate((-q_ib[0], -q_ib[1], -q_ib[2], q_ib[3]), v_i)


def attitude_rate(q: Vector, omega_b: Vector, omega_a: Vector) -> Vector:
    """
    Return q' = q (omega_b, 0) / 2 - (omega_a, 0) q / 2, of q from b to a.

    omega_b: the rate of b in its own axes, omega_a: that of a in its own.
    """
    u, w = q[0:3], q[3]
    b, a = scale(0.5, omega_b), scale(0.5, omega_a)
    turned = add(scale(w, subtract(b, a)), cross(u, add(b, a)))
    return (*turned, dot(u, subtract(a, b)))
