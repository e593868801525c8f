"""Rows as Parquet: the columns of a sweep's table, its parts, and their union."""

import os
from collections.abc import Iterable, Mapping
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from ..base.regular_file import regular_file
from ..dynamics.integrals import NAMES
from .plan import Plan

_NUMBER, _VECTOR = pa.float64(), pa.list_(pa.float64())
_KINDS = {
    'double': _NUMBER,
    'double_array': _VECTOR,
    'integer': pa.int64(),
    'string': pa.string(),
    'bool': pa.bool_(),
}

# The results of a run: type and meaning of each column.
OUTCOMES: dict[str, tuple[pa.DataType, str]] = {
    'failure': (pa.string(), 'why the run failed, in one sentence; no value: it did not'),
    'q_ib': (_VECTOR, 'attitude at the end, body to inertial, x y z w'),
    'omega_bi_b': (_VECTOR, 'rate at the end, body relative to inertial, body axes [rad/s]'),
    'rotor_speed': (_NUMBER, 'speed of a free rotor at the end, relative to the body [rad/s]'),
    'rotor_angle': (_NUMBER, 'angle of a free rotor at the end [rad]'),
    'rate_min_rad_s': (_NUMBER, 'least length of omega_bi_b at the samples [rad/s]'),
    'rate_max_rad_s': (_NUMBER, 'largest length of omega_bi_b at the samples [rad/s]'),
    'lvlh_angle_min_rad': (
        _NUMBER,
        'least angle of the rotation from LVLH to the body axes x, y, z at the samples [rad]',
    ),
    'lvlh_angle_max_rad': (
        _NUMBER,
        'largest angle of the rotation from LVLH to the body axes x, y, z at the samples [rad]',
    ),
    'nadir_angle_min_rad': (
        _NUMBER,
        'least angle between nadir and the nearer end of the axis of least inertia (or of '
        'captured_axis) at the samples, 0 to pi/2 [rad]',
    ),
    'nadir_angle_max_rad': (_NUMBER, 'largest angle of that kind at the samples [rad]'),
    'captured': (
        pa.bool_(),
        'whether the axis of least inertia (or captured_axis) does not cross the local '
        'horizontal during at least the last orbit; no value: the run is shorter than an orbit, '
        'there is no orbit, or the two least moments of inertia are equal',
    ),
    'capture_s': (_NUMBER, 'time from which on it does not cross the horizontal [s]'),
} | {
    f'drift_{name}': (_NUMBER, f'largest relative change of the first integral {name}')
    for name in NAMES
}
# Under this name the metadata of a column say which function of one's own gave it.
OWN = 'outcome'
# With rotor.names each rotor has a column of its own, which ends in _NAME.
_OF_A_ROTOR = ('rotor_speed', 'rotor_angle', 'drift_rotor_momentum')
SAMPLES = {
    'samples_q_ib': 'attitudes at the samples, body to inertial (orbit.type fixed)',
    'samples_omega_bi_b': 'rates at the samples, relative to inertial [rad/s] (orbit.type fixed)',
    'samples_q_lb': 'attitudes at the samples, body to LVLH',
    'samples_omega_bl_b': 'rates at the samples, relative to LVLH, body axes [rad/s]',
}


def schema(plan: Plan) -> pa.Schema:
    """
    Return the columns of the table: what varies, the results of the run, why it failed.

    Each column's meaning is in its metadata, under description; an outcome of one's own has its
    path there too, under outcome.  ValueError: it has the name of another column.
    """
    fields = [_field('run', pa.int64(), 'number of the run')]
    for varied in plan.vary:
        key = varied.quantity.key
        unit = f' [{key.unit}]' if key.unit else ''
        fields.append(_field(varied.name, _KINDS[key.kind], f'varied: {key.meaning}{unit}'))
    for name, (kind, meaning) in OUTCOMES.items():
        rotors = plan.scenario['rotor.names'] if name in _OF_A_ROTOR else ()
        fields += [_field(f'{name}_{rotor}', kind, f'{meaning}: {rotor}') for rotor in rotors]
        fields += [] if rotors else [_field(name, kind, meaning)]
    if plan.keeps_samples:
        fixed = plan.scenario.is_fixed
        names = [name for name in SAMPLES if name.endswith(('ib', 'bi_b')) == fixed]
        fields += [_field(name, pa.list_(_VECTOR), SAMPLES[name]) for name in names]
    for own in plan.outcomes:
        if own.name in (field.name for field in fields):
            raise ValueError(f'--outcome is {own.path}; the table has a column {own.name} already')
        field = _field(own.name, _NUMBER, own.meaning)
        fields.append(field.with_metadata(field.metadata | {OWN: own.path}))
    return pa.schema(fields)


def _field(name, kind, description):
    return pa.field(name, kind, metadata={'description': description})


def table(plan: Plan, columns: Mapping[str, Any]) -> pa.Table:
    """Return columns of runs (outcome.py) as a table; what is missing or nan has no value."""
    fields, count = schema(plan), len(columns['run'])
    arrays = [_array(columns.get(f.name, [None] * count), f.type) for f in fields]
    return pa.Table.from_arrays(arrays, schema=fields)


def _array(values, kind):
    if not isinstance(values, np.ndarray) or values.dtype != float:
        return pa.array(values, kind)
    missing = np.isnan(values)
    if kind == _VECTOR:
        begins = np.arange(0, values.size + 1, values.shape[1], dtype=np.int32)
        return pa.ListArray.from_arrays(begins, values.ravel(), mask=pa.array(missing.any(axis=1)))
    if values.ndim > 1:
        return pa.array([None if np.isnan(run).any() else run.tolist() for run in values], kind)
    return pa.array(values == 1.0 if kind == pa.bool_() else values, kind, mask=missing)


def write_part(path: Path, plan: Plan, part: pa.Table) -> None:
    """Write runs as a Parquet file, which is there once it is kept."""
    _write(path, plan, [part])


def keep(path: Path) -> None:
    """Sync a written file to disk and give it its name: then it is whole, or not there at all."""
    partial = _partial(path)
    with partial.open('rb') as file:
        os.fsync(file.fileno())
    os.replace(partial, path)


def unite(path: Path, plan: Plan, parts: Iterable[Path]) -> None:
    """Write the rows of parts, in their order, as one Parquet file, few in memory at a time."""
    _write(path, plan, _groups(plan, iter(parts)))
    keep(path)


def _groups(plan, parts):
    files = map(regular_file, parts)
    while some := [pq.read_table(file, schema=schema(plan)) for file in islice(files, 64)]:
        yield pa.concat_tables(some).combine_chunks()


def _write(path, plan, tables):
    with (
        _partial(path).open('wb') as file,
        pq.ParquetWriter(file, schema(plan), compression='zstd') as writer,
    ):
        for table in tables:
            writer.write_table(table)


def _partial(path):
    return path.with_suffix('.partial')


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
