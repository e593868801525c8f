"""Bodies, attitudes and signs for hypothesis to draw."""

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st

from satdyn_ros.kernel import rotation

signs = st.sampled_from([-1, 1])
# None of 1e-90: at rest so near to an equilibrium the propagation, which is the truth, takes a
# step of months, and what it interpolates within has no digits.
angles = st.floats(-3.1, 3.1).map(lambda angle: angle if abs(angle) > 1e-15 else 0.0)


def powers_of_ten(low, high):
    """Return a strategy for numbers between 10^low and 10^high."""
    return st.floats(low, high).map(lambda exponent: 10.0**exponent)


@st.composite
def moments(draw):
    """
    Draw principal moments (3,) [kg m^2] of a body, two of them equal at times.

    Moments that differ differ by 3 %: closer ones leave their axes to rounding, which is not
    tested here.
    """
    sums = np.array([draw(st.floats(0.05, 1.0)) for _ in range(3)])
    if draw(st.integers(0, 5)) == 0:
        sums[1] = sums[0]
    moments = np.sum(sums) - sums
    gaps = np.diff(np.sort(moments)) / np.max(moments)
    assume(np.all((gaps == 0.0) | (gaps > 0.03)))
    return draw(powers_of_ten(-1.0, 3.0)) * moments


@st.composite
def attitudes(draw):
    """Draw a unit quaternion (4,)."""
    q = np.array([draw(st.floats(-1.0, 1.0)) for _ in range(4)])
    assume(np.linalg.norm(q) > 0.1)
    return rotation.normalise(q)


@st.composite
def body_axes(draw):
    """Draw the quaternion q_bp of principal axes in body axes, at times the identity."""
    return draw(attitudes()) if draw(st.booleans()) else rotation.IDENTITY


def inertia_in_body_axes(moments, q_bp):
    """Return the tensor (3, 3) whose principal axes are q_bp."""
    if np.array_equal(q_bp, rotation.IDENTITY):
        return np.diag(moments)
    R = rotation.matrix(q_bp)
    inertia = R @ np.diag(moments) @ R.T
    return (inertia + inertia.T) / 2.0
