"""What the benchmarks share: contenders in turn, medians of CPU time, a table of ratios."""

import multiprocessing
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

# Whether to do little and only once: enough to see that a benchmark runs, too little to measure.
# Processes of a pool have the arguments of the one that starts them.
QUICK = '--quick' in sys.argv
ARGUMENTS = [argument for argument in sys.argv[1:] if argument != '--quick']

Name = TypeVar('Name')


@dataclass(frozen=True)
class Claim:
    """
    One line of the results: peer over ours, and what it must reach.

    at_most: ours over peer instead, and what it must stay below.  must: None where nothing is
    required, and the two are only shown side by side.
    """

    what: str
    ours: str
    peer: str
    ratio: float
    must: float | None = None
    aim: float | None = None
    at_most: bool = False

    def row(self) -> str:
        """Return the claim as a row of a Markdown table."""
        if self.must is None:
            return f'| {self.what} | {self.ours} | {self.peer} | {self.ratio:.3g} | | |'
        bound = f'{"at most" if self.at_most else "at least"} {self.must:g}'
        aim = '' if self.aim is None else f', aim {self.aim:g}'
        holds = self.ratio <= self.must if self.at_most else self.ratio >= self.must
        verdict = 'yes' if holds else '**no**'
        return (
            f'| {self.what} | {self.ours} | {self.peer} | {self.ratio:.3g} | {bound}{aim} '
            f'| {verdict} |'
        )


HEADER = '| what | ours | peer | ratio | must | holds |\n| --- | --- | --- | --- | --- | --- |'


def medians(contenders: Mapping[Name, Callable[[], object]], rounds: int = 7) -> dict[Name, float]:
    """
    Return each contender's median CPU seconds over rounds in which all take turns.

    One that measures itself, because it needs preparation or is another process, returns a float,
    which is used instead.
    """
    if QUICK:
        rounds = 1
    else:
        for run in contenders.values():
            run()
    seconds: dict[Name, list[float]] = {name: [] for name in contenders}
    for _ in range(rounds):
        for name, run in contenders.items():
            begin = time.process_time()
            own = run()
            passed = time.process_time() - begin
            seconds[name].append(own if isinstance(own, float) else passed)
    return {name: statistics.median(values) for name, values in seconds.items()}


def one_and_two_cores(
    what: str, run: Callable[[ProcessPoolExecutor], object], must: float, rounds: int = 9
) -> Claim:
    """
    Return how much sooner run(pool) is done with two processes than with one (wall).

    They are started before.  One and two take turns, and the ratio is the median of neighbours':
    the machine may become faster or slower from round to round.
    """
    spawn = multiprocessing.get_context('spawn')
    seconds: dict[int, list[float]] = {1: [], 2: []}
    with ProcessPoolExecutor(1, spawn) as one, ProcessPoolExecutor(2, spawn) as two:
        for _ in range(2 if QUICK else rounds + 1):
            for cores, pool in ((1, one), (2, two)):
                begin = time.perf_counter()
                run(pool)
                seconds[cores].append(time.perf_counter() - begin)
    # In the first round they load their code.
    ones, twos = seconds[1][1:], seconds[2][1:]
    return Claim(
        f'{what}, two cores against one (wall)',
        milliseconds(statistics.median(twos)),
        milliseconds(statistics.median(ones)),
        statistics.median(one / two for one, two in zip(ones, twos, strict=True)),
        must,
    )


def peak_memory_kb() -> int:
    """Return the most memory that this process has had."""
    # Not ru_maxrss, which a process begins with that of the one that starts it.
    return int(Path('/proc/self/status').read_text().split('VmHWM:')[1].split()[0])


def printed_mb(program: str, *arguments: object) -> float:
    """Return as MB the kB that a Python program prints, which imports what is in this folder."""
    begin = f'import sys; sys.path.insert(0, {str(Path(__file__).parent)!r}); import common; '
    output = subprocess.run(
        [sys.executable, '-c', begin + program, *map(str, arguments)],
        stdout=subprocess.PIPE,
        check=True,
    ).stdout
    return int(output) / 1024.0


def milliseconds(seconds: float) -> str:
    """Return seconds as a text in milliseconds."""
    return f'{seconds * 1e3:.3g} ms'


def show(claims: list[Claim]) -> list[Claim]:
    """Print claims as a table and return them."""
    if QUICK:
        print('Quick: less work than it says, done once; the figures mean nothing.')
    print(HEADER)
    for claim in claims:
        print(claim.row())
    return claims
