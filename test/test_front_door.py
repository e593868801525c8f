"""What somebody sees who explores the package from Python."""

import pydoc
import subprocess
import sys

import numpy as np
import pytest

import satdyn_ros
from satdyn_ros import Scenario, Simulation
from satdyn_ros.kernel import rotation

TIMES = np.linspace(0.0, 60.0, 4)


def test_completion_and_help_know_the_public_names():
    """dir() lists what is imported when it is first used, and help() describes it."""
    program = 'import satdyn_ros, satdyn_ros.dynamics as d; print(*dir(satdyn_ros), *dir(d))'
    command = [sys.executable, '-c', program]
    listed = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
    assert {*satdyn_ros.__all__, '__version__', 'motion', 'system'} <= set(listed)
    assert not {'Any', 'import_module', 'modules_of'} & set(listed)
    text = pydoc.plain(pydoc.render_doc(satdyn_ros))
    for name in satdyn_ros.__all__:
        assert name in satdyn_ros.__doc__
        assert getattr(satdyn_ros, name).__doc__
        assert name in text


def test_each_says_what_it_is_in_one_line():
    """The scenario, its system, orbit, motions, states and a simulation of it."""
    wheels, free = Scenario.from_yaml('three_wheels'), Scenario.from_yaml('euler_poinsot')
    simulation = Simulation(wheels)
    simulation.step()
    said = {
        wheels: ['<Scenario: ', 'rw_x motor', 'numeric', '50 Hz'],
        wheels.system: ['<System: moments [0.02, 0.03, 0.04] kg m^2', '<KeplerOrbit'],
        wheels.system.orbit: ['<KeplerOrbit: a 6878.14 km, e 0, inclination 97.4', '5676.98 s>'],
        free.system.orbit: ['<FixedDirection: gradient 0 1/s^2>'],
        wheels.motion(): ['<Propagation: ', 'Hairer'],
        free.motion(): ['<Free: free rotation', 'period 181.343 s'],
        free.motion().at(TIMES): ['<States: 4 rows, t_s 0 to 60'],
        simulation: ['<Simulation: next tick 2 at 0.04 s, <Scenario'],
    }
    for thing, parts in said.items():
        line = repr(thing)
        assert '\n' not in line
        assert all(part in line for part in parts), line


def test_the_angles_are_those_to_the_orbit():
    """5 deg of roll and 10 deg of pitch, as the default says; of a fixed direction, inertial."""
    (angles,) = Scenario().motion().at(0.0).roll_pitch_yaw
    np.testing.assert_allclose(np.degrees(angles), [5.0, 10.0, 0.0], atol=1e-12)
    turned = rotation.from_roll_pitch_yaw(0.1, 0.2, 0.3)
    fixed = Scenario({'orbit.type': 'fixed', 'initial.attitude': turned})
    np.testing.assert_allclose(fixed.motion().at(0.0).roll_pitch_yaw, [[0.1, 0.2, 0.3]])


def test_states_as_a_frame_of_pandas():
    """A column for each number; what no rotor and no fixed direction has is left out."""
    pytest.importorskip('pandas')
    states = Scenario.from_yaml('three_wheels').motion().at(TIMES)
    frame = states.to_pandas()
    assert frame['t_s'].tolist() == TIMES.tolist()
    assert frame[[f'q_ib_{x}' for x in 'xyzw']].to_numpy().tolist() == states.q_ib.tolist()
    assert frame['omega_bi_b_z_rad_s'].tolist() == states.omega_bi_b[:, 2].tolist()
    assert frame['r_i_x_m'].tolist() == states.r_i[:, 0].tolist()
    assert frame['pitch_rad'].tolist() == states.roll_pitch_yaw[:, 1].tolist()
    assert frame['rotor_2_speed_rad_s'].tolist() == states.rotor_speed[:, 2].tolist()
    fixed = Scenario({'orbit.type': 'fixed'}).motion().at(TIMES).to_pandas()
    assert list(fixed) == [
        't_s',
        *(f'q_ib_{x}' for x in 'xyzw'),
        *(f'omega_bi_b_{x}_rad_s' for x in 'xyz'),
        'roll_rad',
        'pitch_rad',
        'yaw_rad',
    ]


def test_without_pandas_it_is_named(monkeypatch):
    """It is imported where it is used, and reported by its name."""
    monkeypatch.setitem(sys.modules, 'pandas', None)
    states = Scenario().motion().at(TIMES)
    with pytest.raises(ImportError, match='to_pandas needs pandas: pip install pandas') as missing:
        states.to_pandas()
    assert missing.value.name == 'pandas'
