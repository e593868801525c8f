"""An orbit that is known as a table: how it turns, pulls and carries LVLH along."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike

from ..kernel import rotation
from ..kernel.rows import components, dot, from_components, length
from .kepler import EARTH_MU, KeplerOrbit
from .orbit import Orbit, OrbitConstants
from .pieces import Piece, Pieces, Stretch, derivatives

# The functions of the table, three each: r_i [m], v_i [m/s] as it is published, and the first and
# second derivative of r_i in time, which are those of the polynomials.
POSITION, VELOCITY, SLOPE, CURVATURE = np.arange(12).reshape(4, 3)


class OrbitSource(ABC):
    """
    Where the polynomials of an orbit come from; a text or elements, which a run can send on.

    key: of the scenario, or what else it is called in a sentence.
    """

    key = 'the orbit'

    @property
    @abstractmethod
    def stretches(self) -> tuple[Stretch, ...]:
        """The times that are cut into pieces of one length."""

    @abstractmethod
    def coefficients(self, piece: Piece) -> np.ndarray:
        """Return those of r_i and v_i, or of r_i alone if v_i is its slope, (6 or 3, terms)."""

    def outside(self, t_s: float) -> str:
        """Return the sentence that refuses a time outside all stretches."""
        return f'{t_s:g} s is no time on an orbit'

    def described(self, orbit: 'TabledOrbit') -> dict[str, Any]:
        """Return by name what is to be said of the orbit that its keys do not say."""
        return {}


@dataclass(frozen=True, eq=False)
class TabledOrbit(Orbit):
    """
    An orbit from a table made piece by piece.

    LVLH and its rate are those of the tabulated position and its own derivatives.

    Parameters
    ----------
    source : OrbitSource
        where the polynomials come from
    mu : m^3/s^2
        for the pull on the body
    """

    source: OrbitSource
    mu: float = EARTH_MU

    is_eccentric = True

    def __repr__(self) -> str:
        return f'<TabledOrbit: {self.source}>'

    def __reduce__(self):
        return TabledOrbit, (self.source, self.mu)

    @cached_property
    def pieces(self) -> Pieces:
        """The table, whose columns are POSITION, VELOCITY, SLOPE and CURVATURE."""
        return Pieces(self._coefficients, self.source.stretches, self.source.outside)

    @property
    def stretches(self) -> tuple[Stretch, ...]:
        """The times that are cut into pieces of one length."""
        return self.source.stretches

    def _coefficients(self, piece: Piece) -> np.ndarray:
        given = self.source.coefficients(piece)
        per_s = 2.0 / piece.stretch.length_s
        once, twice = derivatives(given.shape[1])
        slope, curvature = per_s * given[:3] @ once, per_s**2 * given[:3] @ twice
        velocity = given[3:] if len(given) > 3 else slope
        return np.concatenate([given[:3], velocity, slope, curvature])

    @property
    def constants(self) -> OrbitConstants:
        """How fast the field and the line to the centre are, by which steps are judged."""
        n = self.mean_motion
        return OrbitConstants(n, 3.0 * n**2, *np.zeros((3, 3)))

    @cached_property
    def osculating(self) -> KeplerOrbit:
        """
        The Kepler ellipse through the position at tick 0 and its slope.

        ValueError: it is no ellipse.
        """
        r_i, slope = self._columns(0.0, POSITION, SLOPE)
        try:
            return KeplerOrbit.from_state(r_i, slope, self.mu)
        except ValueError:
            raise ValueError(
                f'{self.source.key} is no ellipse at tick 0: {length(slope):.6g} m/s at '
                f'{length(r_i):.6g} m from the centre of the Earth'
            ) from None

    @property
    def mean_motion(self) -> float:
        """Return n [rad/s] of the osculating ellipse."""
        return self.osculating.mean_motion

    def known_until(self, t_s: float) -> float:
        """Return up to when [s] it is known from a time on; ValueError: it is not there."""
        return self.pieces.covered_until(t_s)

    def outside(self, t_s: float) -> str:
        """Return the sentence that refuses a time at which it is not known."""
        return self.source.outside(t_s)

    def described(self) -> dict[str, Any]:
        """Return by name what is to be said of it that its keys do not say."""
        return self.source.described(self)

    def _columns(self, t_s: ArrayLike, *wanted: np.ndarray) -> list[np.ndarray]:
        """Return some columns of the table, each (..., 3)."""
        t_s = np.asarray(t_s, float)
        values = self.pieces.values(t_s.ravel(), np.concatenate(wanted))
        return np.split(values.reshape(*t_s.shape, values.shape[1]), len(wanted), axis=-1)

    def position_velocity(self, t_s: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Return r_i [m] and v_i [m/s], each (..., 3)."""
        r_i, v_i = self._columns(t_s, POSITION, VELOCITY)
        return r_i, v_i

    def direction(self, t_s: ArrayLike) -> np.ndarray:
        """Return c_i, the unit vector from the centre to the body, shape (..., 3)."""
        (r_i,) = self._columns(t_s, POSITION)
        return r_i / length(r_i)[..., None]

    def radius(self, t_s: ArrayLike) -> np.ndarray:
        """Return r [m], shape (...)."""
        return length(*self._columns(t_s, POSITION))

    def gradient_at(self, t_s: ArrayLike) -> np.ndarray:
        """Return 3 mu / r^3 [1/s^2], shape (...)."""
        return 3.0 * self.mu / self.radius(t_s) ** 3

    def rate(self, t_s: ArrayLike) -> np.ndarray:
        """Return h / r^2, at which the line to the centre turns [rad/s], shape (...)."""
        r_i, slope = self._columns(t_s, POSITION, SLOPE)
        return length(_cross(r_i, slope)) / dot(r_i, r_i)

    def lvlh(self, t_s: ArrayLike) -> np.ndarray:
        """
        Return q_il, LVLH to inertial, shape (..., 4), its scalar part at least zero.

        LVLH has x along track, y opposite to the momentum of the orbit and z to the centre.
        """
        r_i, slope = self._columns(t_s, POSITION, SLOPE)
        momentum = _cross(r_i, slope)
        y, z = -momentum / length(momentum)[..., None], -r_i / length(r_i)[..., None]
        q_il = rotation.from_matrix(np.stack([_cross(y, z), y, z], axis=-1))
        return np.where(q_il[..., 3:] < 0.0, -q_il, q_il)

    def lvlh_rate(self, t_s: ArrayLike) -> np.ndarray:
        """
        Return the angular velocity of LVLH in inertial axes [rad/s], shape (..., 3).

        With the momentum h n = r x r' and the acceleration r'', the line r turns at h / r^2 about
        n, and the plane at (r / h) (r'' . n) about the line.
        """
        r_i, slope, curvature = self._columns(t_s, POSITION, SLOPE, CURVATURE)
        momentum = _cross(r_i, slope)
        h_squared = dot(momentum, momentum)
        about_normal = 1.0 / dot(r_i, r_i)
        about_line = dot(curvature, momentum) / h_squared
        return about_normal[..., None] * momentum + about_line[..., None] * r_i


# Runs that share the orbit share its table.
tabled_orbit = lru_cache(maxsize=4)(TabledOrbit)


def ends(pieces: Pieces, piece: Piece) -> tuple[np.ndarray, np.ndarray]:
    """Return r_i [m] where a piece of an orbit begins and where it ends, by its polynomials."""
    r_i = pieces.table_in(piece).coefficients[0, POSITION]
    return chebyshev.chebval(-1.0, r_i.T), chebyshev.chebval(1.0, r_i.T)


def _cross(a, b):
    (a1, a2, a3), (b1, b2, b3) = components(a), components(b)
    return from_components([a2 * b3 - a3 * b2, a3 * b1 - a1 * b3, a1 * b2 - a2 * b1])
