"""Thrusters in plots and pages: what is drawn of a bag in which they fired."""

import base64
import json

import numpy as np
import pytest
import yaml
from cases import REFERENCE

from satdyn_ros.bag.simulate import simulate
from satdyn_ros.report.history import history
from satdyn_ros.report.plot import draw
from satdyn_ros.report.scene import of_history
from satdyn_ros.run.events import from_yaml_text
from satdyn_ros.run.scenario import Scenario

CASES = {
    case['name']: case for case in json.loads((REFERENCE / 'thrusters.json').read_text())['cases']
}


def recorded(name, folder):
    """Return the history of a reference case, flown to its last state."""
    case = CASES[name]
    scenario = Scenario.from_dict(case['scenario'])
    given = from_yaml_text(yaml.safe_dump(case['events']), scenario)
    end_s = case['states'][-1]['t']
    ticks = round(end_s * case['scenario']['publish']['rate']) + 1
    for _ in simulate(scenario, str(ticks / scenario.rate), folder / name, given):
        pass
    return history(folder / name)


@pytest.mark.parametrize('name', CASES)
def test_the_bars_are_when_the_valves_are_open(name, tmp_path):
    """As another program says, to rounding, whatever the ticks; one that stays open is one bar."""
    run = recorded(name, tmp_path)
    for thruster, intervals in CASES[name]['valve_open'].items():
        # A valve that a command keeps open has not closed in between.
        joined: list[list[float]] = []
        for begin_s, end_s in intervals:
            if joined and abs(joined[-1][1] - begin_s) < 1e-9:
                joined[-1][1] = end_s
            else:
                joined.append([begin_s, end_s])
        np.testing.assert_allclose(run.valves_open[thruster], joined, rtol=0.0, atol=1e-12)


def test_a_figure_has_a_bar_for_each_pulse(tmp_path):
    """In a row of its name each, in the order of the scenario."""
    pytest.importorskip('matplotlib')
    run = recorded('thruster_four_trains', tmp_path)
    (axes,) = draw(run, ['thruster']).axes
    names = [label.get_text() for label in axes.get_yticklabels()]
    assert names == CASES['thruster_four_trains']['scenario']['thruster']['names']
    bars = [len(each.get_paths()) for each in axes.collections]
    assert bars == [len(run.valves_open[name]) for name in names]


def test_the_page_has_nozzles_thrust_and_propellant(tmp_path):
    """The table's propellant is the reference's; the mean thrust of a tick is of what it fired."""
    run = recorded('thruster_propellant', tmp_path)
    description, table = of_history(run)
    case = CASES['thruster_propellant']
    given = case['scenario']['thruster']
    assert [each['name'] for each in description['nozzles']] == given['names']
    for each in description['nozzles']:
        assert each['thrust'] == given[each['name']]['thrust']
        assert np.abs(each['position']).max() <= 0.5
    (panel,) = (each for each in description['panels'] if each['name'] == 'thruster')
    assert panel['lines'] == given['names']

    def column(name):
        packed = table['columns'][name]
        values = np.frombuffer(base64.b64decode(packed['float32']), '<f4')
        return values.reshape(-1, packed['width'])

    used = dict(zip(given['names'], column('propellant')[-1], strict=True))
    for name, mass in case['states'][-1]['propellant'].items():
        assert used[name] == pytest.approx(mass, rel=1e-6)
    assert np.isnan(used['c3'])
    # All impulse is in some tick.
    impulse = column('thruster').sum(axis=0) / case['scenario']['publish']['rate']
    expected = [case['fields'][-1]['impulse'][name] for name in given['names']]
    np.testing.assert_allclose(impulse, expected, rtol=1e-6)
