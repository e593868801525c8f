"""
Point to the Sun for a day with wheels, and take their momentum from them with magnetorquers.

    python examples/momentum_dumping.py
flies config/sun_pointing.yaml without ROS.  The residual dipole turns the satellite always the
same way; the wheels take that up and would be at their limit of speed within hours.  Against
their momentum h the magnetorquers make the torque T = -k h as far as the field B allows, by the
dipole m = B x T / |B|^2 (Camillo and Markley, Orbit-averaged behavior of magnetic control laws
for momentum unloading, 1980).

Take a loop around `Simulation.step`, as here, where your program leads and only wants numbers.
Where the run should leave a bag that verifies, or fly in the node, take a class:
controllers/dumping.py.
"""

import argparse
from pathlib import Path

import numpy as np

from satdyn_ros import Scenario, Simulation

SHIPPED = Path(__file__).parents[1] / 'config' / 'sun_pointing.yaml'
POINTED_B = np.array([0.0, 0.0, 1.0])
# A damped swing of 0.05 rad/s; the momentum of the wheels goes within some hours [1/s].
SWING_RAD_S, DAMPING, DUMPING_PER_S = 0.05, 0.8, 1e-3
REPORT_EACH_S = 7200.0


class Controller:
    """
    Commands from what a gyro, a sun sensor and a magnetometer measure, and from wheel speeds.

    In the shadow, and where the sensor does not see it, the Sun is where the gyro turns it to.
    """

    def __init__(self, scenario):
        system = scenario.system
        self._inertia, self._wheels = system.inertia, system.rotors
        self._axes = np.array([rotor.axis for rotor in system.rotors])
        self._spins = np.array([rotor.inertia for rotor in system.rotors])
        self._interval_s = float(1 / scenario.rate)
        self._sun_b = None

    def command(self, rate_b, field_b, sun_b, speeds):
        """Return motor torques by name [N m], and the dipole (3,) [A m^2]; sun_b: None unseen."""
        if sun_b is not None:
            self._sun_b = sun_b
        elif self._sun_b is not None:
            turned = self._sun_b - self._interval_s * np.cross(rate_b, self._sun_b)
            self._sun_b = turned / np.linalg.norm(turned)
        h_b = self._axes.T @ (self._spins * speeds)
        off_b = np.zeros(3) if self._sun_b is None else self._toward(self._sun_b)
        acceleration = SWING_RAD_S**2 * off_b - 2.0 * DAMPING * SWING_RAD_S * rate_b
        torque_b = self._inertia @ acceleration + np.cross(rate_b, self._inertia @ rate_b + h_b)
        torques = -self._axes @ torque_b
        dipole_b = np.cross(field_b, -DUMPING_PER_S * h_b) / (field_b @ field_b)
        names = (rotor.label for rotor in self._wheels)
        return dict(zip(names, torques.tolist(), strict=True)), tuple(dipole_b.tolist())

    @staticmethod
    def _toward(sun_b):
        """Return the turn (3,) [rad] from the pointed axis to the Sun."""
        across = np.cross(POINTED_B, sun_b)
        size = np.linalg.norm(across)
        angle = np.arctan2(size, POINTED_B @ sun_b)
        return angle * (across / size if size > 1e-9 else np.array([1.0, 0.0, 0.0]))


def fly(scenario, duration_s, show=print):
    """
    Return the largest angle to the Sun [rad] and speed of a wheel [rad/s] of each two hours.

    show: takes a line for each.
    """
    simulation, controller = Simulation(scenario), Controller(scenario)
    largest, angles, fastest = [], [], []
    for tick in range(round(duration_s * scenario.rate)):
        _, samples = simulation.advance(1)
        states, measured = samples.states, samples.measured
        seen = measured['sun_sensor'].values
        torques, dipole_b = controller.command(
            measured['gyro'].values[0],
            measured['magnetometer'].values[0],
            seen[0] if len(seen) else None,
            states.rotor_speed[0],
        )
        simulation.command(rotor_torque=torques, dipole_b=dipole_b)
        angles.append(float(np.arccos(np.clip(states.sun_direction_b[0] @ POINTED_B, -1.0, 1.0))))
        fastest.append(float(np.max(np.abs(states.rotor_speed[0]))))
        if (tick + 1) % round(REPORT_EACH_S * scenario.rate) == 0:
            largest.append((max(angles), max(fastest)))
            off, speed = np.degrees(largest[-1][0]), largest[-1][1]
            t_s = float((tick + 1) / scenario.rate)
            show(f'{t_s:7.0f} s  {off:7.3f} deg off  {speed:6.1f} rad/s')
            angles, fastest = [], []
    return largest


if __name__ == '__main__':
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[1])
    parser.add_argument('scenario', nargs='?', default=SHIPPED, help='default: %(default)s')
    parser.add_argument('--duration', type=float, default=86_400.0, help='[s], default: a day')
    given = parser.parse_args()
    fly(Scenario.from_yaml(given.scenario), given.duration)
