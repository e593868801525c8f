"""The Earth on maps: coast lines where the coasts are."""

import numpy as np
import pytest

from satdyn_ros.report.earth_map import coast_lines


@pytest.mark.parametrize(
    ('longitude', 'latitude'),
    [(-9.3, 42.9), (18.5, -34.4), (80.2, 8.6), (-67.3, -55.9), (114.0, -22.6), (-168.1, 65.6)],
    ids=['Finisterre', 'Good Hope', 'Ceylon', 'Horn', 'North West', 'Prince of Wales'],
)
def test_capes_are_on_the_coast(longitude, latitude):
    """Capes all over the Earth are within a degree of a coast line."""
    points = np.concatenate(list(coast_lines()))
    apart = np.hypot(
        (points[:, 0] - longitude) * np.cos(np.radians(latitude)), points[:, 1] - latitude
    )
    assert apart.min() < 1.0


def test_coast_lines_stay_on_the_map():
    """No line goes across the map from one edge to the other, and none off it."""
    for line in coast_lines():
        assert np.all(np.abs(line) <= [180.0, 90.0])
        assert np.abs(np.diff(line[:, 0])).max() < 20.0
