"""Tables written block by block, so that memory does not grow with their rows."""

import csv
import shutil
import tempfile
import zipfile
from collections.abc import Generator, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing
from pathlib import Path

import numpy as np

from ..base.interruption import uninterrupted
from .columns import Columns, dtype_of

_COPY_BYTES = 2**20
# Rows that polars prints at once; with a quarter, its own choice, an export costs a tenth more.
_CSV_ROWS = 4096


def write_csv(path: Path, names: Sequence[str], blocks: Iterable[Columns]) -> None:
    """Write comma-separated values that read back bit for bit, by polars if it is installed."""
    try:
        import polars
    except ImportError:
        _write_csv_without_polars(path, names, blocks)
        return
    with open(path, 'wb') as file, closing(read_ahead(blocks)) as blocks:
        polars.DataFrame(schema=names).write_csv(file)
        for block in blocks:
            polars.DataFrame(block).write_csv(
                file, include_header=False, quote_style='never', batch_size=_CSV_ROWS
            )


def _write_csv_without_polars(path, names, blocks):
    with open(path, 'w', newline='', encoding='utf-8') as file:
        writer = csv.writer(file, lineterminator='\n')
        writer.writerow(names)
        for block in blocks:
            columns = (column.tolist() for column in block.values())
            writer.writerows(zip(*columns, strict=True))


def write_npz(path: Path, names: Sequence[str], blocks: Iterable[Columns]) -> None:
    """
    Write an archive as numpy.savez does, a member for each column.

    A member stands in one piece, so the columns grow in files beside it first.
    """
    with ExitStack() as stack:
        files = {
            name: stack.enter_context(tempfile.TemporaryFile(dir=path.parent)) for name in names
        }
        rows = 0
        for block in blocks:
            for name, values in block.items():
                files[name].write(np.ascontiguousarray(values, dtype_of(name)).data)
            rows += len(next(iter(block.values())))
        archive = stack.enter_context(zipfile.ZipFile(path, 'w'))
        for name, file in files.items():
            header = {'descr': dtype_of(name).str, 'fortran_order': False, 'shape': (rows,)}
            file.seek(0)
            with archive.open(f'{name}.npy', 'w', force_zip64=True) as member:
                np.lib.format.write_array_header_1_0(member, header)
                shutil.copyfileobj(file, member, _COPY_BYTES)


def write_parquet(path: Path, names: Sequence[str], blocks: Iterable[Columns]) -> None:
    """Write a Parquet file, a row group for each block; ValueError: pyarrow is not installed."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError as error:
        raise ValueError(
            'a .parquet file needs pyarrow: pip install pyarrow; .csv and .npz do not'
        ) from error
    schema = _schema(names)
    # Doubles hardly repeat, so a dictionary costs time and saves nothing; their bytes, split by
    # significance, compress to two thirds.
    floats = [name for name in names if dtype_of(name).kind == 'f']
    writer = pyarrow.parquet.ParquetWriter(
        path,
        schema,
        compression='zstd',
        compression_level=1,
        use_dictionary=False,
        use_byte_stream_split=floats,
    )
    with writer, closing(read_ahead(blocks)) as blocks:
        for block in blocks:
            writer.write_batch(pyarrow.record_batch(list(block.values()), schema=schema))


def _schema(names):
    import pyarrow

    return pyarrow.schema([(name, pyarrow.from_numpy_dtype(dtype_of(name))) for name in names])


def read_ahead(blocks: Iterable[Columns]) -> Generator[Columns, None, None]:
    """
    Yield blocks, in order; the next one is read in a thread while the caller writes one.

    For a writer whose library leaves Python's lock alone.
    """
    left = iter(blocks)
    thread = ThreadPoolExecutor(max_workers=1)
    try:
        # An exception within the executor's functions could leave a lock taken, for which its
        # thread would wait for ever: interruptions act between them.
        with uninterrupted():
            reading = thread.submit(next, left, None)
        while True:
            with uninterrupted():
                block = reading.result()
                if block is None:
                    return
                reading = thread.submit(next, left, None)
            yield block
    finally:
        with uninterrupted():
            thread.shutdown()
