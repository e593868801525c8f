"""The propagation against truths from outside: 190-bit integrations, NASA's logs, SciPy."""

import numpy as np
import pytest
from cases import bounded, newtonian, rigid

from satdyn_ros.dynamics import rotation
from satdyn_ros.dynamics.propagator import Propagation

CASES = newtonian() | rigid()


@pytest.mark.parametrize('name', bounded(CASES, 'bound_numeric'))
def test_reference_case(name):
    """Every reference case stays within its bound at tolerance 1e-13, ten times it in rate."""
    case = CASES[name]
    states = Propagation(case.system, case.start, tolerance=1e-13).at(case.t_s)
    assert rotation.angle_between(states.q_ib, case.q_ib).max() < case.bound_numeric
    rate = np.linalg.norm(case.omega_bi_b, axis=1).max()
    error = np.linalg.norm(states.omega_bi_b - case.omega_bi_b, axis=1).max()
    assert error < 10.0 * case.bound_numeric * rate
