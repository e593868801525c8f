"""Bags that earlier versions wrote: what was true stays true."""

from pathlib import Path

import numpy as np
import pytest

from satdyn_ros.bag.read_run import RecordedRun
from satdyn_ros.bag.verify import verify
from satdyn_ros.rosbag2.reader import Bag
from satdyn_ros.run.rules import RULES
from satdyn_ros.run.scenario import Scenario

REFERENCE = Path(__file__).parents[1] / 'reference'
BAGS = sorted((REFERENCE / 'bags_0.2').iterdir())


@pytest.mark.parametrize('bag', BAGS, ids=lambda bag: bag.name)
def test_a_bag_of_version_0_2_verifies(bag):
    """
    It is run again by the rules that it does not name; on its own machine it is the same bytes.

    They were written offline and live: wheels at their limits, sensors, requests, resets, pauses,
    topics switched, torques dropped, a halt, a closed form; each file alone verifies too.
    """
    assert RecordedRun(bag).rules == 0
    assert verify(bag).is_true
    files = Bag(bag).files
    for file in files[: len(files) if len(files) > 1 else 0]:
        assert verify(file).is_true


def test_a_bag_of_rules_1_verifies():
    """Its /tf has the mountings of the sensors at every tick, and there is no /tf_static."""
    bag = REFERENCE / 'bags_rules_1' / 'sensors_on_tf'
    run = RecordedRun(bag)
    assert (run.rules, 'tf_static' in run.names) == (1, False)
    assert all(b'star_tracker' in bytes(row) for row in Bag(bag).messages('/tf').data)
    assert verify(bag).is_true
    for file in Bag(bag).files:
        assert verify(file).is_true


def test_a_bag_of_rules_2_verifies():
    """Its gyro gives the rotation vector between samples, which folds at half a turn."""
    bag = REFERENCE / 'bags_rules_2' / 'integrating_gyro'
    assert RecordedRun(bag).rules == 2
    assert verify(bag).is_true
    for file in Bag(bag).files:
        assert verify(file).is_true


def test_a_bag_of_rules_3_verifies():
    """
    Its table of an ephemeris, its plate's coefficients and its geodetic status are those of then.

    The plate has none of its own: they are the defaults, not those of surface.*.
    """
    bag = REFERENCE / 'bags_rules_3' / 'ephemeris_plate_geodetic'
    run = RecordedRun(bag)
    assert (run.rules, run.scenario['surface.specular']) == (3, 0.3)
    assert verify(bag).is_true


@pytest.mark.parametrize('rules', [5, 6])
def test_a_bag_with_corners_verifies(rules):
    """Its steps end where a rod or a plate turns as those of then; by now it has other bits."""
    bag = REFERENCE / f'bags_rules_{rules}' / 'rods_and_plates'
    run = RecordedRun(bag)
    assert run.rules == rules
    assert verify(bag).is_true
    then, now = (
        Scenario(run.scenario.values, rules=each).motion().at(60.0).q_ib for each in (rules, RULES)
    )
    assert then.tobytes() != now.tobytes()
    np.testing.assert_allclose(then, now, atol=1e-12)
