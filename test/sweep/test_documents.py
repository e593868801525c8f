"""What the documents show of sweep files is what the code reads."""

import re
import shutil
from pathlib import Path

import pytest
import yaml

from satdyn_ros.run.keys import KEYS as SCENARIO_KEYS
from satdyn_ros.sweep import quantities, sweep_keys, variation
from satdyn_ros.sweep.plan import Plan
from satdyn_ros.sweep.quantities import quantity

ROOT = Path(__file__).parents[2]
SCENARIO = ROOT / 'config' / 'gravity_gradient_boom.yaml'


def read(folder, text):
    """Return the keys of a sweep file's text and its plan, the scenario put in place."""
    given = yaml.safe_load(text)
    shutil.copy(ROOT / 'examples' / 'controllers' / 'b_dot.py', folder)
    path = folder / 'sweep.yaml'
    path.write_text(yaml.safe_dump(given | {'scenario': str(SCENARIO)}, sort_keys=False))
    return given, Plan.from_yaml(path)


def test_the_help_shows_a_sweep_file(tmp_path, capsys):
    """`satdyn sweep --help` has a file with every key and every way to vary, and it is read."""
    from satdyn_ros.cli.main import main

    with pytest.raises(SystemExit):
        main(['sweep', '--help'])
    said = capsys.readouterr().out
    (text,) = re.findall(r'\n  scenario: .*?\n\n', said, re.DOTALL)
    given, plan = read(tmp_path, text)
    assert set(given) == set(sweep_keys.SWEEP_KEYS)
    assert len(plan) == 4 * 2 * 100
    ways = {how if isinstance(how, str) else next(iter(how)) for how in given['vary'].values()}
    assert ways == {form.strip('{').split(':')[0] for form in variation.WAYS}


def test_the_example_of_the_page(tmp_path):
    """The page's example is the shipped file."""
    page = (ROOT / 'docs' / 'sweeps.md').read_text()
    shipped = (ROOT / 'config' / 'sweeps' / 'monte_carlo.yaml').read_text()
    (text,) = re.findall('```yaml\n(.*?)```', page, re.DOTALL)
    given, plan = read(tmp_path, text)
    assert given == yaml.safe_load(shipped)
    assert len(plan) == 2000


def test_every_name_of_the_table_is_a_quantity():
    """Groups, components, angles and ratios are known by the names that are read."""
    names = re.findall('`([^`]+)`', ' '.join(quantities.QUANTITY_FORMS))
    for name in names:
        group, star = name[:-2], name.endswith('.*')
        if star:
            keys = [key for key in SCENARIO_KEYS if key.startswith(group + '.')]
            assert all(quantity(key) for key in keys if key != 'rotor.names')
        else:
            quantity(name.replace('KEY', 'body.inertia'))
    found = {name[:-2] for name in names if name.endswith('.*')}
    assert found == {'body', 'rotor', 'orbit', 'initial', 'motion'}
