"""What several tests of sweeps share."""

import pytest

pytest.importorskip('pyarrow')

from satdyn_ros.sweep.run import sweep

from .sweeps import MANY, write


@pytest.fixture(scope='session')
def many(tmp_path_factory):
    """Return the path of a sweep of 300 runs and the bytes of its table from one process."""
    folder = tmp_path_factory.mktemp('many')
    path = write(folder, **MANY)
    return path, sweep(path, folder / 'one', workers=1).read_bytes()
