"""The text and the binary files of tables."""

import csv
import sys

import numpy as np
import pytest

from satdyn_ros.bag import table_files
from satdyn_ros.bag.columns import Columns


def blocks() -> list[Columns]:
    """Return a block of awkward doubles and stamps, and one of doubles of every size."""
    sizes = np.random.default_rng(1).integers(0, 2**63, 5000, np.uint64).view(float)
    sizes = sizes[np.isfinite(sizes)]
    awkward = np.array(
        [
            *(0.0, -0.0, 5e-324, 2.2250738585072014e-308, 1.7976931348623157e308),
            *(0.1, 1 / 3, -1e-5, 1e22, 1e23, 9e15, 2.0**53 + 2, 123456.0),
            *(np.nan, np.inf, -np.inf),
        ]
    )
    return [
        {'stamp_ns': 2**62 + np.arange(len(values)), 'value': values}
        for values in (awkward, sizes)
    ]


@pytest.mark.parametrize('library', ['polars', 'csv'])
def test_csv_reads_back_every_double(library, tmp_path, monkeypatch):
    """Each text is that of the same double and no other, whichever library writes it."""
    if library == 'polars':
        pytest.importorskip('polars')
    else:
        monkeypatch.setitem(sys.modules, 'polars', None)
    path = tmp_path / 'table.csv'
    table_files.write_csv(path, ['stamp_ns', 'value'], blocks())
    with open(path, newline='') as file:
        header, *rows = csv.reader(file)
    assert header == ['stamp_ns', 'value']
    stamps = np.concatenate([block['stamp_ns'] for block in blocks()])
    values = np.concatenate([block['value'] for block in blocks()])
    assert [int(row[0]) for row in rows] == stamps.tolist()
    read = np.array([float(row[1]) for row in rows])
    np.testing.assert_array_equal(read, values)
    np.testing.assert_array_equal(np.signbit(read), np.signbit(values))
