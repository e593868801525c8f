"""The satellite as an entity: its state in one frame, and a state that is asked for."""

import numpy as np
import pytest
from flights import GYROSTAT
from scipy.spatial.transform import Rotation

from satdyn_ros.run.entity import EntityState, matching, why_not_reset


def test_a_state_is_in_inertial_axes():
    """The rate is that in body axes turned by SciPy's rotation; the others are the orbit's."""
    states = GYROSTAT.motion().at([0.0, 100.0, 250.0])
    for row in (1, -1):
        entity = EntityState.of(states, row)
        turned = Rotation.from_quat(states.q_ib[row]).apply(states.omega_bi_b[row])
        # Some roundings of a rate of hundredths.
        np.testing.assert_allclose(entity.rate, turned, rtol=0.0, atol=1e-16)
        assert np.linalg.norm(entity.rate - states.omega_bi_b[row]) > 1e-3
        np.testing.assert_array_equal(entity.q_ib, states.q_ib[row])
        np.testing.assert_array_equal(entity.position, states.r_i[row])
        np.testing.assert_array_equal(entity.velocity, states.v_i[row])


def test_a_state_that_is_asked_for_is_where_the_motion_restarts():
    """What is read at an instant and set again gives the same attitude and rate, on any orbit."""
    states = GYROSTAT.motion().at([0.0, 250.0])
    entity = EntityState.of(states, 1)
    state = GYROSTAT.with_values(entity.request()).state_at(77.0)
    np.testing.assert_allclose(state.q_ib, states.q_ib[1], rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(state.omega_bi_b, states.omega_bi_b[1], rtol=0.0, atol=1e-16)


@pytest.mark.parametrize(
    ('scope', 'why'),
    [(2, ''), *((n, 'the time never') for n in (0, 1, 3, 255)), (4, 'nothing of'), (6, 'nothing')],
)
def test_the_state_can_be_reset_and_the_time_cannot(scope, why):
    """Bits 1 time, 2 state, 4 what was spawned; 0 and 255 all of it."""
    assert why_not_reset(scope).startswith(why)
    assert bool(why_not_reset(scope)) == bool(why)


def test_a_filter_is_a_regular_expression():
    """An empty one finds all; one that is none is refused in a sentence."""
    assert matching('satdyn', '') == matching('satdyn', '^sat.*n$') == ['satdyn']
    assert matching('satdyn', 'other') == []
    with pytest.raises(ValueError, match=r"filter '\(' is not a regular expression"):
        matching('satdyn', '(')
