"""A reference attitude and how it turns, and the one that two directions make."""

from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from ..kernel import rotation
from ..kernel.functions import sqrt
from ..kernel.rows import components, from_components
from ..kernel.vector import Vector, add, cross, dot, scale, subtract

# Two directions that make a smaller angle are one [rad].
_PARALLEL = 1e-9


class OrbitState(Protocol):
    """What a reference follows from: r_i [m] and v_i [m/s] (..., 3), inertial, and a stamp."""

    @property
    def r_i(self) -> np.ndarray:
        """The position [m], inertial."""

    @property
    def v_i(self) -> np.ndarray:
        """The velocity [m/s], inertial."""

    @property
    def stamp_ns(self) -> int:
        """Unix time [ns]."""


class Reference(NamedTuple):
    """
    The axes r that the body axes should have, and how they turn.

    Attributes
    ----------
    q_ir : (..., 4), x, y, z, w
        takes components in these axes to inertial ones
    omega_ri_r : (..., 3), rad/s, in these axes
        their rate relative to inertial axes
    alpha_ri_r : (..., 3), rad/s^2, in these axes
        the derivative of that rate in time
    """

    q_ir: np.ndarray
    omega_ri_r: np.ndarray
    alpha_ri_r: np.ndarray

    def of_body_axis(self, axis_b: ArrayLike) -> 'Reference':
        """
        Return the reference turned about z, so that a body axis comes nearest to its x.

        Parameters
        ----------
        axis_b : (3,), body axes
            not along z
        """
        x, y, _ = components(axis_b)
        q_rb = rotation.about([0.0, 0.0, 1.0], -np.arctan2(y, x))
        q_br = rotation.conjugate(q_rb)
        return Reference(
            rotation.multiply(self.q_ir, q_rb),
            rotation.rotate(q_br, self.omega_ri_r),
            rotation.rotate(q_br, self.alpha_ri_r),
        )


class Moving(NamedTuple):
    """A vector that moves: its components, and their first and second derivatives in time."""

    value: Vector
    rate: Vector
    acceleration: Vector

    @classmethod
    def of_rows(cls, *rows: ArrayLike) -> 'Moving':
        """Return that of a vector and its two derivatives (..., 3)."""
        return cls(*(tuple(components(row)) for row in rows))

    def minus(self, other: 'Moving') -> 'Moving':
        """Return the difference of two vectors."""
        return Moving(*(subtract(a, b) for a, b in zip(self, other, strict=True)))

    def across(self, other: 'Moving') -> 'Moving':
        """Return the vector product of two."""
        a, b = self, other
        bent = add(cross(a.acceleration, b.value), cross(a.value, b.acceleration))
        return Moving(
            cross(a.value, b.value),
            add(cross(a.rate, b.value), cross(a.value, b.rate)),
            add(bent, scale(2.0, cross(a.rate, b.rate))),
        )

    def direction(self) -> 'Moving':
        """Return the unit vector along it."""
        per = 1.0 / sqrt(dot(self.value, self.value))
        u = scale(per, self.value)
        slope = dot(u, self.rate)
        rate = scale(per, subtract(self.rate, scale(slope, u)))
        bend = dot(rate, self.rate) + dot(u, self.acceleration)
        rest = add(scale(2.0 * slope, rate), scale(bend, u))
        return Moving(u, rate, scale(per, subtract(self.acceleration, rest)))


def aligned(toward: Moving, near: Moving, what: str) -> Reference:
    """
    Return the axes whose z is along one vector, and whose x is as near as can be to another.

    ValueError: the two are along the same line, or one is zero; what: begins the sentence.

    From the derivatives of the axes e: with e' = omega x e the component omega_x is z . y', and so
    on in turn.  The angular acceleration has the same components in axes that turn as in those
    that rest (Hughes 1986, Spacecraft Attitude Dynamics, section 2.3).
    """
    y = toward.across(near)
    sizes = (dot(v.value, v.value) for v in (y, toward, near))
    across, one, other = (np.sqrt(np.asarray(size, float)) for size in sizes)
    if not np.all(across > _PARALLEL * one * other):
        raise ValueError(
            f'{what} has no attitude here: its two directions are along one line, or one is zero'
        )
    z, y = toward.direction(), y.direction()
    x = y.across(z)
    axes = [from_components(axis.value) for axis in (x, y, z)]
    omega = dot(z.value, y.rate), dot(x.value, z.rate), dot(y.value, x.rate)
    alpha = (_turning(z, y), _turning(x, z), _turning(y, x))
    return Reference(
        rotation.from_matrix(np.stack(axes, axis=-1)),
        from_components(omega),
        from_components(alpha),
    )


def _turning(one: Moving, other: Moving) -> Any:
    """Return the derivative of one . other'."""
    return dot(one.rate, other.rate) + dot(one.value, other.acceleration)
