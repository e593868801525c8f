"""The package says what it needs, and installs everything it ships."""

import ast
import importlib
import re
import sys
from pathlib import Path
from xml.etree import ElementTree

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


def test_commands_exist(distribution):
    """What the console scripts call is there."""
    for script in distribution.entry_points['console_scripts']:
        module, function = script.split('=')[1].strip().split(':')
        assert callable(getattr(importlib.import_module(module), function))
