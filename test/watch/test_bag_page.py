"""A bag in the page: all of it, and any part at its recorded resolution."""

import browser as pages
import numpy as np
import pytest

from satdyn_ros.bag.simulate import simulate
from satdyn_ros.kernel import rotation
from satdyn_ros.run.scenario import Scenario

SCENARIO = Scenario.from_dict(
    {
        'publish': {'rate': 10.0, 'topics': ['attitude']},
        'time': {'epoch_ns': 10**18},
        'initial': {'angular_velocity': [0.0, 0.3, 2.0]},
    }
)


@pytest.fixture(scope='module')
def page(watch, browser, tmp_path_factory):
    """Return the browser with the page of a bag in which the body turns fast."""
    path = tmp_path_factory.mktemp('recorded') / 'bag'
    for _ in simulate(SCENARIO, 8000, path):
        pass
    browser.get(watch(str(path)))
    pages.wait(browser, 'window.satdyn && satdyn.rows && satdyn.stage.scene.frames.length > 0')
    return browser


def test_any_part_is_there_as_it_was_recorded(page):
    """The whole has a row in ten, with bands; a part chosen in a chart has every tick."""
    every = 'satdyn.rows.time(1) - satdyn.rows.time(0)'
    assert page.execute_script(f'return {every}') == pytest.approx(1.0)
    # From the first tick to the last, which is none of the rows.
    assert '80000 ticks at 10 Hz, 7999.9 s; ' in page.find_element('id', 'summary').text
    assert 'cannot play' in page.find_element('class name', 'notice').text
    page.execute_script("satdyn.charts.charts[1].plot.setScale('x', {min: 5000.02, max: 5400})")
    pages.wait(page, f'{every} < 0.11')
    assert page.execute_script('return satdyn.rows.time(0)') == pytest.approx(5000.1)
    assert not page.find_element('class name', 'notice').is_displayed()
    q_ib = page.execute_script('satdyn.timeline.seek(5123.4); return satdyn.stage.scene.row.q_ib')
    truth = SCENARIO.motion().at(5123.4).q_ib[0]
    # The rounding of float32, in each of four components.
    assert rotation.angle_between(np.array(q_ib), truth) < 1e-6
    page.find_element('id', 'whole').click()
    pages.wait(page, f'{every} > 0.9')
    assert pages.errors(page) == []
