"""The memory and disk space of a sweep: one that cannot finish is refused before it starts."""

import math
import os
import shutil
from pathlib import Path

from .plan import Plan

# Bytes per sample at the peak of a run's evaluation; bytes in the table per run and kept sample.
_MEMORY_OF_SAMPLE = 400
_DISK_OF_RUN = 200
_DISK_OF_SAMPLE = 56


def check_resources(plan: Plan, directory: Path) -> None:
    """Raise ValueError, one sentence, where memory or the disk cannot hold what a sweep needs."""
    samples = math.ceil(plan.duration_s / plan.interval_s) + 1
    memory, has = _MEMORY_OF_SAMPLE * samples, _memory()
    if memory > has:
        raise ValueError(
            f'a run of this sweep has {samples} samples and needs {_size(memory)} of memory, '
            f'and this machine has {_size(has)}; a larger interval_s needs less'
        )
    # The parts and the table made of them exist side by side.
    of_run = _DISK_OF_RUN + (_DISK_OF_SAMPLE * samples if plan.keeps_samples else 0)
    disk, free = 2 * of_run * len(plan), shutil.disk_usage(_existing(directory)).free
    if disk > free:
        raise ValueError(
            f'the table of this sweep, {len(plan)} runs'
            f'{f" of {samples} samples" if plan.keeps_samples else ""}, needs about '
            f'{_size(disk)}, and {directory} has {_size(free)} free'
        )


def _memory():
    return os.sysconf('SC_PAGE_SIZE') * os.sysconf('SC_PHYS_PAGES')


def _existing(directory):
    """Return the directory, or the nearest one above it that exists."""
    directory = directory.absolute()
    return next(path for path in (directory, *directory.parents) if path.exists())


def _size(count):
    power = min(int(math.log2(count)) // 10, 4) if count > 0 else 0
    return f'{count / 1024**power:.1f} {("B", "KiB", "MiB", "GiB", "TiB")[power]}'
