"""The results of a sweep, in one sentence."""

from pathlib import Path

import pyarrow.parquet as pq

from ..base.regular_file import regular_file


def summary(table: str | Path) -> str:
    """
    Return how many runs a sweep's table has, how many failed, what share was captured.

    ValueError: another program wrote the table again, and left out which runs failed.
    """
    present = pq.read_schema(regular_file(table)).names
    if 'failure' not in present:
        raise ValueError(f'{table} has no column failure, which every sweep writes')
    columns = pq.read_table(table, columns=[c for c in ('failure', 'captured') if c in present])
    failed = len(columns) - columns['failure'].null_count
    text = f'{len(columns)} runs, {failed} failed'
    if 'captured' in present:
        judged = [c for c in columns['captured'].to_pylist() if c in (True, False)]
        if judged:
            captured = judged.count(True)
            text += f', {captured} of {len(judged)} captured ({captured / len(judged):.1%})'
    return text
