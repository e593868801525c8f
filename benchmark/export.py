"""Bags to tables: what writing adds to reading, and the memory of a week in every format."""

import os
import statistics
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

from common import ARGUMENTS, QUICK, Claim, printed_mb, show

from satdyn_ros.bag.columns import StateTable
from satdyn_ros.bag.export import export
from satdyn_ros.bag.read_run import RecordedRun
from satdyn_ros.bag.simulate import simulate
from satdyn_ros.run.scenario import Scenario

DAY_S, WEEK_DAYS = 600.0 if QUICK else 86400.0, 7
MEMORY_MB = 400.0
SCENARIO = Scenario.from_dict(
    {
        'publish': {
            'rate': 10.0,
            'topics': [
                *('attitude', 'angular_velocity', 'imu'),
                *('odometry', 'attitude_lvlh', 'gravity_gradient'),
            ],
        },
        'time': {'epoch_ns': 10**18},
    }
)
TABLES = ('csv', 'parquet', 'npz')
MESSAGES = ('aem', 'oem', 'a')


def recorded(days: float, bag: Path) -> Path:
    """Simulate days into a bag and return it."""
    for _ in simulate(SCENARIO, days * DAY_S, bag):
        pass
    return bag


def read(bag: Path) -> None:
    """Read a bag and make the columns: what no table can save."""
    for _ in StateTable(RecordedRun(bag)).blocks():
        pass


def written(bag: Path, kind: str) -> int:
    """Export a bag into a file beside it, remove the file and return its size."""
    output = bag.with_name(f'table.{kind}')
    export(bag, output)
    size = output.stat().st_size
    output.unlink()
    return size


def bare(size: int, path: Path) -> None:
    """Write so many bytes and nothing else, into a file that is then removed."""
    data = bytes(2**21)
    with open(path, 'xb', buffering=0) as file:
        for begin in range(0, size, len(data)):
            file.write(data[: size - begin])
    path.unlink()


class Cost(NamedTuple):
    """What a run costs [s]: elapsed time, and CPU time in the process and in the kernel for it."""

    wall: float
    user: float
    kernel: float

    @property
    def cpu(self) -> float:
        """All CPU time."""
        return self.user + self.kernel


def cost(run: Callable[[], object]) -> Cost:
    """Return the cost of a run."""
    begin = os.times()
    run()
    end = os.times()
    return Cost(end.elapsed - begin.elapsed, end.user - begin.user, end.system - begin.system)


def memory_mb(bag: Path, kind: str) -> float:
    """Return the peak memory of a process that exports a bag."""
    return printed_mb(
        'from pathlib import Path; import export; export.written(Path(sys.argv[1]), sys.argv[2]);'
        'print(common.peak_memory_kb())',
        bag,
        kind,
    )


def main(rounds: int = 5) -> tuple[str, list[Claim], str]:
    """Run all; return title, claims and text."""
    with tempfile.TemporaryDirectory() as name:
        bag = recorded(1.0, Path(name) / 'day')
        size, path = written(bag, 'csv'), bag.with_name('bytes')
        contenders: dict[str, Callable[[], object]] = {
            'read': lambda: read(bag),
            **{kind: partial(written, bag, kind) for kind in TABLES},
            'the bytes of the .csv alone': lambda: bare(size, path),
            'the same again at once': lambda: bare(size, path),
        }
        for run in contenders.values():
            run()
        taken: dict[str, list[Cost]] = {contender: [] for contender in contenders}
        for _ in range(1 if QUICK else rounds):
            for contender, run in contenders.items():
                taken[contender].append(cost(run))
    medians = {
        contender: Cost(*map(statistics.median, zip(*costs, strict=True)))
        for contender, costs in taken.items()
    }
    with tempfile.TemporaryDirectory() as name:
        bag = recorded(WEEK_DAYS, Path(name) / 'week')
        peaks = {kind: memory_mb(bag, kind) for kind in (*TABLES, *MESSAGES)}
    claims = [
        Claim(
            f'a day at 10 Hz as .{kind}, over reading it and making its columns ({name})',
            f'{of(medians[kind]):.2f} s',
            f'{of(medians["read"]):.2f} s',
            of(medians[kind]) / of(medians['read']),
            must=None if kind == 'npz' else must,
            at_most=True,
        )
        for kind in TABLES
        for name, of, must in (
            ('wall', lambda cost: cost.wall, 1.5),
            ('CPU, both cores', lambda cost: cost.cpu, None),
        )
    ] + [
        Claim(
            f'memory of a week at 10 Hz as .{kind}',
            f'{peak:.0f} MB',
            f'{MEMORY_MB:.0f} MB allowed',
            peak / MEMORY_MB,
            must=1.0,
            at_most=True,
        )
        for kind, peak in peaks.items()
    ]
    rows = ['| | wall | CPU | of it the kernel |', '| --- | --- | --- | --- |']
    rows += [
        f'| {contender} | {each.wall:.2f} s | {each.cpu:.2f} s | {each.kernel:.2f} s |'
        for contender, each in medians.items()
    ]
    text = '\n'.join(rows) + (
        '\n\nWhat must hold is the time.  The next rows of a .csv or .parquet are read while the '
        "last are written, on another core.  The kernel's part is mostly that of writing the "
        'bytes, whoever writes them.  Where the memory for them must first be had from the host '
        'of a virtual machine it is many times what it is at once after, as the last two lines '
        'show.'
    )
    print(text)
    return 'Export', show(claims), text


if __name__ == '__main__':
    main(*map(int, ARGUMENTS))
