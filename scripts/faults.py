"""
Put faults into copies of the package, one line each, and look whether the tests see them.

    python scripts/faults.py            # all of them
    python scripts/faults.py 3 17       # some, by their numbers

For each, the short tests of the room are run, until one fails; then, if none did, all short
tests.  A line is printed that says which test saw it; the exit code is 1 where none did.
"""

import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]


# In a file of the package, what is right and what is wrong.
FAULTS = r"""
dynamics/equations.py
    add(on_body, cross(H, omega))
    add(on_body, cross(omega, H))
dynamics/equations.py
    friction = rotor.friction * s[i]
    friction = rotor.friction * s[i] * s[i]
dynamics/equations.py
    (-v * sin_f, v * cos_f)
    (v * sin_f, v * cos_f)
dynamics/equations.py
    scale(e + cos_f
    scale(cos_f
dynamics/equations.py
    scale(s_i * s_i, turning)
    scale(s_i, turning)
torques/gravity_gradient.py
    - 1.5 * growth_rate
    - 3.0 * growth_rate
torques/magnetic.py
    cross(constants.dipole, B)
    cross(B, constants.dipole)
dynamics/system.py
    K = K - np.asarray
    K = K + np.asarray
orbits/kepler.py
    3.0 * anomaly_rate**2
    3.0 * anomaly_rate
dynamics/integrals.py
    length(system.torque_b) + of_motors
    of_motors
integrate/course.py
    1.5 * orbit.mu / length
    3.0 * orbit.mu / length
integrate/walk.py
    if part < 1.0 and (error <= 1.0
    if part < 0.5 and (error <= 1.0
integrate/propagation.py
    work + course.jumped(t_s)
    work
kernel/rotation.py
    2 * (x * y - w * z)
    2 * (x * y + w * z)
kernel/rotation.py
    [-1.0, -1.0, -1.0, 1.0]
    [-1.0, -1.0, -1.0, -1.0]
trace/graph.py
    return apply('fsub', self, other)
    return apply('fsub', other, self)
environment/earth.py
    side='right') - 1, 0)]
    side='left') - 1, 0)]
environment/earth.py
    return begins_ns[begins_ns > 0]
    return begins_ns
orbits/kepler.py
    return E - e * np.sin(E)
    return E + e * np.sin(E)
orbits/kepler.py
    latitude - true_anomaly
    latitude + true_anomaly
orbits/tle.py
    1e3 * satellite.radiusearthkm
    1e3 * 6378.137
sensors/star_tracker.py
    return self.cross_boresight**2, self.cross_boresight**2
    return self.roll**2, self.cross_boresight**2
sensors/gyro.py
    turn_b=self.turn_b + turn_b
    turn_b=turn_b
run/ticks.py
    round(tick * SECOND_NS / self.rate)
    int(tick * SECOND_NS / self.rate)
actuators/wheels.py
    0.0 < most < abs(held.torque)
    0.0 < most < held.torque
actuators/magnetorquers.py
    max(-m, min(x, m)) + 0.0
    max(-m, min(x, m))
run/run_state.py
    if until <= self.tick
    if until < self.tick
run/events.py
    if until_tick <= tick:
    if until_tick < tick:
run/simulation.py
    isinstance(event, RotorLimited))
    not isinstance(event, RotorLimited))
messages/contents.py
    {'status': {'status': 0}}
    {'status': {'status': -1}}
messages/contents.py
    [-1.0, *[0.0] * 8]
    [0.0, *[0.0] * 8]
messages/cdr.py
    .encode() + b'\0'
    .encode() + b' '
rosbag2/chunk_builder.py
    publish_time=stamp_ns, sequence=0
    publish_time=0, sequence=0
rosbag2/recover.py
    if file.stat().st_size == 0
    if file.stat().st_size == 1
base/key.py
    (number > self.above)
    (number >= self.above)
exchange/aem.py
    np.degrees(rates)
    rates
sweep/variation.py
    low + (high - low) * draws
    low + high * draws
ros/pacing.py
    self._begin_anew = self._begin_anew or self._paused
    pass
ros/inputs.py
    if frame not in ('', body):
    if frame not in ('', body, 'map'):
bag/comparison.py
    max(size, 1.0)
    max(size, 1e9)
"""


class Fault(NamedTuple):
    """A fault: in a file of the package, the text before and after."""

    path: str
    right: str
    wrong: str


def faults() -> list[Fault]:
    """Return all faults."""
    lines = [line.strip() for line in FAULTS.strip().splitlines()]
    return [Fault(*lines[i : i + 3]) for i in range(0, len(lines), 3)]


def tests_of(path: str) -> list[str]:
    """Return the folders of tests of the room that a file of the package is in."""
    return [f'test/{Path(path).parts[0]}']


def seen(fault: Fault, copy: Path) -> str:
    """Return which test of a copy of the project sees a fault; '': none does."""
    file = copy / 'satdyn_ros' / fault.path
    right = file.read_text()
    if right.count(fault.right) < 1:
        raise SystemExit(f'{fault.path} does not have: {fault.right}')
    file.write_text(right.replace(fault.right, fault.wrong, 1))
    variables = os.environ | {'PYTHONPATH': str(copy)}
    try:
        for some in (tests_of(fault.path), ['test']):
            # Which looks for the text of the faults itself.
            but = '--ignore=test/test_faults.py'
            command = [sys.executable, '-m', 'pytest', '-x', '--tb=no', '-n', '2', but, *some]
            done = subprocess.run(
                command, cwd=copy, env=variables, capture_output=True, text=True, check=False
            )
            for line in done.stdout.splitlines():
                if line.startswith(('FAILED ', 'ERROR ')):
                    return line.split(' - ')[0].split(' ', 1)[1]
    finally:
        file.write_text(right)
    return ''


def main() -> int:
    """Try the faults that are named, or all; return the exit code."""
    chosen = [int(number) for number in sys.argv[1:]] or range(1, len(faults()) + 1)
    unseen = 0
    with tempfile.TemporaryDirectory() as name:
        copy = Path(name, 'satdyn_ros')
        ignored = shutil.ignore_patterns('.git', '.venv*', 'build', 'bags', '__pycache__')
        shutil.copytree(ROOT, copy, ignore=ignored)
        for number in chosen:
            fault, begin_s = faults()[number - 1], time.monotonic()
            test = seen(fault, copy)
            unseen += not test
            took_s = time.monotonic() - begin_s
            wrong = ' '.join(fault.wrong.split())
            print(
                f'{number:3} {took_s:5.0f} s  {fault.path}: {wrong}\n    {test or "NOT SEEN"}',
                flush=True,
            )
    print(f'{len(chosen) - unseen} of {len(chosen)} are seen')
    return 1 if unseen else 0


if __name__ == '__main__':
    sys.exit(main())
