"""The states in a bag for other programs: tables, CCSDS messages, STK, SPICE and CesiumJS."""

import os
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..exchange.aem import AemWriter
from ..exchange.ccsds import Subject
from ..exchange.czml import CzmlWriter
from ..exchange.oem import OemWriter
from ..exchange.spice_kernels import CkWriter
from ..exchange.stk import StkAttitudeWriter
from ..kernel import rotation
from .columns import OMEGA_BI_B, Q_IB, Columns, StateTable, columns_of_topics, dtype_of
from .read_run import RecordedRun
from .table_files import write_csv, write_npz, write_parquet


@dataclass(frozen=True)
class Options:
    """
    The options of an export.

    Attributes
    ----------
    step_s : s or None
        from row to row; None: every tick
    columns : tuple of str
        those of a table; empty: all
    with_rates : bool
        whether an .aem, .a or .bc has body rates too
    frame, center : str or None
        the names that .aem, .oem and .a give the inertial axes and the attracting body; None:
        EME2000 and EARTH
    aem_version : str or None
        1.0 or 2.0; None: 2.0 with rates, 1.0 without
    """

    step_s: str | float | None = None
    columns: tuple[str, ...] = ()
    with_rates: bool = False
    frame: str | None = None
    center: str | None = None
    aem_version: str | None = None

    def check(self, kind: str) -> None:
        """Refuse what the format ('.csv') does not support; ValueError: in one sentence."""
        for name, given, kinds in (
            ('--columns', self.columns, _TABLES),
            ('--rates', self.with_rates, ('.aem', '.a', '.bc')),
            ('--aem-version', self.aem_version, ('.aem',)),
            ('--frame', self.frame, _WITH_NAMES),
            ('--center', self.center, _WITH_NAMES),
        ):
            if given and kind not in kinds:
                raise ValueError(f'{name} is for {" and ".join(kinds)}, not for {kind}')

    def subject(self, bag: Path) -> Subject:
        """Return the subject of a message: the satellite has the name of its bag."""
        name = re.sub(r'[^A-Z0-9_-]', '_', bag.resolve().stem.upper())
        return Subject(name, self.frame or 'EME2000', self.center or 'EARTH')


def export(
    path: str | Path,
    output: str | Path,
    options: Options | None = None,
    show: Callable[[int, int | None], None] = lambda done, total: None,
) -> int:
    """
    Write the states in a bag to a file and return its number of rows.

    Parameters
    ----------
    path : str or Path
        the bag
    output : str or Path
        the file, which appears when it is complete; the suffix of its name is the format: .csv,
        .npz, .parquet, .aem, .oem, .a, .czml or .bc, which gets its clock .tsc and its frame .tf
        beside it
    options : Options or None
        None: the defaults
    show : function of done and total
        called with numbers of ticks

    Raises
    ------
    ValueError
        the format is unknown, does not support the options or needs what is not installed; the bag
        was not written by satdyn_ros, is damaged, or lacks what the format needs
    """
    output, options = Path(output), options or Options()
    kind = _format_of(output)
    options.check(kind)
    run = RecordedRun(path)
    columns = options.columns if kind in _TABLES else _message_columns(run, kind, options)
    table = StateTable(run, columns, options.step_s)

    def blocks() -> Iterator[Columns]:
        for block in table.blocks():
            yield block
            show(table.ticks_read, table.tick_count)

    rows = _Rows.of(kind, blocks(), options.with_rates)
    with _complete(output) as part:
        if kind in _TABLES:
            _TABLES[kind](part, table.names, rows)
            return rows.count
        subject = options.subject(Path(path))
        if kind == _KERNEL:
            kernel = CkWriter(part, subject, options.with_rates)
            _write_ck(kernel, rows)
        else:
            with open(part, 'w+', encoding='ascii', newline='\n') as file:
                _MESSAGES[kind](file, table, rows, subject, options)
        if rows.count == 0:
            with_rate = ' with a body rate' if options.with_rates else ''
            raise ValueError(f'{path} has no attitude{with_rate} to write')
        if kind == _KERNEL:
            _write_text(output.with_suffix('.tsc'), kernel.clock_kernel)
            _write_text(output.with_suffix('.tf'), kernel.frame_kernel)
    return rows.count


def _format_of(output):
    kind = output.suffix
    if kind not in (*_TABLES, *_MESSAGES, _KERNEL):
        formats = ', '.join((*_TABLES, *_MESSAGES, _KERNEL))
        raise ValueError(f'the format of {output} is unknown; allowed: {formats}')
    return kind


def table(path: str | Path) -> Columns:
    """Return the states in a bag as columns (N,) by name, see StateTable; all in memory."""
    states = StateTable(RecordedRun(path))
    blocks = list(states.blocks())
    return {
        name: np.concatenate([np.empty(0, dtype_of(name)), *(block[name] for block in blocks)])
        for name in states.names
    }


def _message_columns(run, kind, options):
    """Return the columns that a message needs; ValueError: the bag does not have them."""
    times = ['t_s', 'stamp_ns', 'segment']
    if kind == '.oem':
        if run.scenario.is_fixed:
            raise ValueError(
                f'{run.bag.path} has orbit.type fixed: the body does not travel, so there is no '
                'orbit to write; .aem and .a hold its attitude'
            )
        return times
    if kind == '.czml' and run.scenario.system.environment is None:
        raise ValueError(
            f'{run.bag.path} has no orbit about the Earth, which a scene of .czml needs; .aem '
            'and .a hold its attitude'
        )
    wanted = {'attitude': Q_IB} | ({'body rate': OMEGA_BI_B} if options.with_rates else {})
    recorded = StateTable(run).names
    for what, columns in wanted.items():
        if not {*columns} <= {*recorded}:
            shown = columns_of_topics(run.scenario.topic_table.values())
            topics = [topic for topic, fields in shown.items() if columns in fields.values()]
            raise ValueError(
                f'{run.bag.path} has not recorded the {what}; record one of the topics '
                f'{", ".join(topics)}'
            )
    return [*times, *(name for columns in wanted.values() for name in columns)]


class _Rows:
    """
    What is written, piece by piece: blocks of a table, or the attitudes in them that are known.

    count: of the rows in those that were taken.
    """

    def __init__(self, pieces: Iterator[Any], size_of: Callable[[Any], int]):
        self.count = 0
        self._pieces, self._size_of = pieces, size_of

    def __iter__(self) -> Iterator[Any]:
        for piece in self._pieces:
            yield piece
            self.count += self._size_of(piece)

    @classmethod
    def of(cls, kind: str, blocks: Iterator[Columns], with_rates: bool) -> '_Rows':
        """Return what is written of a table in a format."""
        if kind in (*_TABLES, '.oem'):
            return cls(blocks, lambda block: len(next(iter(block.values()))))
        return cls(_attitudes(blocks, with_rates), lambda attitudes: len(attitudes.t_s))


def _write_aem(file, table, attitudes, subject, options):
    writer = AemWriter(file, subject, options.with_rates, options.aem_version)
    segment = None
    for rows in attitudes:
        if rows.segment != segment:
            writer.end_segment()
        writer.write(rows.stamps_ns, rows.q_ib, rows.omega_bi_b)
        segment = rows.segment
    writer.end_segment()


def _write_stk(file, table, attitudes, subject, options):
    writer = StkAttitudeWriter(file, subject, options.with_rates)
    for rows in attitudes:
        writer.write(rows.stamps_ns, rows.q_ib, rows.omega_bi_b)
    writer.close()


def _write_oem(file, table, blocks, subject, options):
    writer = OemWriter(file, subject)
    orbit = table.run.scenario.system.orbit
    for block in blocks:
        writer.write(block['stamp_ns'], *orbit.position_velocity(block['t_s']))
    writer.end_segment()


def _write_czml(file, table, attitudes, subject, options):
    scenario = table.run.scenario
    writer = CzmlWriter(file, subject.object_name, scenario['body.box'])
    for rows in attitudes:
        to_itrs, r_t, *ground = scenario.system.environment.on_earth(rows.t_s)
        q_tb = rotation.multiply(rotation.from_matrix(to_itrs), rows.q_ib)
        writer.write(rows.stamps_ns, r_t, q_tb, *ground)
    writer.close()


def _write_ck(writer, attitudes):
    segment = None
    try:
        for rows in attitudes:
            if rows.segment != segment:
                writer.end_segment()
            writer.write(rows.stamps_ns, rows.q_ib, rows.omega_bi_b)
            segment = rows.segment
    finally:
        writer.close()


def _write_text(output, text):
    with _complete(output) as part:
        part.write_text(text, encoding='ascii', newline='\n')


class _Attitudes(NamedTuple):
    """Successive rows of one segment, none of them nan; zero rates where none are written."""

    segment: int
    t_s: np.ndarray
    stamps_ns: np.ndarray
    q_ib: np.ndarray
    omega_bi_b: np.ndarray


def _attitudes(blocks, with_rates):
    """Yield the rows of blocks where attitude, and rate if written, are known, by segment."""
    for block in blocks:
        q_ib = np.stack([block[name] for name in Q_IB], axis=-1)
        omega_bi_b = np.zeros((len(q_ib), 3))
        if with_rates:
            omega_bi_b = np.stack([block[name] for name in OMEGA_BI_B], axis=-1)
        known = ~np.isnan(np.sum(q_ib, axis=-1) + np.sum(omega_bi_b, axis=-1))
        segments = block['segment']
        restarts = np.flatnonzero(np.diff(segments)) + 1
        for rows in np.split(np.arange(len(segments)), restarts):
            rows = rows[known[rows]]
            if len(rows):
                segment = int(segments[rows[0]])
                times = block['t_s'][rows], block['stamp_ns'][rows]
                yield _Attitudes(segment, *times, q_ib[rows], omega_bi_b[rows])


@contextmanager
def _complete(output: Path) -> Iterator[Path]:
    """Yield the path at which to write a file, which gets its name when it is complete."""
    part = output.with_name(f'{output.name}.part')
    try:
        yield part
        os.replace(part, output)
    finally:
        part.unlink(missing_ok=True)


_TABLES = {'.csv': write_csv, '.npz': write_npz, '.parquet': write_parquet}
_MESSAGES = {'.aem': _write_aem, '.oem': _write_oem, '.a': _write_stk, '.czml': _write_czml}
_KERNEL = '.bc'
# Those that name the inertial axes and the attracting body.
_WITH_NAMES = ('.aem', '.oem', '.a')
