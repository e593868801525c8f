"""Systems of all kinds, drawn at random, that need neither a scenario nor a compiler."""

import math
from typing import Any, NamedTuple

import numpy as np

from satdyn_ros.dynamics.flexible import Mode
from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import FixedDirection, KeplerOrbit, TabledOrbit
from satdyn_ros.orbits.pieces import Pieces, Stretch, fitted
from satdyn_ros.orbits.tabled import OrbitSource
from satdyn_ros.torques import BodyTorque, Table, interpolate, select, table_of
from satdyn_ros.torques.aerodynamic import Aerodynamic
from satdyn_ros.torques.hysteresis import Hysteresis, Rod
from satdyn_ros.torques.magnetic import Magnetic
from satdyn_ros.torques.plates import Plate
from satdyn_ros.torques.solar import Solar

PIECE_S = 100.0
SIZES = 3.0, 2.0, 4.0


class Swing(BodyTorque):
    """Whatever a torque may be made of: the functions of math, max, powers, loops, a table."""

    name = 'swing'

    class Constants(NamedTuple):
        size: float
        pulse_s: tuple[float, float]
        factors: np.ndarray
        table: Table

    @staticmethod
    def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        begin_s, end_s = constants.pulse_s
        fires = select(t_s >= begin_s, select(t_s < end_s, 1.0, 0.0), 0.0)
        y = math.sin(0.01 * t_s) * math.exp(-abs(omega_bi_b[1])) + q_ib[0] * q_ib[0]
        z = interpolate(constants.table, 1, t_s) - 1e-5 * v_i[0] % 0.3
        for factor in constants.factors:
            z = z - factor * max(omega_bi_b[2], 0.0, q_ib[1])
        return constants.size * fires, constants.size * y, constants.size * z

    def stops(self):
        return np.union1d(self.constants.pulse_s, self.constants.table.ends_s)


class Sail(BodyTorque):
    """A torque with a corner that comes and goes, and a central one beside it."""

    name = 'sail'

    class Constants(NamedTuple):
        size: float

    @staticmethod
    def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        return 0.0, 0.0, constants.size * max(q_ib[2] * q_ib[3], 0.0)

    @staticmethod
    def signs(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        return (q_ib[2] * q_ib[3],)


class Lag(BodyTorque):
    """A torque that follows the rate late, by variables of its own."""

    name = 'lag'
    states = 'late', 'turned'
    initial = 0.0, 0.1
    scales = 0.1, 1.0

    class Constants(NamedTuple):
        time: float
        size: float

    @staticmethod
    def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants, states):
        late, turned = states
        return -constants.size * late, 0.0, constants.size * math.sin(turned)

    @staticmethod
    def rates(t_s, r_i, v_i, q_ib, omega_bi_b, constants, states):
        late, _ = states
        return (omega_bi_b[0] - late) / constants.time, omega_bi_b[2]


class Circling(OrbitSource):
    """A position that goes round, as of a table, with a jump where two stretches meet."""

    stretches = (Stretch(0.0, PIECE_S, 0.0, 400.0), Stretch(400.0, 80.0, 400.0, 4000.0))

    def __init__(self, phase: float):
        self._phase = phase

    def coefficients(self, piece):
        def position(t_s):
            f = 1.1e-3 * t_s + self._phase
            wobble = 1e4 * np.sin(3.0 * f) + (1.0 if piece.begin_s >= 400.0 else 0.0)
            return np.stack([7e6 * np.cos(f), 7e6 * np.sin(f) + wobble, 1e5 * np.sin(f)], -1)

        return fitted(position)(piece)


def _along(rng, size, count, mean=0.0):
    """Return functions of time in pieces, with corners."""
    phase, rate = rng.uniform(0.0, 6.0, count), rng.uniform(1e-3, 4e-3, count)
    make = fitted(lambda t_s: mean + size * np.sin(rate * t_s[:, None] + phase))
    stretches = (Stretch(-20.0, PIECE_S * rng.uniform(0.7, 1.3)),)
    return Pieces(make, stretches, corners=lambda piece: np.array([piece.begin_s + 33.0]))


def _unit(rng):
    v = rng.normal(size=3)
    return v / np.linalg.norm(v)


def _rotor(rng, mode):
    unbalanced = rng.random() < 0.3
    limited = mode == 'motor' and rng.random() < 0.7
    return Rotor(
        mode,
        axis=_unit(rng),
        momentum=float(rng.normal(0.0, 0.1)),
        inertia=float(rng.uniform(0.01, 0.1)),
        friction=float(rng.choice([0.0, 1e-4])),
        coulomb_friction=float(rng.choice([0.0, 0.0, 1e-4])),
        max_torque=2e-3 if limited else 0.0,
        max_speed=float(rng.uniform(0.5, 2.0)) if limited else 0.0,
        speed_gain=0.1 if limited else 0.0,
        static_imbalance=1e-5 if unbalanced else 0.0,
        dynamic_imbalance=1e-6 if unbalanced else 0.0,
        position=0.1 * _unit(rng),
    )


def _modes(rng):
    count = int(rng.choice([0, 0, 1, 2]))
    return tuple(
        Mode(
            f'mode_{i}',
            frequency=float(rng.uniform(0.05, 2.0)),
            damping=float(rng.choice([0.0, 0.01])),
            coupling=rng.uniform(0.1, 0.7) * _unit(rng),
        )
        for i in range(count)
    )


def _rods(rng):
    rods = [
        Rod('one', tuple(_unit(rng)), 1e-4, 10.0, 0.15, 0.6, 0.05, float(rng.choice([2.0, 3.0]))),
        Rod('two', tuple(_unit(rng)), 1e-4, 12.0, 0.1, 0.5),
    ][: rng.integers(1, 3)]
    return Hysteresis(rods, _along(rng, 3e-5, 3).with_derivatives())


def _torques(rng):
    plates = [Plate(rng.uniform(0.1, 1.0), tuple(_unit(rng)), tuple(_unit(rng))) for _ in range(2)]
    factors = rng.uniform(0.0, 1e-2, int(rng.integers(0, 3)))
    table = table_of(lambda t: np.stack([np.cos(t), np.sin(0.02 * t)], -1), -30.0, 60.0, 20)
    begin_s = float(rng.uniform(0.0, 200.0))
    all_kinds: list[Any] = [
        lambda: Magnetic(rng.normal(0.0, 10.0, 3), _along(rng, 3e-5, 3)),
        lambda: Aerodynamic(plates, _along(rng, 7e3, 3), _along(rng, 2.0, 1, -27.0)),
        lambda: Solar(plates, _along(rng, 1.5e11, 3)),
        lambda: Swing(Swing.Constants(1e-4, (begin_s, begin_s + 20.0), factors, table)),
        lambda: Sail(Sail.Constants(float(rng.uniform(1e-4, 1e-3)))),
        lambda: _rods(rng),
        lambda: Lag(Lag.Constants(float(rng.uniform(5.0, 50.0)), 1e-4)),
    ]
    return tuple(kind() for kind in all_kinds if rng.random() < 0.35)


def drawn(seed: int) -> tuple[System, State, float]:
    """Return a system, its state, and when it starts [s from tick 0]."""
    rng = np.random.default_rng(seed)
    inertia = np.diag(SIZES)
    if rng.random() < 0.4:
        R = rotation.matrix(rotation.normalise(rng.normal(size=4)))
        inertia = R @ inertia @ R.T
        inertia = 0.5 * (inertia + inertia.T)
    modes = [('none',), ('constant_momentum',), ('free',), ('motor',), ('motor', 'free', 'motor')]
    rotors = tuple(_rotor(rng, mode) for mode in modes[rng.integers(len(modes))])
    orbits: list[Any] = [
        FixedDirection(1e-6),
        KeplerOrbit(inclination=0.7, true_anomaly=rng.uniform(0.0, 6.0)),
        KeplerOrbit(eccentricity=rng.uniform(0.01, 0.3), inclination=0.7, semi_major_axis=1.1e7),
        TabledOrbit(Circling(rng.uniform(0.0, 6.0))),
    ]
    orbit = orbits[rng.integers(len(orbits))]
    torques = _torques(rng) if orbit.has_lvlh else ()
    is_fixed = not orbit.has_lvlh
    driven = rng.random() < 0.5
    targets = [
        float(rng.normal(0.0, 2.0)) if r.speed_gain and rng.random() < 0.5 else math.nan
        for r in rotors
    ]
    turning = np.array([rotor.turns_freely for rotor in rotors])
    values: dict[str, Any] = {
        'weight_moment': 1e-3 * rng.normal(size=3) if is_fixed else np.zeros(3),
        'torque_b': 1e-4 * rng.normal(size=3) if driven else np.zeros(3),
        'rotor_torque': np.array([1e-3 * rng.normal() * (r.mode == 'motor') for r in rotors]),
    }
    state = {
        'q_ib': rotation.normalise(rng.normal(size=4)),
        'omega_bi_b': rng.normal(0.0, rng.choice([1e-3, 0.02, 0.3]), 3),
        'rotor_speed': np.where(turning, rng.normal(0.0, 1.0, len(rotors)), np.nan),
        'rotor_angle': np.where(turning, rng.normal(0.0, 1.0, len(rotors)), np.nan),
    }
    start_s = float(rng.choice([0.0, 30.0]))
    modes = _modes(rng)
    swings = {}
    for mode in modes:
        swings[mode.displacement_name], swings[mode.rate_name] = rng.normal(0.0, 0.02, 2).tolist()
    # What rods would begin with is computed by compiled code.  One that begins outside its loop,
    # as no run does, runs away from it in a finite time: there the motion halts.
    own = {name: float(rng.normal()) for torque in torques for name in torque.inner_names}
    system = System(
        inertia,
        rotors=rotors,
        orbit=orbit,
        rotor_target=np.array(targets),
        torques=torques,
        modes=modes,
        **values,
    )
    return system, State(**state, inner=swings | own), start_s
