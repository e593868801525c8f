"""
Each process that runs tests has its own ROS domain and stays on this machine.

A file of tests that needs a library which package.xml does not declare is skipped where that is
missing.  At the end it is said which long tests were left out and, with --costs, which tests took
longest and what those of each folder took.
"""

import os
import signal
import textwrap
from collections import Counter
from pathlib import Path

import browser as pages
import pytest
from hypothesis import HealthCheck, settings

# A shell starts what runs in the background deaf to Ctrl-C, and children would inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)
os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
os.environ['ROS_DOMAIN_ID'] = str(1 + os.getpid() % 100)

# The same draws each time, however slow the machine is at that moment.  Others: with
# --hypothesis-profile=others --hypothesis-seed=N.
patient = settings(
    deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much]
)
settings.register_profile('others', patient, print_blob=True)
settings.register_profile('same', patient, derandomize=True)
settings.load_profile('same')

TESTS = Path(__file__).parent
# The folders whose files take longest, which begin first.
FIRST = 'watch', 'ros', 'report', 'bag', 'integrate'
# How many long tests of each file were left out.  Of processes side by side each collects all
# tests; the one that started them collects none and learns it from the last that ends.
LEFT_OUT: Counter[str] = Counter()
# What each test took: wall and processor seconds, those of processes that it waited for included.
COSTS: dict[str, list[float]] = {}
_last_cpu_s = 0.0

# What colcon test may run without.
UNDECLARED = {
    *('aiohttp', 'allantools', 'cyclonedds', 'dask', 'distributed', 'erfa', 'gmpy2', 'lz4'),
    *('matplotlib', 'mcap', 'mcap_ros2', 'mpmath', 'ppigrf', 'pyarrow', 'pymsis', 'rosbags'),
    *('setuptools', 'sgp4', 'spiceypy', 'zstandard'),
}


class TestFile(pytest.Module):
    """A file of tests; to be skipped, by the name of the library, where one is missing."""

    def collect(self):
        """Return its tests."""
        try:
            return super().collect()
        except self.CollectError as error:
            missing = (getattr(error.__cause__, 'name', None) or '').split('.')[0]
            if missing in UNDECLARED:
                sentence = f'{self.path.name} needs {missing}, which is not installed'
                pytest.skip(sentence, allow_module_level=True)
            raise


@pytest.fixture(scope='session')
def ros():
    """Take part in ROS, from the first test of this process that does to its last test."""
    import rclpy

    rclpy.init(signal_handler_options=rclpy.signals.SignalHandlerOptions.NO)
    yield
    rclpy.try_shutdown()


@pytest.fixture(scope='session')
def _one_browser():
    driver = pages.start()
    yield driver
    driver.quit()


@pytest.fixture(scope='module')
def browser(_one_browser):
    """Return the browser of this process, which shows nothing when the module's tests end."""
    yield _one_browser
    pages.leave(_one_browser)


def pytest_addoption(parser):
    """Let make test ask for what the tests cost."""
    parser.addoption('--costs', action='store_true', help='say what tests and folders took')


def pytest_collection_finish():
    """Leave what it took to collect the tests out of what the first one took."""
    _cpu_s_since()


def pytest_runtest_makereport(item):
    """Count the processor time from the last report of this process to this one."""
    item.user_properties.append(('cpu_s', _cpu_s_since()))


def _cpu_s_since():
    global _last_cpu_s
    before, _last_cpu_s = _last_cpu_s, sum(os.times()[:4])
    return _last_cpu_s - before


def pytest_runtest_logreport(report):
    """Add up what the set-up, the call and the end of a test took."""
    cost = COSTS.setdefault(report.nodeid, [0.0, 0.0])
    cost[0] += report.duration
    if report.when == 'teardown':
        cost[1] = sum(value for name, value in report.user_properties if name == 'cpu_s')


def pytest_pycollect_makemodule(module_path, parent):
    """Return the collector of a file of tests."""
    return TestFile.from_parent(parent, path=module_path)


def pytest_collection_modifyitems(items):
    """Let the longest files begin first, so that none is left alone at the end."""
    items.sort(key=lambda item: (*FIRST, item.path.parent.name).index(item.path.parent.name))


def pytest_deselected(items):
    """Count the long tests among those that are left out."""
    LEFT_OUT.update(
        item.path.relative_to(TESTS).as_posix().removesuffix('.py').replace('test_', '', 1)
        for item in items
        if item.get_closest_marker('long') and not item.get_closest_marker('torture')
    )


def pytest_sessionfinish(session):
    """Notify the process that started this one."""
    if hasattr(session.config, 'workeroutput'):
        session.config.workeroutput['left_out'] = dict(LEFT_OUT)


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node):
    """Take what a process sends; one that died sends nothing."""
    if left_out := getattr(node, 'workeroutput', {}).get('left_out'):
        LEFT_OUT.clear()
        LEFT_OUT.update(left_out)


def pytest_terminal_summary(terminalreporter, config):
    """Say what was left out, and what runs it; what the tests took, if it is asked for."""
    if config.getoption('costs'):
        write_costs(terminalreporter.write_line)
    if LEFT_OUT:
        # No line ends between a file and its count.
        files = ', '.join(f'{file}\xa0{count}' for file, count in sorted(LEFT_OUT.items()))
        terminalreporter.write_line(
            f'{LEFT_OUT.total()} long tests were left out, which make test-all runs:'
        )
        lines = textwrap.fill(files, 95, break_on_hyphens=False).replace('\xa0', ' ')
        terminalreporter.write_line(lines)


def write_costs(write_line):
    """Write the 25 slowest tests, and the sum of each folder."""
    folders: dict[str, list[float]] = {}
    for test, cost in COSTS.items():
        parts = test.partition('::')[0].split('/')
        total = folders.setdefault('/'.join(parts[:2]), [0.0, 0.0, 0.0])
        for i, each in enumerate((1, *cost)):
            total[i] += each
    write_line('wall s   CPU s  the slowest tests')
    for test, (wall_s, cpu_s) in sorted(COSTS.items(), key=lambda item: -item[1][0])[:25]:
        write_line(f'{wall_s:6.1f}  {cpu_s:6.1f}  {test}')
    write_line('wall s   CPU s  tests  folder')
    for folder, (count, wall_s, cpu_s) in sorted(folders.items(), key=lambda item: -item[1][1]):
        write_line(f'{wall_s:6.0f}  {cpu_s:6.0f}  {count:5.0f}  {folder}')
