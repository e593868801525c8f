"""The faults that scripts/faults.py puts into the package are ones that it could have."""

from pathlib import Path

from scripts.faults import faults

PACKAGE = Path(__file__).parents[1] / 'satdyn_ros'


def test_what_each_replaces_is_there_once():
    """A change of the package that it is in says so here, and not when the script is next run."""
    found = [(PACKAGE / each.path).read_text().count(each.right) for each in faults()]
    assert found == [1] * 40
