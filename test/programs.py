"""Random programs: a scenario and what happens in its run, all of it drawn from a seed."""

import math
from fractions import Fraction
from random import Random
from typing import Any, NamedTuple

import numpy as np
import yaml
from flights import TOPIC_NAMES, offered

from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import System
from satdyn_ros.run.events import Event, from_yaml_text
from satdyn_ros.run.scenario import Scenario

EPOCH_NS = 1_700_000_000 * 10**9
RATES_HZ = (29.97, 33.3, 7.77, 3.0, 0.5, 1000 / 3, 100 / 7, 10.0, 50.0, 100.0)
# Shipped scenarios that have a closed form.
CLOSED_FORMS = ('agostinelli', 'balli_grioli', 'beletsky', 'euler_poinsot', 'paladini')
NAMES = ('rw_x', 'rw_y', 'rw_z', 'ring')
THRUSTERS = ['t1', 't2', 't3']
# What can be published without an orbit.
WITHOUT_ORBIT = offered(System(np.eye(3)))


class Program(NamedTuple):
    """
    A scenario, how many ticks its run has, and the entries of its events file.

    refused: one more entry, for which the whole file is to be refused; None: there is none.
    """

    scenario: Scenario
    ticks: int
    entries: list[dict[str, Any]]
    refused: dict[str, Any] | None = None

    @property
    def duration_s(self) -> str:
        """The duration as exact text."""
        return str(self.ticks / self.scenario.rate)

    @property
    def events(self) -> list[Event]:
        """What happens in the run."""
        return from_yaml_text(yaml.safe_dump(self.entries), self.scenario)

    def tick(self, entry: dict[str, Any]) -> int:
        """Return the tick at which an entry acts."""
        if 'tick' in entry:
            return entry['tick']
        return math.ceil(Fraction(str(entry['at_s'])) * self.scenario.rate)

    def __str__(self) -> str:
        """Return what runs it again: the given keys, the duration and the events file."""
        given = {
            name: value
            for name, value in self.scenario.values.items()
            if value != self.scenario.keys[name].default
        }
        lines = [f'  {entry},' for entry in self.entries]
        return '\n'.join([f'{given}', f'{self.duration_s} s, {self.ticks} ticks', *lines])


def motors_of(scenario: Scenario) -> list[Rotor]:
    """Return the rotors that take commands."""
    return [rotor for rotor in scenario.system.rotors if rotor.mode == 'motor']


class Draw(Random):
    """The draws of one program; the same for a seed."""

    def power(self, low: float, high: float) -> float:
        """Return a number between 10^low and 10^high, evenly by its exponent."""
        return 10.0 ** self.uniform(low, high)

    def sign(self) -> int:
        """Return 1 or -1."""
        return self.choice((1, -1))

    def one_in(self, count: int) -> bool:
        """Return True once in count times."""
        return self.randrange(count) == 0

    def vector(self, length: float) -> list[float]:
        """Return a vector of a length and any direction, along an axis at times."""
        if self.one_in(3):
            along = [0.0, 0.0, 0.0]
            along[self.randrange(3)] = self.sign() * length
            return along
        parts = [self.gauss(0.0, 1.0) for _ in range(3)]
        return [length * x / math.hypot(*parts) for x in parts]

    def attitude(self) -> list[float]:
        """Return a unit quaternion of any attitude, the identity at times."""
        if self.one_in(4):
            return [0.0, 0.0, 0.0, 1.0]
        parts = [self.gauss(0.0, 1.0) for _ in range(4)]
        return [x / math.hypot(*parts) for x in parts]

    def rate(self) -> float:
        """Return how fast a body turns [rad/s], not at all at times."""
        return 0.0 if self.one_in(4) else self.power(-4.0, -0.3)

    def some(self, items) -> list:
        """Return some of the items in any order, one at least."""
        return self.sample(items, self.randint(1, len(items)))

    # -- scenarios -------------------------------------------------------------------------------

    def scenario(self) -> Scenario:
        """Return a scenario."""
        rate_hz = self.choice(RATES_HZ)
        kind = self.randrange(8)
        if kind == 0:
            values = self.shipped()
        elif kind == 1:
            values = self.steady_on_a_circle()
        elif kind == 2:
            values = self.sphere()
        else:
            values = self.any_body()
        if values.get('motion.method') != 'exact':
            values |= self.rotors(self.randrange(5), values['body.inertia'])
        if values.get('motion.method', 'numeric') == 'numeric' and self.one_in(5):
            values['motion.tolerance'] = self.choice((1e-10, 1e-8))
        is_fixed = values.get('orbit.type') == 'fixed'
        timeouts_s = (0.0, 1.0, 0.3 / rate_hz, self.randint(1, 9) / rate_hz)
        values |= {
            'publish.rate': rate_hz,
            'publish.topics': self.topics(is_fixed),
            'torque.timeout': self.choice(timeouts_s),
            'time.epoch_ns': EPOCH_NS + self.choice((0, self.randrange(10**9))),
        }
        values |= self.parts_inside(values, is_fixed)
        values |= self.sensors(is_fixed)
        return Scenario(values | self.recording(rate_hz))

    def shipped(self):
        """Return the values of a shipped scenario that has a closed form."""
        scenario = Scenario.from_yaml(f'config/{self.choice(CLOSED_FORMS)}.yaml')
        of_the_motion = ('body.', 'orbit.', 'initial.', 'rotor.')
        values = {k: v for k, v in scenario.values.items() if k.startswith(of_the_motion)}
        return values | {'motion.method': 'exact'}

    def steady_on_a_circle(self):
        """Return the values of an equilibrium, or of a planar motion, on a circular orbit."""
        angle = self.choice((0.0, self.uniform(-1.0, 1.0)))
        return {
            'body.inertia': self.moments(),
            'orbit.inclination': self.uniform(0.0, 3.0),
            'initial.attitude': [0.0, math.sin(angle / 2), 0.0, math.cos(angle / 2)],
            'initial.angular_velocity': [0.0, self.sign() * self.rate() if angle else 0.0, 0.0],
            'motion.method': self.choice(('auto', 'exact')),
        }

    def sphere(self):
        """Return the values of a body whose principal moments are the same."""
        return {
            'body.inertia': 3 * [self.power(-2.0, 3.0)],
            **self.orbit(),
            'initial.attitude': self.attitude(),
            'initial.angular_velocity': self.vector(self.rate()),
            'motion.method': self.choice(('numeric', 'auto', 'exact')),
        }

    def any_body(self):
        """Return the values of a body that moves in any way."""
        values = {
            'body.inertia': self.moments(),
            **self.orbit(),
            'initial.attitude': self.attitude(),
            'initial.angular_velocity': self.vector(self.rate()),
            'motion.method': self.choice(('numeric', 'numeric', 'auto')),
        }
        if values['orbit.type'] != 'fixed':
            values['initial.frame'] = self.choice(('lvlh', 'inertial'))
        elif self.one_in(2):
            weight = self.choice((self.vector(1e-3), [0.0, 0.0, 1e-3]))
            values['body.weight_moment'] = [x * values['body.inertia'][0] for x in weight]
        return values

    def moments(self):
        """Return principal moments, two the same at times."""
        sums = [self.uniform(0.1, 1.0) for _ in range(3)]
        if self.one_in(3):
            sums[1] = sums[0]
        scale = self.power(-2.0, 3.0)
        return [scale * (sum(sums) - x) for x in sums]

    def orbit(self):
        """Return the values of an orbit of any type."""
        kind = self.choice(('fixed', 'circular', 'kepler'))
        if kind == 'fixed':
            gradient = self.choice((0.0, 3.6e-6, -3.6e-6))
            return {'orbit.type': kind, 'orbit.gradient': gradient}
        values = {
            'orbit.type': kind,
            'orbit.semi_major_axis': self.uniform(6.8e6, 4.2e7),
            'orbit.inclination': self.uniform(0.0, math.pi),
            'orbit.raan': self.uniform(-6.0, 6.0),
            'orbit.true_anomaly': self.choice((0.0, self.uniform(-6.0, 6.0))),
        }
        if kind == 'kepler':
            values['orbit.eccentricity'] = self.choice((0.0, 0.01, self.uniform(0.0, 0.7)))
        return values

    def rotors(self, count, inertia):
        """Return the values of rotors, whose speeds are near their limits, where they have one."""
        if count == 0:
            return {'rotor.mode': 'none'}
        names = NAMES[:count] if count > 1 or self.one_in(2) else ()
        values: dict[str, Any] = {'rotor.names': names, 'rotor.mode': 'none'} if names else {}
        for prefix in [f'rotor.{name}' for name in names] or ['rotor']:
            values |= {f'{prefix}.{leaf}': x for leaf, x in self.rotor(min(inertia[:3])).items()}
        return values

    def rotor(self, least):
        """Return what describes a rotor of a body with this least moment."""
        mode = self.choice(('constant_momentum', 'free', 'motor', 'motor'))
        described: dict[str, Any] = {'mode': mode, 'axis': self.vector(1.0)}
        # A turn of the body by the whole momentum of a wheel is not fast.
        momentum = least * self.power(-3.0, -0.5)
        if mode == 'constant_momentum':
            return described | {'momentum': self.sign() * momentum}
        inertia = least * self.power(-4.0, -1.2)
        fastest = momentum / inertia
        described |= {
            'inertia': inertia,
            'speed': self.sign() * fastest * self.choice((0.0, 1.0, 0.999, 0.95, self.random())),
            'friction': self.choice((0.0, inertia / self.power(0.5, 3.0))),
        }
        if mode == 'motor':
            described |= {
                'max_speed': self.choice((0.0, fastest, fastest)),
                'max_torque': self.choice((0.0, momentum * self.power(-2.0, 1.0))),
            }
        return described

    def parts_inside(self, values, is_fixed):
        """Return the values of flexible modes and hysteresis rods, at times, and their topics."""
        found: dict[str, Any] = {}
        if values.get('motion.method', 'numeric') == 'exact':
            return found
        topics = list(values['publish.topics'])
        if self.one_in(3):
            names = ('panel', 'fuel')[: self.randint(1, 2)]
            found['flexible.names'] = names
            # Beside rotors and each other they take a little of the body.
            largest = 0.3 * math.sqrt(min(values['body.inertia'][:3]))
            for name in names:
                mode = {
                    'frequency': self.power(-2.0, 0.5),
                    'damping': self.choice((0.0, 0.01)),
                    'coupling': self.vector(largest * self.random()),
                    'displacement': self.choice((0.0, 1e-3 * largest)),
                    'rate': self.choice((0.0, 1e-4 * largest)),
                }
                found |= {f'flexible.{name}.{leaf}': x for leaf, x in mode.items()}
            topics += ['flexible']
        if not is_fixed and self.one_in(4):
            names = ('rod_x', 'rod_y')[: self.randint(1, 2)]
            found |= {'hysteresis.names': names, 'environment.magnetic_field': 'dipole'}
            for name in names:
                rod = {
                    'axis': self.vector(1.0),
                    'volume': 1e-4 * min(values['body.inertia'][:3]),
                    'coercive_force': self.power(0.0, 1.5),
                    'remanence': 0.1,
                    'saturation': 0.4,
                    'minor_slope': self.choice((0.0, 0.1)),
                    'exponent': self.choice((2.0, 2.0, 3.5)),
                }
                found |= {f'hysteresis.{name}.{leaf}': x for leaf, x in rod.items()}
            topics += ['hysteresis', 'hysteresis_torque']
        return found | {'publish.topics': topics}

    def topics(self, is_fixed):
        """Return topics to publish, none at times."""
        if self.one_in(8):
            return []
        return self.some(WITHOUT_ORBIT if is_fixed else TOPIC_NAMES)

    def sensors(self, is_fixed):
        """Return the values of sensors."""
        two = ['gyro', 'star_tracker']
        names = self.choice(([], [], ['gyro'], ['star_tracker'], two, ['st2', *two, 'gyro2']))
        if not names:
            return {}
        drawn: dict[str, Any] = {'sensors.names': names, 'sensors.seed': self.randint(1, 10**9)}
        types = {'gyro2': 'gyro', 'st2': 'star_tracker'}
        for name in names:
            of = self.gyro() if 'gyro' in name else self.star_tracker(is_fixed)
            of |= {'type': types[name]} if name in types else {}
            drawn |= {f'sensors.{name}.{leaf}': value for leaf, value in of.items()}
        return drawn

    def gyro(self):
        """Return the values of a gyro, by their last words."""
        return {
            'divisor': self.choice((1, 1, 2, 3, 7)),
            'noise_density': self.choice((0.0, 1e-5)),
            'bias_random_walk': self.choice((0.0, 1e-6)),
            'bias_instability': self.choice((0.0, 0.0, 1e-5)),
            'bias_correlation_time': self.choice((1000.0, 1.0)),
            'initial_bias': self.vector(1e-4),
            'resolution': self.choice((0.0, 1e-6)),
            'integrating': self.one_in(2),
        }

    def star_tracker(self, is_fixed):
        """Return the values of a star tracker, by their last words."""
        drawn = {
            'divisor': self.choice((1, 2, 5)),
            'cross_boresight': self.choice((0.0, 1e-5)),
            'roll': self.choice((0.0, 1e-4)),
            'latency': self.choice((0, 1, 4, 20)),
            'max_rate': self.choice((0.0, 0.05)),
            'mounting': self.attitude(),
        }
        return drawn if is_fixed else drawn | {'earth_exclusion': self.choice((0.0, 1.2))}

    def recording(self, rate_hz):
        """Return how the bag is compressed and where it continues in a new file."""
        return {
            'record.compression': self.choice(('none', 'lz4', 'zstd')),
            'record.max_size_bytes': self.choice((0, 0, round(self.power(3.3, 5.0)))),
            'record.max_duration_s': self.choice((0.0, 0.0, self.randint(1, 100) / rate_hz)),
        }

    # -- what happens ----------------------------------------------------------------------------

    def program(self) -> Program:
        """Return a program of a few hundred ticks at most."""
        scenario = self.scenario()
        ticks = self.choice((self.randint(1, 30), self.randint(5, 400)))
        moments = [0, *(self.randrange(ticks) for _ in range(self.randint(0, 9)))]
        entries: list[dict[str, Any]] = []
        conditions = scenario
        # Where a torque ends by its timeout, or is dropped, something else is to act as well.
        timeout_ticks = math.ceil(scenario['torque.timeout'] * scenario.rate)
        moments += [k + self.choice((1, timeout_ticks)) for k in moments if self.one_in(2)]
        for tick in sorted(self.choice(moments) for _ in range(self.choice((0, 3, 8, 20)))):
            what = self.happening(conditions, ticks, moments, tick)
            if 'request' in what:
                conditions = conditions.with_values(what['request'])
            entries.append(self.at(tick, scenario) | what)
        refused = None
        if self.one_in(8):
            refused = {'tick': self.choice(moments), 'request': self.bad_request(conditions)}
        program = Program(scenario, ticks, entries, refused)
        return self.with_thrusters(self.with_dipoles(self.with_names(program)))

    def with_names(self, program: Program) -> Program:
        """Return a program, at times with its torques given to one or both of two names."""
        if self.one_in(2):
            return program
        names = ['control', 'drag']
        entries = [
            entry | {'torque': {name: entry['torque'] for name in self.some(names)}}
            if 'torque' in entry
            else entry
            for entry in program.entries
        ]
        scenario = program.scenario.with_values({'torque.names': names})
        return program._replace(scenario=scenario, entries=entries)

    def with_dipoles(self, program: Program) -> Program:
        """Return a program, at times with magnetorquers, and dipoles for some of its torques."""
        if self.one_in(2):
            return program
        most = [self.choice((0.0, 0.2)), self.choice((0.1, 0.3)), 0.2]
        entries = [
            {
                'magnetorquer' if name == 'torque' and self.one_in(2) else name: value
                for name, value in entry.items()
            }
            for entry in program.entries
        ]
        for entry in entries:
            if 'magnetorquer' in entry:
                entry['magnetorquer'] = self.vector(self.choice((0.0, 0.1, 0.5)))
        scenario = program.scenario.with_values({'magnetorquer.max_dipole': most})
        return program._replace(scenario=scenario, entries=entries)

    def with_thrusters(self, program: Program) -> Program:
        """Return a program, at times with thrusters that fire in place of some of its torques."""
        if program.scenario['motion.method'] == 'exact' or self.one_in(2):
            return program
        tick_s = 1.0 / float(program.scenario.rate)
        least = min(program.scenario['body.inertia'][:3])
        names = THRUSTERS[: self.randint(1, 3)]
        values: dict[str, Any] = {'thruster.names': names}
        for name in names:
            described = {
                'position': self.vector(self.power(-1.0, 0.5)),
                'direction': self.vector(1.0),
                'thrust': self.choice((0.0, least * self.power(-3.0, -1.0))),
                'min_on_time': self.choice((0.0, 0.3 * tick_s)),
                'delay': self.choice((0.0, tick_s, tick_s * self.power(-2.0, 0.7))),
                'time_constant': self.choice((0.0, tick_s * self.power(-2.0, 1.0))),
                'specific_impulse': self.choice((0.0, 60.0)),
            }
            values |= {f'thruster.{name}.{leaf}': x for leaf, x in described.items()}
        topics = program.scenario['publish.topics']
        shown = self.choice(([], ['thruster'], ['thruster', 'thruster_wrench']))
        values['publish.topics'] = [*topics, *shown]
        entries = []
        for entry in program.entries:
            if 'torque' in entry and self.one_in(2):
                at = {name: x for name, x in entry.items() if name in ('tick', 'at_s')}
                on_times = {name: self.on_time(tick_s) for name in self.some(names)}
                # Several at a tick: of each thruster the last one holds.
                entries += [at | {'thrusters': on_times}] * self.choice((1, 1, 2))
            else:
                entries.append(entry)
        scenario = program.scenario.with_values(values)
        return program._replace(scenario=scenario, entries=entries)

    def on_time(self, tick_s):
        """Return an on-time [s]: none, some ticks to the last digit, or any."""
        some = self.randint(1, 5) * tick_s, tick_s * self.power(-2.0, 1.5)
        return self.choice((0.0, min(self.choice(some), 86400.0)))

    def at(self, tick, scenario):
        """Return a tick as an entry has it, at times by a time that is rounded up to it."""
        if self.one_in(3) and tick:
            return {'at_s': float(round((tick - self.random() / 2) / scenario.rate, 9))}
        return {'tick': tick}

    def happening(self, conditions, ticks, moments, tick):
        """Return what happens at a tick."""
        motors = motors_of(conditions)
        kinds = [
            'torque',
            'torque',
            'request',
            'reset',
            'topics',
            *(4 * ['rotor'] if motors else ()),
        ]
        match self.choice(kinds):
            case 'torque':
                torque = self.torque(conditions, float(ticks / conditions.rate))
                return {'torque': torque} | self.until(moments, tick)
            case 'rotor':
                command = self.command(motors, conditions)
                named = command if conditions['rotor.names'] else command['rotor']
                return {'rotor_torque': named} | self.until(moments, tick)
            case 'request' if conditions['motion.method'] == 'numeric' and self.one_in(30):
                # No propagation follows it: the run halts at the next tick.
                fast = 9e5 * float(conditions.rate)
                return {'request': {'initial.angular_velocity': [0.0, fast, 0.1 * fast]}}
            case 'request':
                return {'request': self.request(conditions)}
            case 'reset':
                return {'reset': True}
        return {'topics': self.topics(conditions.is_fixed)}

    def until(self, moments, tick):
        """Return how long a torque holds, most often until something else happens."""
        later = [moment for moment in moments if moment > tick]
        match self.randrange(4):
            case 0:
                return {'until_tick': None}
            case 1 | 2 if later:
                return {'until_tick': self.choice(later)}
        return {}

    def torque(self, conditions, duration_s):
        """Return a torque [N m]: none, a small one, seldom one that no motion can follow."""
        if self.one_in(4) or conditions['motion.method'] == 'exact':
            return [0.0, 0.0, 0.0]
        if self.one_in(15):
            return self.vector(self.power(6.0, 30.0))
        return self.vector(min(conditions['body.inertia'][:3]) * self.rate() / duration_s)

    def command(self, motors, conditions):
        """Return motor torques by rotor: near its limit it is soon met."""
        return {
            rotor.label: self.choice((0.0, 1.0, 1.0, -1.0))
            * rotor.inertia
            * (rotor.max_speed or 1.0)
            * float(conditions.rate)
            * self.choice((1.0, 0.1, 0.01, 0.001))
            for rotor in self.some(motors)
        }

    def request(self, conditions):
        """Return initial conditions that are allowed."""
        drawn: dict[str, Any] = {
            'initial.attitude': self.attitude(),
            'initial.angular_velocity': self.vector(self.rate()),
        }
        if not conditions.is_fixed:
            drawn['initial.frame'] = self.choice(('inertial', 'lvlh'))
        for rotor in conditions.system.rotors:
            prefix = f'rotor.{rotor.name}'.rstrip('.')
            if rotor.turns_freely:
                fastest = rotor.max_speed or 1.0
                drawn[f'{prefix}.speed'] = self.sign() * fastest * self.choice((1.0, 0.99, 0.0))
            elif rotor.mode == 'constant_momentum':
                drawn[f'{prefix}.momentum'] = rotor.momentum * self.uniform(-1.0, 1.0)
        names = self.sample(list(drawn), self.randint(0, len(drawn)))
        request = {name: drawn[name] for name in names}
        if conditions['motion.method'] == 'exact':
            try:
                conditions.with_values(request)
            except ValueError:
                return {}
        return request

    def bad_request(self, conditions):
        """Return initial conditions that are not allowed."""
        bad: list[dict[str, Any]] = [
            {'initial.attitude': [0.0, 0.0, 0.0, 2.0]},
            {'initial.attitude': [0.0, 0.0, 1.0]},
            {'initial.angular_velocity': [0.0, 1e20, 0.0]},
            {'initial.frame': 'base_link'},
            {'body.inertia': [1.0, 1.0, 1.0]},
            {'initial.attitude': [0.0, 0.0, 0.0, 1.0], 'publish.rate': 10.0},
            {'rotor.rw_q.speed': 1.0},
        ]
        if conditions.is_fixed:
            bad.append({'initial.frame': 'lvlh'})
        bad += [
            {f'rotor.{rotor.name}.speed'.replace('..', '.'): 1.01 * rotor.max_speed}
            for rotor in conditions.system.rotors
            if rotor.max_speed
        ]
        return self.choice(bad)
