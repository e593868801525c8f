"""The results of a sweep, in one sentence."""

from pathlib import Path

import pyarrow.compute as pc
import pyarrow.parquet as pq


def summary(table: str | Path) -> str:
    """Return how many runs a sweep's table has, how many failed, what share was captured."""
    columns = pq.read_table(table, columns=['failure', 'captured'])
    failed = len(columns) - columns['failure'].null_count
    judged = len(columns) - columns['captured'].null_count
    text = f'{len(columns)} runs, {failed} failed'
    if judged:
        captured = pc.sum(columns['captured']).as_py()
        text += f', {captured} of {judged} captured ({captured / judged:.1%})'
    return text
