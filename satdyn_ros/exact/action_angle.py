"""
Action and angle variables of the free triaxial body (textbook, 46.25 to 46.30).

About the momentum L the body is the pair of the precession phi of its axis of the largest moment
and the phase t0 of its rates.  The angles psi~ = 2 pi t0 / T1 and phi~ = phi - S(t0), S the swing
of the precession about its mean (46.24), grow uniformly.  Their actions are

    J = (1 / 2 pi) integral of L_3 dpsi over T1 = T1 (2 E - L chi_0) / 2 pi   and   L,

the former by 2 E = L phi' + L_3 psi', so that dE = (2 pi / T1) dJ + chi_0 dL.
"""

from typing import NamedTuple

import numpy as np

from ..dynamics.inertia import principal_axes
from ..kernel import rotation
from .free import Free


class ActionAngle(NamedTuple):
    """
    The actions and angles of a free motion.

    phi~ is measured in the plane across L as rotation.from_z_to lays its axes.  For a symmetric
    body the axis is that of symmetry.

    Attributes
    ----------
    actions : (2,), N m s
        J and L
    angles : (2,), rad
        psi~ and phi~ at the start
    rates : (2,), rad/s
        2 pi / T1 and chi_0, at which the angles grow

    Examples
    --------
    >>> ActionAngle.of(Free(system, state)).at([10.0, 20.0])  # doctest: +SKIP
    """

    actions: np.ndarray
    angles: np.ndarray
    rates: np.ndarray

    @classmethod
    def of(cls, motion: Free) -> 'ActionAngle':
        """
        Return the variables of a free motion.

        Parameters
        ----------
        motion : Free
            the motion

        Raises
        ------
        ValueError
            there is a rotor, or the rates have no period
        """
        known = motion.poinsot
        if known is None:
            raise ValueError('the body has a rotor: these variables are those of a rigid body')
        if not np.isfinite(known.T1):
            raise ValueError('the rates of this motion have no period, and so no angle')
        state, inertia = motion.state, motion.system.carrier_inertia
        momentum_i = rotation.rotate(state.q_ib, inertia @ state.omega_bi_b)
        q_il = rotation.from_z_to(momentum_i / motion.L)
        moments, R_bp = principal_axes(inertia)
        axis_b = R_bp[:, np.argmax(moments)]
        if known.is_symmetric:
            axis_b = motion.axis_b
        q_lb = rotation.multiply(rotation.conjugate(q_il), state.q_ib)
        x, y, _ = rotation.rotate(q_lb, axis_b)
        rates = np.array([2.0 * np.pi / motion.T1, motion.chi0])
        J = (2.0 * motion.E - motion.L * motion.chi0) / rates[0]
        phi = np.arctan2(x, -y) - known.precession_swing(known.t0)
        return cls(np.array([J, motion.L]), np.array([rates[0] * known.t0, phi]), rates)

    def at(self, t_s: float | np.ndarray) -> np.ndarray:
        """
        Return psi~ and phi~ (N, 2) [rad], continuous.

        Parameters
        ----------
        t_s : float or (N,), s
            since the motion began
        """
        return self.angles + np.multiply.outer(np.atleast_1d(t_s), self.rates)
