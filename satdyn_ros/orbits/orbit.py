"""What an orbit is: the answers that the equations, closed forms and topics ask of every one."""

from abc import ABC, abstractmethod
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..kernel.rows import length
from .pieces import Pieces, Stretch


class OrbitConstants(NamedTuple):
    """
    What the equations take of an orbit, numbers, or arrays of many orbits.

    Of a conic with the semi-latus rectum l and the true anomaly f the line to the body is
    cos f P + sin f Q, and its distance l / (1 + e cos f).  Of a fixed direction there is P alone,
    of a table none of P, Q and the normal, but zeros.

    Attributes
    ----------
    anomaly_rate : rad/s
        that of f times (r / l)^2
    gradient : 1/s^2
        3 mu / l^3
    outward, ahead, normal : (3,), inertial axes
        unit vectors P, Q, and across both
    eccentricity : float
        e
    semi_latus_rectum : m
        l
    speed : m/s
        that along Q where f is zero, over 1 + e
    """

    anomaly_rate: Any
    gradient: Any
    outward: np.ndarray
    ahead: np.ndarray
    normal: np.ndarray
    eccentricity: Any = 0.0
    semi_latus_rectum: Any = 0.0
    speed: Any = 0.0


class Orbit(ABC):
    """
    Where a body is and how the attracting centre pulls; times t_s (...) [s] are from tick 0.

    Attributes
    ----------
    has_lvlh : bool
        whether it travels, so that it has a position, a period and LVLH axes
    is_keplerian : bool
        whether it is a circle or an ellipse on which the body falls freely, as closed forms have
        it; then it has eccentricity, normal and fastest_rate
    mu : m^3/s^2
        of the centre, nan where only the gradient is known
    """

    has_lvlh = True
    is_keplerian = False
    mu: float

    @property
    @abstractmethod
    def is_eccentric(self) -> bool:
        """Whether the distance varies."""

    @property
    @abstractmethod
    def mean_motion(self) -> float:
        """The mean rate [rad/s] at which the line to the centre turns, zero without a period."""

    @property
    @abstractmethod
    def constants(self) -> OrbitConstants:
        """What the equations take of it."""

    @abstractmethod
    def position_velocity(self, t_s: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Return r_i [m] and v_i [m/s], each (..., 3)."""

    @abstractmethod
    def lvlh(self, t_s: ArrayLike) -> np.ndarray:
        """
        Return q_il, LVLH to inertial, shape (..., 4).

        LVLH has x along track, y opposite to the orbit normal and z to the centre.
        """

    @abstractmethod
    def lvlh_rate(self, t_s: ArrayLike) -> np.ndarray:
        """Return the angular velocity of LVLH in inertial axes [rad/s], shape (..., 3)."""

    @property
    def stretches(self) -> tuple[Stretch, ...]:
        """The times that are cut into pieces of one length, for what is tabled along it."""
        raise NotImplementedError

    @property
    def pieces(self) -> Pieces | None:
        """The table that says where it is, with the columns of a TabledOrbit; None: none does."""
        return None

    @property
    def normal(self) -> np.ndarray:
        """The unit normal of its plane in inertial axes, shape (3,)."""
        raise NotImplementedError

    @property
    def eccentricity(self) -> Any:
        """The eccentricity of the ellipse."""
        raise NotImplementedError

    @property
    def fastest_rate(self) -> Any:
        """The rate df/dt at the pericentre [rad/s]."""
        raise NotImplementedError

    @property
    def period_s(self) -> float:
        """The time of a turn [s], infinite where there is none."""
        return 2.0 * np.pi / self.mean_motion if self.has_lvlh else np.inf

    def direction(self, t_s: ArrayLike) -> np.ndarray:
        """Return c_i, the unit vector from the centre to the body, shape (..., 3)."""
        r_i, _ = self.position_velocity(t_s)
        return r_i / length(r_i)[..., None]

    def radius(self, t_s: ArrayLike) -> np.ndarray:
        """Return r [m], shape (...)."""
        return length(self.position_velocity(t_s)[0])

    def rate(self, t_s: ArrayLike) -> np.ndarray:
        """Return the rate at which the line to the centre turns [rad/s], shape (...)."""
        r_i, v_i = self.position_velocity(t_s)
        return length(np.cross(r_i, v_i)) / length(r_i) ** 2

    def gradient_at(self, t_s: ArrayLike) -> np.ndarray:
        """Return 3 mu / r^3 [1/s^2], shape (...)."""
        return 3.0 * self.mu / self.radius(t_s) ** 3

    def largest_gradient(self, t_s: np.ndarray) -> np.ndarray:
        """Return the largest |3 mu / r^3| [1/s^2] since the row before, (N,)."""
        return np.abs(self.gradient_at(t_s))

    def anomaly(self, t_s: ArrayLike) -> np.ndarray:
        """Return the true anomaly f of the constants [rad], shape (...)."""
        return np.zeros(np.shape(t_s))

    def mean_anomaly_at(self, t_s: float) -> tuple[Any, Any, Any]:
        """Return mean anomaly [rad], its rate [rad/s] and eccentricity, which give f."""
        return 0.0, 0.0, 0.0

    def known_until(self, t_s: float) -> float:
        """Return up to when [s] it is known from a time on; ValueError: it is not there."""
        return np.inf

    def outside(self, t_s: float) -> str:
        """Return the sentence that refuses a time at which it is not known."""
        return f'{t_s:g} s is no time on the orbit'

    def described(self) -> dict[str, Any]:
        """Return by name what is to be said of it that its keys do not say."""
        return {}
