"""Samples of five systems with arbitrary states, for all that messages say and leave out."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from satdyn_ros.base.nanoseconds import stamp_ns
from satdyn_ros.dynamics.flexible import Mode
from satdyn_ros.dynamics.motion import States
from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import System
from satdyn_ros.environment import Exponential
from satdyn_ros.orbits import FixedDirection, KeplerOrbit
from satdyn_ros.orbits.along_orbit import AlongOrbit
from satdyn_ros.run.samples import Samples
from satdyn_ros.run.scenario import Frames
from satdyn_ros.torques.aerodynamic import Aerodynamic
from satdyn_ros.torques.hysteresis import Hysteresis, Rod
from satdyn_ros.torques.magnetic import Magnetic
from satdyn_ros.torques.plates import Plate
from satdyn_ros.torques.solar import Solar
from satdyn_ros.torques.thrust import Firing, Thrust, Thruster

AXIS = np.array([0.48, 0.6, 0.64])
TENSOR = np.array([[800.0, 20.0, -30.0], [20.0, 900.0, 10.0], [-30.0, 10.0, 600.0]])
ELLIPSE = KeplerOrbit(
    eccentricity=0.1,
    inclination=0.9,
    raan=-2.0,
    argument_of_periapsis=1.0,
    true_anomaly=0.3,
)
EARTHLY, EPOCH_NS = KeplerOrbit(inclination=1.7), stamp_ns('2026-03-01T12:00:00')
ALONG = AlongOrbit(EARTHLY, EPOCH_NS, 'dipole', Exponential(1e-12, 4e5, 6e4), has_sun=True)
THRUSTERS = {
    'pp': Thruster(
        (0.1, 0.2, 0.3), (0.6, 0.0, 0.8), 2.0, time_constant=3.0, specific_impulse=60.0
    ),
    'mm': Thruster((-0.1, 0.2, 0.3), (0.0, 1.0, 0.0), 1.0),
}
# One opens some seconds before the first sample, and closes some before the last.
SWITCHES_S = 1230.0, 1240.0
FIRINGS = Firing(switches_s=SWITCHES_S), Firing(switches_s=SWITCHES_S)
PLATE = Plate(0.5, (0.6, 0.0, 0.8), (0.1, 0.2, 0.3), specular=0.2, diffuse=0.3)
RODS = [
    Rod('rods_x', (1.0, 0.0, 0.0), 1e-6, 12.0, 0.004, 0.025),
    Rod('rods_y', (0.0, 1.0, 0.0), 1e-6, 12.0, 0.004, 0.025),
]
SYSTEMS = {
    'ellipse, motor': System(
        TENSOR, (Rotor('motor', AXIS, inertia=2.0),), ELLIPSE, rotor_torque=np.array(0.02)
    ),
    'circle, no rotor': System(np.diag([800.0, 900.0, 600.0]), orbit=KeplerOrbit()),
    'circle, free rotor': System(
        TENSOR, (Rotor('free', AXIS, inertia=2.0),), KeplerOrbit(inclination=1.7)
    ),
    'fixed, constant momentum': System(
        TENSOR,
        (Rotor('constant_momentum', AXIS, momentum=7.0),),
        FixedDirection(gradient=3e-6),
        weight_moment=np.array([0.1, 0.2, 0.3]),
    ),
    'above the Earth': System(
        TENSOR,
        orbit=EARTHLY,
        torques=(
            Magnetic([0.1, -0.2, 0.3], ALONG.magnetic_field),
            Aerodynamic([PLATE], ALONG.air_velocity, ALONG.log_density),
            Solar([PLATE], ALONG.sun),
            Thrust(THRUSTERS, FIRINGS),
            Hysteresis(RODS, ALONG.magnetic_field_and_rate),
        ),
        environment=ALONG,
        modes=(
            Mode('bending', 2.0, 0.01, np.array([3.0, 0.0, 1.0])),
            Mode('fuel', 0.5, 0.02, np.array([0.0, 2.0, 0.0])),
        ),
    ),
}
FRAMES = {
    'ellipse, motor': Frames('sat1/inertial', 'sat1/lvlh', 'sat1/base_link'),
    'circle, no rotor': Frames(),
    'circle, free rotor': Frames('eci', 'o', 'bo'),
    'fixed, constant momentum': Frames('wörld', '', 'b'),
    'above the Earth': Frames(earth='itrs', has_earth=True),
}
PERIOD_NS = 333_333_333


def samples(name, count=40):
    """Return count samples of the system of that name."""
    rng = np.random.default_rng(3)
    system = SYSTEMS[name]
    nan = np.full((count, 1), np.nan)
    t_s = np.arange(count) * PERIOD_NS * 1e-9
    turns = system.has_turning_rotor
    states = States(
        t_s=t_s,
        q_ib=Rotation.random(count, rng).as_quat(),
        omega_bi_b=rng.normal(size=(count, 3)),
        rotor_speed=rng.normal(size=(count, 1)) if turns else nan,
        rotor_angle=100.0 * rng.normal(size=(count, 1)) if turns else nan,
        work=np.zeros(count),
        orbit=system.orbit,
        orbit_s=1234.5 + t_s,
        environment=system.environment,
        inner={name: rng.normal(size=count) for name in system.inner_names},
    )
    stamps_ns = 2_147_483_000 * 10**9 + 999_999_990 + np.arange(count) * PERIOD_NS
    return Samples(5, stamps_ns, states, system)


def part(of, rows):
    """Return the samples of a slice of rows."""
    states = of.states
    arrays = ('t_s', 'q_ib', 'omega_bi_b', 'rotor_speed', 'rotor_angle', 'work', 'orbit_s')
    inner = {name: values[rows] for name, values in states.inner.items()}
    cut = replace(states, inner=inner, **{name: getattr(states, name)[rows] for name in arrays})
    return Samples(of.first_tick + rows.start, of.stamps_ns[rows], cut, of.system)
