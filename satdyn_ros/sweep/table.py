"""Rows as Parquet: the columns of a sweep's table, its parts, and their union."""

import os
from collections.abc import Iterable
from itertools import islice
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from .outcome import INTEGRALS
from .plan import Plan


def schema(plan: Plan) -> pa.Schema:
    """Return the columns of the table: what varies, what the run came to, why it failed."""
    number, vector = pa.float64(), pa.list_(pa.float64())
    kinds = {
        'double': number,
        'double_array': vector,
        'integer': pa.int64(),
        'string': pa.string(),
        'bool': pa.bool_(),
    }
    columns = {'run': pa.int64()}
    columns |= {varied.name: kinds[varied.quantity.key.kind] for varied in plan.vary}
    columns |= {'failure': pa.string(), 'q_ib': vector, 'omega_bi_b': vector}
    columns |= dict.fromkeys(('rotor_speed', 'rotor_angle'), number)
    columns |= dict.fromkeys(('rate_min_rad_s', 'rate_max_rad_s'), number)
    columns |= dict.fromkeys(('lvlh_angle_min_rad', 'lvlh_angle_max_rad'), number)
    columns |= {'captured': pa.bool_(), 'capture_s': number}
    columns |= {f'drift_{name}': number for name in INTEGRALS}
    if plan.keeps_samples:
        frames = ('q_ib', 'omega_bi_b') if plan.scenario.is_fixed else ('q_lb', 'omega_bl_b')
        columns |= {f'samples_{name}': pa.list_(vector) for name in frames}
    return pa.schema(list(columns.items()))


def write_part(path: Path, plan: Plan, rows: list[dict[str, Any]]) -> None:
    """Write rows as a Parquet file that is there whole or not at all."""
    _write(path, plan, [pa.Table.from_pylist(rows, schema(plan))])


def unite(path: Path, plan: Plan, parts: Iterable[Path]) -> None:
    """Write the rows of parts, in their order, as one Parquet file, few in memory at a time."""
    _write(path, plan, _groups(plan, iter(parts)))


def _groups(plan, parts):
    while some := [pq.read_table(part, schema=schema(plan)) for part in islice(parts, 64)]:
        yield pa.concat_tables(some).combine_chunks()


def _write(path, plan, tables):
    partial = path.with_suffix('.partial')
    with partial.open('wb') as file:
        with pq.ParquetWriter(file, schema(plan), compression='zstd') as writer:
            for table in tables:
                writer.write_table(table)
        file.flush()
        os.fsync(file.fileno())
    os.replace(partial, path)
