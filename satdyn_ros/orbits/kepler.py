"""The attracting centre at the focus of a Kepler orbit: a circle or an ellipse."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.sentences import Checks, distinct_texts, refuse
from ..kernel import rotation
from ..kernel.rows import components, dot, from_components, length
from .kepler_equation import true_anomaly
from .orbit import Orbit, OrbitConstants
from .pieces import PIECE_TURN, Stretch

EARTH_MU = 3.986004418e14
# Values of mu in use differ by less.
EARTH_TO = 1e-4
# Equatorial, WGS 84.
EARTH_RADIUS_M = 6_378_137.0
# What the eccentricity of a circle comes to by rounding, and a little more.
_CIRCLE = 1e-14
# What a rate counts as at least where it divides [rad/s].
_SLOWEST = 1e-300


@dataclass(frozen=True)
class KeplerOrbit(Orbit):
    """
    A Kepler ellipse by its elements at t = 0.

    The inertial frame is that of the elements: with all angles zero the pericentre is on +X and
    the orbit normal on +Z.  Elements may be arrays, which broadcast against the times.

    Parameters
    ----------
    mu : m^3/s^2
        gravitational parameter
    semi_major_axis : m
        a
    eccentricity : float
        e, below 1
    inclination : rad
        from +Z to the orbit normal
    raan : rad
        right ascension of the ascending node
    argument_of_periapsis : rad
        from the node to the pericentre
    true_anomaly : rad
        f, from the pericentre to the body
    """

    mu: float = EARTH_MU
    semi_major_axis: float = 6.878137e6
    eccentricity: float = 0.0
    inclination: float = 0.0
    raan: float = 0.0
    argument_of_periapsis: float = 0.0
    true_anomaly: float = 0.0

    is_keplerian = True

    def __repr__(self) -> str:
        if np.size(self.mean_motion) > 1:
            return f'<KeplerOrbit: {np.size(self.mean_motion)} orbits>'
        a_km, e, i, period_s = (
            np.ravel(x)[0]
            for x in (
                self.semi_major_axis / 1e3,
                self.eccentricity,
                np.degrees(self.inclination),
                2.0 * np.pi / self.mean_motion,
            )
        )
        return f'<KeplerOrbit: a {a_km:g} km, e {e:g}, inclination {i:g} deg, {period_s:g} s>'

    @classmethod
    def from_state(cls, r_i: ArrayLike, v_i: ArrayLike, mu: float = EARTH_MU) -> 'KeplerOrbit':
        """
        Return the ellipse through a position with a velocity.

        On the equator the node, on a circle the pericentre is not defined; the angles from them
        still add up to the state.

        Parameters
        ----------
        r_i : (3,), m, inertial axes
            position from the centre; or of many, checked, (M, 1, 3)
        v_i : (3,), m/s, inertial axes
            velocity; or of many, checked, (M, 1, 3)
        mu : m^3/s^2
            gravitational parameter

        Raises
        ------
        ValueError
            the orbit is no ellipse
        """
        r_i, v_i = np.asarray(r_i, float), np.asarray(v_i, float)
        if r_i.ndim == v_i.ndim == 1 and np.ndim(mu) == 0:
            refuse(state_checks(r_i, v_i, mu))
        r, v = length(r_i), length(v_i)
        momentum, e_cos, e_sin = _momentum_and_eccentricity(r_i, v_i, mu)
        eccentricity = np.hypot(e_cos, e_sin)
        normal = momentum / length(momentum)[..., None]
        radial = r_i / r[..., None]
        along = np.cross(normal, radial)
        true_anomaly = np.arctan2(e_sin, e_cos)
        n_x, n_y, n_z = components(normal)
        raan = np.arctan2(n_x, -n_y)
        node = from_components([np.cos(raan), np.sin(raan), np.zeros_like(raan)])
        latitude = np.arctan2(-dot(along, node), dot(radial, node))
        return cls(
            mu=mu,
            semi_major_axis=1.0 / (2.0 / r - v * v / mu),
            eccentricity=eccentricity * (eccentricity >= _CIRCLE),
            inclination=np.arctan2(np.hypot(n_x, n_y), n_z),
            raan=raan,
            argument_of_periapsis=latitude - true_anomaly,
            true_anomaly=true_anomaly,
        )

    @cached_property
    def is_eccentric(self) -> bool:
        """Whether the distance varies."""
        return bool(np.count_nonzero(self.eccentricity))

    @cached_property
    def mean_motion(self) -> float:
        """Return n = sqrt(mu / a^3) [rad/s]."""
        return np.sqrt(self.mu / self.semi_major_axis) / self.semi_major_axis

    @cached_property
    def mean_anomaly(self) -> float:
        """Return the mean anomaly at t = 0 [rad]."""
        e, f = self.eccentricity, self.true_anomaly
        beta = e / (1.0 + np.sqrt(1.0 - e * e))
        E = f - 2.0 * np.arctan2(beta * np.sin(f), 1.0 + beta * np.cos(f))
        return E - e * np.sin(E)

    @cached_property
    def semi_latus_rectum(self) -> float:
        """Return a (1 - e^2) [m]."""
        return self.semi_major_axis * (1.0 - self.eccentricity**2)

    @property
    def stretches(self) -> tuple[Stretch, ...]:
        """All times, cut into pieces of one length from tick 0 on, for what is tabled."""
        return (Stretch(0.0, float(PIECE_TURN / max(self.fastest_rate, _SLOWEST))),)

    @property
    def fastest_rate(self) -> float:
        """Return df/dt at the pericentre [rad/s]."""
        nearest = self.semi_major_axis * (1.0 - self.eccentricity)
        return np.sqrt(self.mu * (1.0 + self.eccentricity) / nearest) / nearest

    @cached_property
    def perifocal(self) -> np.ndarray:
        """
        Return the axes to the pericentre, 90 deg ahead, and normal as columns of a matrix.

        On a circle the pericentre is where the argument of periapsis puts it.
        """
        q = rotation.multiply(
            rotation.about([0, 0, 1], self.raan),
            rotation.multiply(
                rotation.about([1, 0, 0], self.inclination),
                rotation.about([0, 0, 1], self.argument_of_periapsis),
            ),
        )
        return rotation.matrix(q)

    @property
    def normal(self) -> np.ndarray:
        """Return the unit normal of the orbit in inertial axes, shape (3,)."""
        return self.perifocal[..., :, 2]

    @property
    def constants(self) -> OrbitConstants:
        """What the equations take of it."""
        l = self.semi_latus_rectum
        anomaly_rate = np.sqrt(self.mu / l) / l
        outward, ahead, normal = np.moveaxis(self.perifocal, -1, 0)
        return OrbitConstants(
            anomaly_rate,
            3.0 * anomaly_rate**2,
            outward,
            ahead,
            normal,
            self.eccentricity,
            semi_latus_rectum=l,
            speed=np.sqrt(self.mu / l),
        )

    def mean_anomaly_at(self, t_s: float) -> tuple[Any, Any, Any]:
        """Return mean anomaly [rad], its rate [rad/s] and eccentricity, which give f."""
        mean_motion = self.mean_motion
        return self.mean_anomaly + mean_motion * t_s, mean_motion, self.eccentricity

    def anomaly(self, t_s: ArrayLike) -> np.ndarray:
        """Return the true anomaly f [rad], continuous in time, shape (...)."""
        mean_anomaly = self.mean_anomaly + self.mean_motion * np.asarray(t_s, float)
        if not self.is_eccentric:
            return mean_anomaly
        return true_anomaly(mean_anomaly, self.eccentricity)

    def direction(self, t_s: ArrayLike) -> np.ndarray:
        """Return c_i, the unit vector from the centre to the body, shape (..., 3)."""
        f = self.anomaly(t_s)[..., None]
        to_pericentre, ahead, _ = components(self.perifocal)
        return np.cos(f) * to_pericentre + np.sin(f) * ahead

    def radius(self, t_s: ArrayLike) -> np.ndarray:
        """Return r [m], shape (...)."""
        return self.semi_latus_rectum / (1.0 + self.eccentricity * np.cos(self.anomaly(t_s)))

    def rate(self, t_s: ArrayLike) -> np.ndarray:
        """Return df/dt [rad/s], shape (...)."""
        with np.errstate(all='ignore'):
            return np.sqrt(self.mu * self.semi_latus_rectum) / self.radius(t_s) ** 2

    def gradient_at(self, t_s: ArrayLike) -> np.ndarray:
        """Return 3 mu / r^3 [1/s^2], shape (...)."""
        with np.errstate(all='ignore'):
            return 3.0 * self.mu / self.radius(t_s) ** 3

    def largest_gradient(self, t_s: np.ndarray) -> np.ndarray:
        """Return the largest |3 mu / r^3| [1/s^2] since the row before, (N,)."""
        gradient = np.abs(self.gradient_at(t_s))
        if not self.is_eccentric:
            return gradient
        # Only a pericentre between two rows is nearer than both.
        turn = np.floor(self.anomaly(t_s) / (2.0 * np.pi))
        passed = np.diff(turn, prepend=turn[..., :1], axis=-1) != 0.0
        nearest_m = self.semi_latus_rectum / (1.0 + self.eccentricity)
        return np.where(passed, 3.0 * self.mu / nearest_m**3, gradient)

    def position_velocity(self, t_s: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Return r_i [m] and v_i [m/s], each (..., 3)."""
        e, p, f = self.eccentricity, self.semi_latus_rectum, self.anomaly(t_s)[..., None]
        to_pericentre, ahead, _ = components(self.perifocal)
        cos_f, sin_f = np.cos(f), np.sin(f)
        r_i = p / (1.0 + e * cos_f) * (cos_f * to_pericentre + sin_f * ahead)
        v_i = np.sqrt(self.mu / p) * (-sin_f * to_pericentre + (e + cos_f) * ahead)
        return r_i, v_i

    def lvlh(self, t_s: ArrayLike) -> np.ndarray:
        """
        Return q_il, LVLH to inertial, shape (..., 4), continuous in time.

        LVLH has x along track, y opposite to the orbit normal and z to the centre.
        """
        turned = rotation.about(self.normal, self.anomaly(t_s))
        return rotation.multiply(turned, self._lvlh_at_pericentre)

    @cached_property
    def _lvlh_at_pericentre(self):
        to_pericentre, ahead, normal = components(self.perifocal)
        return rotation.from_matrix(np.stack([ahead, -normal, -to_pericentre], axis=-1))

    def lvlh_rate(self, t_s: ArrayLike) -> np.ndarray:
        """Return the angular velocity of LVLH in inertial axes [rad/s], shape (..., 3)."""
        return self.rate(t_s)[..., None] * self.normal


def state_checks(r_i: np.ndarray, v_i: np.ndarray, mu: float | np.ndarray) -> Checks:
    """
    Check that a position and a velocity are on an ellipse.

    Parameters
    ----------
    r_i : (..., 3), m, inertial axes
        position from the centre
    v_i : (..., 3), m/s, inertial axes
        velocity
    mu : (...), m^3/s^2
        gravitational parameter
    """
    r, v = length(r_i), length(v_i)
    if (yield ~(r > 0.0)):
        raise ValueError('orbit.position is the attracting centre itself')
    escape = np.sqrt(2.0 * mu / r)
    if (yield ~(v < escape)):
        numbers = distinct_texts(float(v), float(escape))
        raise ValueError(
            f'orbit.velocity is {numbers[0]} m/s, and from {numbers[1]} m/s on the satellite '
            'leaves: the orbit is no ellipse'
        )
    _, e_cos, e_sin = _momentum_and_eccentricity(r_i, v_i, mu)
    if (yield ~(np.hypot(e_cos, e_sin) < 1.0)):
        raise ValueError(
            'orbit.velocity is along orbit.position: the satellite falls into the centre'
        )


def _momentum_and_eccentricity(r_i, v_i, mu):
    """Return r x v, and e times the cosine and the sine of the true anomaly."""
    momentum = np.cross(r_i, v_i)
    pull = mu * length(r_i)
    e_cos = dot(momentum, momentum) / pull - 1.0
    return momentum, e_cos, length(momentum) * dot(r_i, v_i) / pull
