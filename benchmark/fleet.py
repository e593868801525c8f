"""Satellites in one process, at 10 Hz with recording on one core: late ticks, CPU and memory."""

import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from common import QUICK, Claim, show
from live import ENVIRONMENT, cpu_s

from satdyn_ros.bag.verify import verify
from satdyn_ros.rosbag2.reader import Bag

RATE_HZ = 10
FLEET, LARGE = (2, 3) if QUICK else (20, 100)
SECONDS = 1.0 if QUICK else 30.0
# How much memory a further satellite may take.
LARGEST_MB = 20.0
# At 10 Hz a lag is longer than the period from the decade up to 1 s on.
LATE = re.compile(r'(\d+) (?:up to 1 s|up to 10 s|above 10 s)')

COMMON = f"""
/**:
  ros__parameters:
    publish: {{rate: {RATE_HZ}.0}}
    record: {{enabled: true}}
"""
SATELLITE = """
/sat{number}/satdyn:
  ros__parameters:
    orbit: {{true_anomaly: {anomaly}}}
"""


@dataclass(frozen=True)
class Flight:
    """
    What satellites in one process took.

    cores: the share of a processor.  missing: ticks that a bag lacks between its first and last.
    late: ticks that came more than a period after their deadline, of all ticks.
    """

    cores: float
    memory_mb: float
    start_s: float
    end_s: float
    ticks: int
    missing: int
    late: int


def fly(count: int) -> Flight:
    """Return what a number of satellites took; RuntimeError: not all bags are true."""
    with tempfile.TemporaryDirectory() as name:
        directory = Path(name)
        sections = [SATELLITE.format(number=i, anomaly=0.06 * i) for i in range(count)]
        (directory / 'fleet.yaml').write_text(COMMON + ''.join(sections))
        command = ['-m', 'satdyn_ros.cli.main', 'node', '--params-file', 'fleet.yaml']
        log_path = directory / 'log'
        with log_path.open('w') as log:
            begin_s = time.monotonic()
            process = subprocess.Popen(
                [sys.executable, *command],
                cwd=directory,
                env=ENVIRONMENT,
                stderr=log,
                preexec_fn=lambda: os.sched_setaffinity(0, {max(os.sched_getaffinity(0))}),
            )
            while log_path.read_text().count(': publishing') < count:
                if process.poll() is not None:
                    raise RuntimeError(log_path.read_text())
                time.sleep(0.1)
            start_s = time.monotonic() - begin_s
            # Until tick 0 has come.
            time.sleep(0.1 * count)
            used_s, begin_s = cpu_s(process.pid), time.monotonic()
            time.sleep(SECONDS)
            used_s, passed_s = cpu_s(process.pid) - used_s, time.monotonic() - begin_s
            status = Path(f'/proc/{process.pid}/status').read_text()
            begin_s = time.monotonic()
            process.send_signal(signal.SIGINT)
            if process.wait(600.0) != 0:
                raise RuntimeError(log_path.read_text())
            end_s = time.monotonic() - begin_s
        reports = [line for line in log_path.read_text().splitlines() if ']: lateness' in line]
        missing = ticks = 0
        bags = sorted(directory.glob('**/metadata.yaml'))
        if len(bags) != count or len(reports) != count:
            raise RuntimeError(f'{count} satellites flew, with {len(bags)} bags')
        for metadata in bags:
            bag = Bag(metadata.parent)
            (topic,) = (name for name in bag.topics if name.endswith('/attitude'))
            stamps_ns = bag.messages(topic).log_times_ns
            numbers = np.rint((stamps_ns - stamps_ns[0]) * (RATE_HZ * 1e-9))
            ticks += len(numbers)
            missing += int(numbers[-1]) + 1 - len(numbers)
        if not verify(bags[-1].parent).is_true:
            raise RuntimeError(f'{bags[-1].parent} is not true')
    return Flight(
        cores=used_s / passed_s,
        memory_mb=int(status.split('VmRSS:')[1].split()[0]) / 1024.0,
        start_s=start_s,
        end_s=end_s,
        ticks=ticks,
        missing=missing,
        late=sum(int(number) for line in reports for number in LATE.findall(line)),
    )


def main() -> tuple[str, list[Claim], str]:
    """Run all; return title, claims and text."""
    alone, fleet, large = fly(1), fly(FLEET), fly(LARGE)
    further_mb = (fleet.memory_mb - alone.memory_mb) / (FLEET - 1)
    claims = [
        Claim(
            f'ticks missing in the bags of {FLEET} satellites at {RATE_HZ} Hz, on one core',
            f'{fleet.missing}',
            f'of {fleet.ticks}',
            fleet.missing,
            0.0,
            at_most=True,
        ),
        Claim(
            'ticks of these that came more than a period late',
            f'{fleet.late}',
            f'of {fleet.ticks}',
            fleet.late,
            0.0,
            at_most=True,
        ),
        Claim(
            f'memory of each further satellite over {LARGEST_MB:g} MB, beside that of the first',
            f'{further_mb:.1f} MB',
            f'{alone.memory_mb:.0f} MB',
            further_mb / LARGEST_MB,
            1.0,
            at_most=True,
        ),
        Claim(
            f'CPU of {FLEET} satellites in one process over that of as many processes',
            f'{fleet.cores:.3f} cores',
            f'{FLEET * alone.cores:.3f} cores',
            fleet.cores / (FLEET * alone.cores),
            at_most=True,
        ),
    ]
    text = '\n'.join(
        f'- {count} satellites: {flight.memory_mb:.0f} MB, {flight.cores:.2f} of a core, '
        f'{flight.late} of {flight.ticks} ticks more than a period late, {flight.missing} '
        f'missing; they flew after {flight.start_s:.1f} s and ended within {flight.end_s:.1f} s'
        for count, flight in ((1, alone), (FLEET, fleet), (LARGE, large))
    )
    print(text)
    return 'Fleet', show(claims), text


if __name__ == '__main__':
    main()
