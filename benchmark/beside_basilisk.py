"""An orbit of a CubeSat in dipole field and air, by Basilisk's own models and by ours."""

import importlib.util
import itertools
import math
import time
from unittest.mock import patch

import numpy as np
from common import QUICK, Claim, medians, milliseconds, show

from satdyn_ros.base.nanoseconds import SECOND_NS
from satdyn_ros.environment import dipole_vector, gcrs_to_itrs
from satdyn_ros.environment.earth import EARTH_RATE_RAD_S
from satdyn_ros.environment.magnetic_field import IGRF_RADIUS_M
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import along_orbit
from satdyn_ros.orbits.kepler import EARTH_MU
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.torques.plates import box

# 2026-03-01T00:00:00Z.
EPOCH_NS = 1_772_323_200 * SECOND_NS
DURATION_S = 100.0 if QUICK else 5600.0
GRID_S = np.arange(0.0, DURATION_S + 1.0, 10.0)
STEPS_S = [2.0**-n for n in range(3 if QUICK else 6)]
EQUATOR_M, ALTITUDE_M, SCALE_M, DENSITY = 6_378_137.0, 450e3, 60e3, 3e-12
# Of the Earth about its axis among the stars, as the Earth rotation angle has it [rad/s].
TURN_RAD_S = 2.0 * math.pi * 1.00273781191135448 / 86_400.0
INERTIA = 0.05, 0.05, 0.01
DIPOLE = 0.01, 0.02, -0.01
EDGES_M, CENTRE_M, DRAG = (0.1, 0.1, 0.34), (0.0, 0.002, 0.02), 2.2
RATE = 0.01, 0.02, -0.015
ATTITUDE = rotation.normalise([0.1, 0.2, -0.3, 0.9])
TO_ITRS = gcrs_to_itrs(EPOCH_NS)
LATER = itertools.count(1)


def standing_pole(unix_ns, _) -> np.ndarray:
    """Return the turns into the axes of an Earth whose pole stays as it is at the epoch."""
    angle = TURN_RAD_S * (np.asarray(unix_ns) - EPOCH_NS) / SECOND_NS
    c, s, zero, one = np.cos(angle), np.sin(angle), np.zeros_like(angle), np.ones_like(angle)
    rows = [c, s, zero], [-s, c, zero], [zero, zero, one]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1)) @ TO_ITRS


def flight(has_field=True, has_air=True, epoch_ns=EPOCH_NS) -> Scenario:
    """
    Return the scenario that both can fly.

    With air above the equator: our height is above the ellipsoid, Basilisk's above a sphere.
    """
    x, y, z = TO_ITRS[2]
    plane = (math.acos(z), math.atan2(x, -y)) if has_air else (0.9, 0.5)
    air = {
        'atmosphere': 'exponential',
        'density': DENSITY,
        'density_height': ALTITUDE_M,
        'scale_height': SCALE_M,
    }
    return Scenario.from_dict(
        {
            'body': {
                'inertia': INERTIA,
                'dipole': DIPOLE,
                'box': EDGES_M,
                'box_centre': CENTRE_M,
            },
            'orbit': {
                'type': 'kepler',
                'semi_major_axis': EQUATOR_M + ALTITUDE_M,
                'eccentricity': 0.005,
                'inclination': plane[0],
                'raan': plane[1],
            },
            'environment': {
                'magnetic_field': 'dipole' if has_field else 'none',
                **(air if has_air else {}),
            },
            'time': {'epoch_ns': epoch_ns},
            'initial': {'frame': 'inertial', 'attitude': ATTITUDE, 'angular_velocity': RATE},
        }
    )


class Basilisk:
    """
    Basilisk with the body, the orbit and the torques of flight(), ready to run with some step.

    Its models of field, air and wind say what they are at the begin of a step, for all of it.
    The body is so heavy that the drag does not change its orbit.
    """

    def __init__(self, step_s, has_field=True, has_air=True):
        from Basilisk.simulation import GravityGradientEffector, spacecraft
        from Basilisk.utilities import SimulationBaseClass, macros, simIncludeGravBody

        self.simulation = SimulationBaseClass.SimBaseClass()
        task = self.simulation.CreateNewTask('task', macros.sec2nano(step_s))
        self.simulation.CreateNewProcess('dynamics').addTask(task)
        # Basilisk does not keep what a program lets go.
        self.models, self.messages = [], []

        self.body = body = spacecraft.Spacecraft()
        body.hub.mHub, body.hub.IHubPntBc_B = 1e9, np.diag(INERTIA).tolist()
        self.gravity = simIncludeGravBody.gravBodyFactory()
        earth = self.gravity.createEarth()
        earth.isCentralBody, earth.mu = True, EARTH_MU
        self.gravity.addBodiesTo(body)
        orbit = flight(has_field, has_air).system.orbit
        r, v = orbit.position_velocity(np.zeros(1))
        body.hub.r_CN_NInit, body.hub.v_CN_NInit = r[0], v[0]
        body.hub.sigma_BNInit = [[x / (1.0 + ATTITUDE[3])] for x in ATTITUDE[:3]]
        body.hub.omega_BN_BInit = [[x] for x in RATE]
        # First: it goes through a step with what the others said at its begin.
        self.add(body)
        gradient = GravityGradientEffector.GravityGradientEffector()
        gradient.addPlanetName(earth.planetName)
        self.add_torque(gradient)
        planet = self.planet()
        if has_field:
            self.add_field(planet)
        if has_air:
            self.add_air(planet)
        self.recorder = body.scStateOutMsg.recorder(macros.sec2nano(10.0))
        self.add(self.recorder)
        self.simulation.InitializeSimulation()
        self.simulation.ConfigureStopTime(macros.sec2nano(DURATION_S))

    def add(self, model):
        """Let a model take part."""
        self.simulation.AddModelToTask('task', model)
        self.models.append(model)

    def add_torque(self, effector):
        """Let a torque act on the body."""
        self.body.addDynamicEffector(effector)
        self.add(effector)

    def planet(self):
        """Return the message of an Earth that turns as ours does at the epoch."""
        from Basilisk.simulation import planetEphemeris

        pole = TO_ITRS[2]
        ra, dec = math.atan2(pole[1], pole[0]), math.asin(pole[2])
        x, y, _ = TO_ITRS @ (-math.sin(ra), math.cos(ra), 0.0)
        planet = planetEphemeris.PlanetEphemeris()
        planet.setPlanetNames(planetEphemeris.StringVector(['earth']))
        elements = planetEphemeris.ClassicElements()
        elements.a, elements.e = 1.496e11, 0.01
        elements.i = elements.Omega = elements.omega = elements.f = 0.0
        planet.planetElements = planetEphemeris.classicElementVector([elements])
        planet.zeroBase = 'earth'
        planet.rightAscension = planetEphemeris.DoubleVector([ra])
        planet.declination = planetEphemeris.DoubleVector([dec])
        planet.lst0 = planetEphemeris.DoubleVector([math.atan2(x, y)])
        planet.rotRate = planetEphemeris.DoubleVector([TURN_RAD_S])
        self.add(planet)
        return planet.planetOutMsgs[0]

    def add_field(self, planet):
        """Let the field of a dipole turn three bars, which are the body's dipole."""
        from Basilisk.architecture import messaging
        from Basilisk.simulation import MtbEffector, magneticFieldCenteredDipole

        field = magneticFieldCenteredDipole.MagneticFieldCenteredDipole()
        field.g11, field.h11, field.g10 = dipole_vector(EPOCH_NS)
        field.planetRadius = IGRF_RADIUS_M
        field.planetPosInMsg.subscribeTo(planet)
        field.addSpacecraftToModel(self.body.scStateOutMsg)
        self.add(field)
        layout = messaging.MTBArrayConfigMsgPayload()
        layout.numMTB, layout.GtMatrix_B = 3, np.eye(3).ravel().tolist()
        layout.maxMtbDipoles = [1.0] * 3
        command = messaging.MTBCmdMsgPayload()
        command.mtbDipoleCmds = list(DIPOLE)
        layout = messaging.MTBArrayConfigMsg().write(layout)
        command = messaging.MTBCmdMsg().write(command)
        self.messages += [layout, command]
        bars = MtbEffector.MtbEffector()
        bars.mtbParamsInMsg.subscribeTo(layout)
        bars.mtbCmdInMsg.subscribeTo(command)
        bars.magInMsg.subscribeTo(field.envOutMsgs[0])
        self.add_torque(bars)

    def add_air(self, planet):
        """Let air that turns with the Earth press on the sides of the box."""
        from Basilisk.simulation import (
            exponentialAtmosphere,
            facetDragDynamicEffector,
            zeroWindModel,
        )

        air = exponentialAtmosphere.ExponentialAtmosphere()
        air.baseDensity = DENSITY * math.exp(ALTITUDE_M / SCALE_M)
        air.scaleHeight, air.planetRadius = SCALE_M, EQUATOR_M
        air.planetPosInMsg.subscribeTo(planet)
        air.addSpacecraftToModel(self.body.scStateOutMsg)
        self.add(air)
        wind = zeroWindModel.ZeroWindModel()
        wind.setPlanetOmega_N(EARTH_RATE_RAD_S * TO_ITRS[2])
        wind.planetPosInMsg.subscribeTo(planet)
        wind.addSpacecraftToModel(self.body.scStateOutMsg)
        self.add(wind)
        drag = facetDragDynamicEffector.FacetDragDynamicEffector()
        for side in box(EDGES_M, CENTRE_M, DRAG):
            drag.addFacet(side.area, DRAG, side.normal, side.position)
        drag.atmoDensInMsg.subscribeTo(air.envOutMsgs[0])
        drag.windVelInMsg.subscribeTo(wind.envOutMsgs[0])
        self.add_torque(drag)

    def run(self) -> float:
        """Fly, and return the CPU seconds."""
        begin = time.process_time()
        self.simulation.ExecuteSimulation()
        return time.process_time() - begin

    def attitudes(self) -> np.ndarray:
        """Return q_ib at GRID_S, (N, 4), of modified Rodrigues parameters."""
        sigma = np.array(self.recorder.sigma_BN)
        square = np.sum(sigma * sigma, axis=1, keepdims=True)
        return np.hstack([2.0 * sigma, 1.0 - square]) / (1.0 + square)


def differences(*torques: bool) -> list[np.ndarray]:
    """
    Return Basilisk's attitudes from ours as rotation vectors (N, 3) [rad], by STEPS_S.

    The Earth's pole stands for both.  In an orbit it moves by 4e-8 rad, which our tables follow.
    """
    with patch.object(along_orbit, 'gcrs_to_itrs', standing_pole):
        ours, found = flight(*torques).motion().at(GRID_S).q_ib, []
    for step_s in STEPS_S:
        basilisk = Basilisk(step_s, *torques)
        basilisk.run()
        between = rotation.multiply(rotation.conjugate(ours), basilisk.attitudes())
        found.append(rotation.to_vector(between))
    return found


def extrapolated(found: list[np.ndarray]) -> np.ndarray:
    """Return what is left at step 0 of what goes with the step and its square (Richardson)."""
    once = [2.0 * fine - coarse for coarse, fine in itertools.pairwise(found[-3:])]
    return (4.0 * once[1] - once[0]) / 3.0


def table() -> str:
    """Return a table of the largest differences by torques and steps."""
    columns = sorted({*range(0, len(STEPS_S), 2), len(STEPS_S) - 1})
    heads = ' | '.join(f'step {STEPS_S[i]:g} s' for i in columns)
    lines = [f'| torques | {heads} | step 0 |', '| --- |' + ' --- |' * (len(columns) + 1)]
    for what, *torques in (
        ('gravity gradient', False, False),
        ('with the dipole in the field', True, False),
        ('with drag', False, True),
        ('with both', True, True),
    ):
        found = differences(*torques)
        at_0 = extrapolated(found) if any(torques) else found[-1]
        largest = [np.linalg.norm(x, axis=1).max() for x in (*(found[i] for i in columns), at_0)]
        lines.append(f'| {what} | ' + ' | '.join(f'{x:.1e}' for x in largest) + ' |')
    return '\n'.join(lines)


def ours() -> float:
    """Fly as Basilisk does, with tables of its own; return the CPU seconds."""
    motion = flight(epoch_ns=EPOCH_NS + next(LATER) * SECOND_NS).motion()
    begin = time.process_time()
    motion.at(GRID_S)
    return time.process_time() - begin


def main(rounds=7):
    """Run all; return title, claims and text."""
    if importlib.util.find_spec('Basilisk') is None:
        text = 'Basilisk is not installed: nothing to compare with.'
        print(text)
        return 'Beside Basilisk', [], text
    step_s = STEPS_S[-1]
    seconds = medians({'ours': ours, 'Basilisk': lambda: Basilisk(step_s).run()}, rounds)
    claims = [
        Claim(
            f'an orbit in field and air, tables included, against Basilisk in steps of {step_s} s',
            milliseconds(seconds['ours']),
            milliseconds(seconds['Basilisk']),
            seconds['Basilisk'] / seconds['ours'],
            50.0,
        )
    ]
    text = f'The largest angle between the two attitudes [rad]:\n\n{table()}'
    print(text)
    return 'Beside Basilisk', show(claims), text


if __name__ == '__main__':
    main()
