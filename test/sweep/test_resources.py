"""A sweep that a machine cannot hold is refused before anything is written."""

import pytest

from satdyn_ros.sweep.run import sweep

from .sweeps import write


@pytest.mark.parametrize(
    ('changes', 'reason'),
    [
        ({'interval_s': 1e-8}, 'a run of this sweep has 1200000000001 samples and needs 436'),
        ({'runs': 10**9, 'samples': True}, 'the table of this sweep, 3000000000 runs of 121 sam'),
    ],
)
def test_what_does_not_fit_is_refused(tmp_path, changes, reason):
    """One sentence says what is needed and what there is."""
    with pytest.raises(ValueError, match=reason):
        sweep(write(tmp_path, **changes), tmp_path / 'out')
    assert not (tmp_path / 'out').exists()
