"""The package says what it needs, and installs everything it ships."""

import ast
import importlib
import re
import shutil
import subprocess
import sys
import tarfile
from pathlib import Path
from xml.etree import ElementTree
from zipfile import ZipFile

import pytest
import setuptools  # noqa: F401  (it brings distutils, which Python 3.12 has no more)

import satdyn_ros

ROOT = Path(__file__).parent.parent

# What is imported under another name than the one it is installed by.
PROVIDES = {'pyerfa': {'erfa'}, 'pyyaml': {'yaml'}}


@pytest.fixture
def distribution(monkeypatch):
    from distutils.core import run_setup

    monkeypatch.chdir(ROOT)
    return run_setup('setup.py', stop_after='init')


@pytest.fixture
def manifest():
    return ElementTree.parse(ROOT / 'package.xml').getroot()


def imported_by(path):
    """Return the top-level names that a file imports, wherever in it."""
    tree = ast.parse(path.read_text())
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name.split('.')[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            yield node.module.split('.')[0]


def importable(requirements):
    """Return the top-level names that the requirements bring."""
    names = [re.findall(r'^[\w-]+', line)[0].lower() for line in requirements]
    return set().union(*(PROVIDES.get(name, {name}) for name in names))


def test_manifest_and_setup_agree(distribution, manifest):
    """What colcon reads and what pip reads describe the same package."""
    assert manifest.get('format') == '3'
    assert manifest.findtext('name') == distribution.get_name()
    assert manifest.findtext('version') == distribution.get_version() == satdyn_ros.__version__
    assert manifest.findtext('license') == distribution.get_license()
    # That of the package first; then those of what is bundled, each by its file.
    texts = {path: path.read_text() for path in (ROOT / 'satdyn_ros').rglob('bundled/*.LICENSE')}
    of_mit = {path for path, text in texts.items() if 'The MIT License' in text}
    assert of_mit
    assert {ROOT / e.get('file', ''): e.text for e in manifest.iter('license')} == {
        ROOT / 'LICENSE': 'Apache-2.0',
        **dict.fromkeys(of_mit, 'MIT'),
    }
    patterns = distribution.metadata.license_files
    in_wheel = {path for pattern in patterns for path in ROOT.glob(pattern)}
    assert in_wheel == {ROOT / 'LICENSE', *texts}
    assert 'License :: OSI Approved :: MIT License' in distribution.get_classifiers()
    assert manifest.findtext('author') == distribution.get_author()
    assert {url.get('type') for url in manifest.iter('url')} == {
        *('website', 'repository', 'bugtracker')
    }
    assert manifest.findtext('export/build_type') == 'ament_python'


def test_the_version_is_the_same_everywhere():
    """The newest version of the changelog, with its date, and the citation are of the package."""
    changelog = (ROOT / 'CHANGELOG.rst').read_text()
    # The form of REP 132: a line of the version and its date, underlined as long.
    sections = re.findall(
        r'^(\d+\.\d+\.\d+) \((\d{4}-\d\d-\d\d)\)\n(-+)$', changelog, re.MULTILINE
    )
    version, date, line = sections[0]
    assert version == satdyn_ros.__version__
    assert len(line) == len(f'{version} ({date})')
    assert f'\nversion: {version}\n' in (ROOT / 'CITATION.cff').read_text()


def test_every_import_is_declared(distribution, manifest):
    """Whoever installs the package with the fitting extras can import every module of it."""
    declared = importable(distribution.install_requires)
    for extra in ('environment', 'gym', 'plot', 'spice', 'sweep', 'tables', 'watch'):
        declared |= importable(distribution.extras_require[extra])
    declared |= {node.text for node in manifest.iter('exec_depend')}
    files = [*(ROOT / 'satdyn_ros').rglob('*.py'), *(ROOT / 'launch').glob('*.py')]
    undeclared = {
        (str(path.relative_to(ROOT)), name)
        for path in files
        for name in imported_by(path)
        if name not in sys.stdlib_module_names and name not in declared | {'satdyn_ros'}
    }
    assert not undeclared


def test_everything_shipped_is_installed(distribution):
    """No launch file, configuration or example is left out of share/satdyn_ros."""
    installed = {file for _, files in distribution.data_files for file in files}
    shipped = {
        str(path.relative_to(ROOT))
        for folder in ('launch', 'config', 'msg_examples')
        for path in (ROOT / folder).rglob('*.*')
        if path.suffix != '.pyc'
    }
    assert shipped <= installed
    assert {'package.xml', 'resource/satdyn_ros'} <= installed


def test_data_beside_the_modules_is_installed(distribution):
    """Every file among the modules that is not a module is package data."""
    patterns = distribution.package_data['']
    packages = [path.parent for path in (ROOT / 'satdyn_ros').rglob('__init__.py')]
    beside = {
        path
        for path in (ROOT / 'satdyn_ros').rglob('*')
        if path.is_file() and path.suffix != '.py' and '__pycache__' not in path.parts
    }
    packed = {path for package in packages for name in patterns for path in package.glob(name)}
    assert beside - packed == set()


def test_every_folder_of_modules_is_a_package(distribution):
    """A folder without __init__.py would be missing after a plain install."""
    folders = {path.parent.relative_to(ROOT) for path in (ROOT / 'satdyn_ros').rglob('*.py')}
    assert {'.'.join(folder.parts) for folder in folders} == set(distribution.packages)


def build(kind, folder, out):
    """Build a distribution of a folder as pip does, and return its path."""
    done = subprocess.run(
        [sys.executable, '-c', f'from setuptools.build_meta import *; build_{kind}({str(out)!r})'],
        cwd=folder,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    [path] = out.iterdir()
    return path


def test_what_is_built_holds_what_the_commit_holds(tmp_path):
    """The source distribution has every file that git knows; both give the same wheel."""
    pytest.importorskip('setuptools', '70.1', reason='it builds no wheel by itself')
    if not (ROOT / '.git').exists():
        pytest.skip('no checkout of git')
    listed = subprocess.run(
        ['git', 'ls-files', '-z', '--cached', '--others', '--exclude-standard'],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    files = {name for name in listed.stdout.split('\0') if name and (ROOT / name).exists()}
    checkout = tmp_path / 'checkout'
    for name in files:
        (checkout / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, checkout / name)
    for name in ('sdist', 'wheel', 'wheel_of_sdist'):
        (tmp_path / name).mkdir()
    with tarfile.open(build('sdist', checkout, tmp_path / 'sdist')) as archive:
        packed = {info.name.partition('/')[2] for info in archive if info.isfile()}
        archive.extractall(tmp_path, filter='data')
    added = {name for name in packed if name.startswith('satdyn_ros.egg-info/')} | {'PKG-INFO'}
    assert packed - added == files
    with (
        ZipFile(build('wheel', checkout, tmp_path / 'wheel')) as wheel,
        ZipFile(
            build(
                'wheel',
                tmp_path / f'satdyn_ros-{satdyn_ros.__version__}',
                tmp_path / 'wheel_of_sdist',
            )
        ) as wheel_of_sdist,
    ):
        assert sorted(wheel.namelist()) == sorted(wheel_of_sdist.namelist())
        # Nothing of what a test or a page needs alone lies in the folder of all packages.
        assert {name.split('/')[0] for name in wheel.namelist()} == {
            'satdyn_ros',
            f'satdyn_ros-{satdyn_ros.__version__}.data',
            f'satdyn_ros-{satdyn_ros.__version__}.dist-info',
        }


def test_commands_exist(distribution):
    """What the console scripts call is there."""
    for script in distribution.entry_points['console_scripts']:
        module, function = script.split('=')[1].strip().split(':')
        assert callable(getattr(importlib.import_module(module), function))
