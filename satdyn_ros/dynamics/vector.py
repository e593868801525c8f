"""Vectors as tuples of three numbers, in compiled code: they live in registers."""

from ..compiled import inlined


@inlined
def add(a: tuple[float, ...], b: tuple[float, ...]) -> tuple[float, float, float]:
    """Return a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@inlined
def scale(s: float, a: tuple[float, ...]) -> tuple[float, float, float]:
    """Return s a."""
    return s * a[0], s * a[1], s * a[2]


@inlined
def dot(a: tuple[float, ...], b: tuple[float, ...]) -> float:
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def cross(a: tuple[float, ...], b: tuple[float, ...]) -> tuple[float, float, float]:
    """Return a x b."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


@inlined
def apply(M: tuple[tuple[float, ...], ...], a: tuple[float, ...]) -> tuple[float, float, float]:
    """Return M a for a matrix of three row tuples."""
    return dot(M[0], a), dot(M[1], a), dot(M[2], a)


@inlined
def to_body(q_ib: tuple[float, ...], v_i: tuple[float, ...]) -> tuple[float, float, float]:
    """Return q_ib* v_i q_ib."""
    u, w = (-q_ib[0], -q_ib[1], -q_ib[2]), q_ib[3]
    twice = scale(2.0, cross(u, v_i))
    return add(add(v_i, scale(w, twice)), cross(u, twice))
