"""
The table of topics: the name, message type and purpose of each, and what it shows of a run.

From the one entry of a topic of the state follow the check of publish.topics, its messages, its
columns in tables and its panel.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import chain
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from ..actuators import ACTUATORS, Actuator, kind_of
from ..dynamics.inner_mode import InnerMode, column_of
from ..dynamics.mode_kinds import MODE_KINDS
from ..dynamics.system import System
from ..dynamics.torque import own_force, own_torque
from ..kernel import rotation
from ..sensors import KINDS, Sensor
from ..torques import ENVIRONMENT_TORQUES, BodyTorque, EnvironmentTorque
from ..torques.gravity_gradient import GravityGradient, gravity_gradient
from ..torques.thrust import Thrust, thrust_of


class Shown(NamedTuple):
    """
    What is shown of samples.

    Attributes
    ----------
    columns : tuple of str
        its names in tables, one for each component
    of : function of Samples
        returns its values, (N, k)
    """

    columns: tuple[str, ...]
    of: Callable[[Any], np.ndarray]


class Panel(NamedTuple):
    """
    The chart of what a topic shows first.

    lines: the names of its lines; empty: x, y and z, or the one ''.
    """

    title: str
    unit: str
    lines: tuple[str, ...] = ()


# By the keys of names: none.
NO_NAMES: Mapping[str, tuple[str, ...]] = MappingProxyType({})


def _nothing(system: System) -> str:
    return ''


@dataclass(frozen=True)
class Topic:
    """
    A topic.

    Attributes
    ----------
    name : str
        as ROS resolves it in the node's namespace, absolute for /tf, /clock and /diagnostics
    type : str
        of its messages
    role : str
        state (one message per tick, chosen by publish.topics), sensor (chosen by sensors.names),
        latched (one message), clock, input or diagnostics
    frame : str
        which of the scenario's frames its header names: inertial, orbital, body, or none
    says : str
        its content in words, with units
    shows : tuple of Shown
        what its messages hold, in the order of messages/contents.py; empty where it is no such
        quantity
    panel : Panel or None
        None: it has none of its own
    lacking : function of a System
        returns why it has no such topic, empty where it has
    joints, fields : tuple of str
        of sensor_msgs/JointState, the names, and those that hold what it shows
    """

    name: str
    type: str
    role: str
    frame: str
    says: str
    shows: tuple[Shown, ...] = ()
    panel: Panel | None = None
    lacking: Callable[[System], str] = _nothing
    joints: tuple[str, ...] = ()
    fields: tuple[str, ...] = ()


Q_IB = Shown(
    ('q_ib_x', 'q_ib_y', 'q_ib_z', 'q_ib_w'),
    lambda samples: samples.states.q_ib,
)
OMEGA_BI_B = Shown(
    ('omega_bi_b_x_rad_s', 'omega_bi_b_y_rad_s', 'omega_bi_b_z_rad_s'),
    lambda samples: samples.states.omega_bi_b,
)
_R_I = Shown(
    ('r_i_x_m', 'r_i_y_m', 'r_i_z_m'),
    lambda samples: samples.states.r_i,
)
_V_B = Shown(
    ('v_b_x_m_s', 'v_b_y_m_s', 'v_b_z_m_s'),
    lambda samples: rotation.rotate(rotation.conjugate(samples.states.q_ib), samples.states.v_i),
)
_Q_LB = Shown(
    ('q_lb_x', 'q_lb_y', 'q_lb_z', 'q_lb_w'),
    lambda samples: samples.states.q_lb,
)


def _lvlh_lacking(system):
    if system.orbit.has_lvlh:
        return ''
    return 'orbit.type is fixed, which has no LVLH; use circular or kepler, or leave the topic out'


def _torque(name, title, of, lacking=_nothing, force=None):
    """Return the topic of a torque on the body [N m], in body axes, and of its force [N]."""
    shows, says = [Shown(tuple(f'{name}_b_{axis}_n_m' for axis in 'xyz'), of)], 'is zero'
    if force is not None:
        says = 'is in body axes too [N]'
        shows.append(Shown(tuple(f'{name}_b_{axis}_n' for axis in 'xyz'), force))
    return Topic(
        name,
        'geometry_msgs/msg/WrenchStamped',
        'state',
        'body',
        f'torque on the body in body axes [N m]: {title}; the force {says}',
        tuple(shows),
        Panel(title, 'N m'),
        lacking,
    )


def _gravity_gradient(samples):
    states = samples.states
    gradient = states.orbit.gradient_at(states.orbit_s)
    return gravity_gradient(samples.system.inertia, states.c_b, gradient)


def _geodetic(part, factor):
    return lambda samples: factor * samples.geodetic[part][..., None]


def _lacking(key: str, has: Callable[[Any], bool]) -> Callable[[System], str]:
    """Return what says why a system has no such part of the environment, by the key of it."""

    def lacking(system):
        if system.environment is not None and has(system.environment):
            return ''
        return f'{key} is none, so that there is nothing to show; give {key}, or leave it out'

    return lacking


def _earth_lacking(system):
    if system.environment is not None:
        return ''
    if not system.orbit.has_lvlh:
        return 'orbit.type is fixed, which has no position above the Earth; leave the topic out'
    return (
        'the position above the Earth is not known; orbit.mu must be that of the Earth, and '
        'time.epoch be given'
    )


def _of_kind(kind: type[BodyTorque]) -> Topic:
    """Return the topic of a kind of torques, which a system has where such a torque acts."""

    def of(samples):
        return own_torque(_acting(samples.system, kind), samples.states)

    def force(samples):
        return own_force(_acting(samples.system, kind), samples.states)

    has_force = kind.force is not None
    return _torque(kind.topic, kind.title, of, _not_acting(kind), force if has_force else None)


def _acting(system, kind):
    return [torque for torque in system.torques if type(torque) is kind]


def _not_acting(kind):
    """Return what says why a system has no topic of a kind of torques."""

    def lacking(system):
        if _acting(system, kind):
            return ''
        return f'the torque {kind.name} does not act; leave the topic out'

    return lacking


def _inner(names: Iterable[str]) -> Callable[[Any], np.ndarray]:
    """Return what gives the inner coordinates of some names, (N, k)."""

    def of(samples):
        # What a live page hears has none.
        columns = (samples.states.inner.get(name, np.nan) for name in names)
        return np.column_stack([np.broadcast_to(column, len(samples)) for column in columns])

    return of


def _of_modes(kind: type[InnerMode], names: tuple[str, ...] = ()) -> Topic:
    """Return the topic of the modes of a kind that a scenario has, by their names."""
    return Topic(
        kind.group(),
        'sensor_msgs/msg/JointState',
        'state',
        'body',
        f'of {kind.says}: the modal displacement as position [sqrt(kg) m] and its rate as '
        f'velocity [sqrt(kg) m/s]; with {kind.names.name}',
        tuple(
            Shown(tuple(map(column_of, inner)), _inner(inner))
            for leaf in ('displacement', 'rate')
            for inner in [[f'{kind.group()}.{name}.{leaf}' for name in names]]
        ),
        Panel('modal displacement', 'm sqrt(kg)', names),
        lambda system: (
            ''
            if any(type(mode) is kind for mode in system.modes)
            else f'{kind.names.name} is empty; leave the topic out'
        ),
        names,
        ('position', 'velocity'),
    )


def _of_parts(kind: type[EnvironmentTorque], names: tuple[str, ...] = ()) -> Iterator[Topic]:
    """Yield the topic of the parts, of some names, that a kind of torques has, if it has one."""
    if kind.parts is None:
        return

    def shown(quantity):
        def of(samples):
            return quantity.of(*_acting(samples.system, kind), samples.states)

        return Shown(tuple(f'{name}_{quantity.column}' for name in names), of)

    yield Topic(
        kind.parts.name,
        'sensor_msgs/msg/JointState',
        'state',
        'body',
        kind.parts.says,
        tuple(map(shown, kind.parts.quantities)),
        Panel(kind.parts.title, kind.parts.unit, names),
        _not_acting(kind),
        names,
        tuple(quantity.field for quantity in kind.parts.quantities),
    )


def _of_states(kind: type[BodyTorque]) -> Topic:
    """Return the topic of the variables that a torque has of its own."""
    names = tuple(f'{kind.name}.{state}' for state in kind.states)
    return Topic(
        f'{kind.name}_states',
        'sensor_msgs/msg/JointState',
        'state',
        'body',
        f'the variables of the torque {kind.name} as position',
        (Shown(tuple(map(column_of, names)), _inner(names)),),
        Panel(f'variables of {kind.name}', '', tuple(kind.states)),
        _of_kind(kind).lacking,
        tuple(kind.states),
        ('position',),
    )


def _of_torque(kind: type[BodyTorque]) -> Iterator[Topic]:
    """Yield the topics of a kind of torques: the torque, and its variables if it has any."""
    yield _of_kind(kind)
    if kind.states:
        yield _of_states(kind)


def _acted_on():
    return (kind.acts_on for kind in ACTUATORS.values() if kind.acts_on is not None)


def _of_sensor(name: str, kind: type[Sensor]) -> Topic:
    return Topic(name, kind.message, 'sensor', '', kind.says)


def _of_actuator(topic: str, kind: type[Actuator]) -> Topic:
    return Topic(topic, kind.message, 'input', 'body', kind.says)


_TABLE = (
    Topic(
        'attitude',
        'geometry_msgs/msg/QuaternionStamped',
        'state',
        'inertial',
        'attitude, body to inertial',
        shows=(Q_IB,),
    ),
    Topic(
        'angular_velocity',
        'geometry_msgs/msg/VelocityStamped',
        'state',
        'body',
        'rate of the body relative to inertial in body axes [rad/s]; the linear part is zero',
        shows=(OMEGA_BI_B,),
    ),
    Topic(
        'imu',
        'sensor_msgs/msg/Imu',
        'state',
        'body',
        'attitude, body to inertial; body rate [rad/s]; the acceleration is marked absent',
        shows=(Q_IB, OMEGA_BI_B),
    ),
    Topic(
        'odometry',
        'nav_msgs/msg/Odometry',
        'state',
        'inertial',
        'position [m] and attitude in inertial; orbital velocity [m/s] and body rate [rad/s] in '
        'body axes',
        shows=(Q_IB, OMEGA_BI_B, _R_I, _V_B),
    ),
    Topic(
        'attitude_lvlh',
        'geometry_msgs/msg/QuaternionStamped',
        'state',
        'orbital',
        'attitude, body to LVLH; not for orbit.type fixed',
        shows=(_Q_LB,),
        lacking=_lvlh_lacking,
    ),
    _torque(GravityGradient.topic, GravityGradient.title, _gravity_gradient),
    *chain.from_iterable(map(_of_torque, dict.fromkeys((*ENVIRONMENT_TORQUES, *_acted_on())))),
    Topic(
        'magnetic_field',
        'sensor_msgs/msg/MagneticField',
        'state',
        'body',
        'true magnetic field of the Earth in body axes [T]; with environment.magnetic_field',
        (
            Shown(
                ('magnetic_field_b_x_t', 'magnetic_field_b_y_t', 'magnetic_field_b_z_t'),
                lambda samples: samples.states.magnetic_field_b,
            ),
        ),
        Panel('magnetic field', 'T'),
        _lacking('environment.magnetic_field', lambda along: along.field_model != 'none'),
    ),
    Topic(
        'sun_direction',
        'geometry_msgs/msg/Vector3Stamped',
        'state',
        'body',
        'unit vector to the Sun in body axes, in the shadow too; with environment.sun',
        (
            Shown(
                ('sun_direction_b_x', 'sun_direction_b_y', 'sun_direction_b_z'),
                lambda samples: samples.states.sun_direction_b,
            ),
        ),
        Panel('direction of the Sun', ''),
        _lacking('environment.sun', lambda along: along.has_sun),
    ),
    Topic(
        'sunlight',
        'sensor_msgs/msg/Illuminance',
        'state',
        'body',
        'illuminance of a plate that faces the Sun [lx], 0 in the umbra; with environment.sun',
        (Shown(('sunlight_lx',), lambda samples: samples.states.illuminance_lx[..., None]),),
        Panel('sunlight', 'lx'),
        _lacking('environment.sun', lambda along: along.has_sun),
    ),
    Topic(
        'geodetic',
        'sensor_msgs/msg/NavSatFix',
        'state',
        'earth',
        'latitude, longitude [deg] and height [m] on WGS 84, status 0 (STATUS_FIX), the '
        'covariance unknown; where it is among publish.topics at the start, /tf has inertial to '
        'earth',
        (
            Shown(('latitude_deg',), _geodetic(0, np.degrees(1.0))),
            Shown(('longitude_deg',), _geodetic(1, np.degrees(1.0))),
            Shown(('height_m',), _geodetic(2, 1.0)),
        ),
        lacking=_earth_lacking,
    ),
    Topic(
        'rotor',
        'sensor_msgs/msg/JointState',
        'state',
        'body',
        'angle [rad], speed relative to the body [rad/s] and motor torque after its limits [N m] '
        'of all rotors; arrays are empty where no rotor has such a value',
    ),
    *map(_of_modes, MODE_KINDS),
    *(topic for kind in ENVIRONMENT_TORQUES for topic in _of_parts(kind)),
    Topic(
        'thruster',
        'sensor_msgs/msg/JointState',
        'state',
        'body',
        'of each thruster by name, the thrust as effort [N], and as position the propellant used '
        'since tick 0 [kg], nan without specific_impulse; with thruster.names',
        lacking=_not_acting(Thrust),
    ),
    Topic(
        'markers',
        'visualization_msgs/msg/MarkerArray',
        'state',
        'body',
        'body and body axes, and the directions of nadir, rate, momentum and, where the magnetic '
        'field turns one, the dipole',
    ),
    Topic(
        '/tf',
        'tf2_msgs/msg/TFMessage',
        'state',
        'inertial',
        'inertial to LVLH, where there is an orbit; inertial to earth, where geodetic is '
        'published; inertial to body',
    ),
    Topic(
        '/tf_static',
        'tf2_msgs/msg/TFMessage',
        'latched',
        'body',
        'body to each sensor (its mounting), once, with the stamp of tick 0, latched for '
        'subscribers that come later; only with sensors',
    ),
    *(_of_sensor(name, kind) for name, kind in KINDS.items()),
    Topic(
        '/clock',
        'rosgraph_msgs/msg/Clock',
        'clock',
        '',
        'the stamp of the samples that follow',
    ),
    Topic(
        '/diagnostics',
        'diagnostic_msgs/msg/DiagnosticArray',
        'diagnostics',
        '',
        'drift of the first integrals, pacing, recorder, inputs and connections, once per second',
    ),
    *(_of_actuator(kind.topic, kind) for kind in ACTUATORS.values()),
)

# By the names in publish.topics: without a slash.
TOPICS: dict[str, Topic] = {topic.name.lstrip('/'): topic for topic in _TABLE}
STATE_TOPICS = tuple(name for name, topic in TOPICS.items() if topic.role == 'state')


def topics_with(
    torques: Iterable[type[BodyTorque]],
    sensors: Mapping[str, type[Sensor]],
    commanded: Iterable[str] = (),
    names: Mapping[str, tuple[str, ...]] = NO_NAMES,
    tick_s: float = 1.0,
) -> dict[str, Topic]:
    """
    Return the topics of scenarios with torques and sensors of these kinds, by their names.

    Parameters
    ----------
    torques : iterable of classes
        their kinds
    sensors : dict of classes
        their kinds, by their names
    commanded : iterable of str
        the topics of the actuators
    names : dict of tuples of str
        of parts, by flexible.names and so on
    tick_s : s
        from tick to tick, over which the panel of the thrusters has the mean, as pulses may be
        shorter

    Raises
    ------
    ValueError
        a topic of a torque, or a sensor, has the name of another topic
    """
    of_parts = [_of_modes(kind, names.get(kind.names.name, ())) for kind in MODE_KINDS]
    for kind in ENVIRONMENT_TORQUES:
        of_parts += _of_parts(kind, names.get(kind.keys[0].name, ()) if kind.of_each else ())
    table = TOPICS | {topic.name: topic for topic in of_parts}
    for own in torques:
        for topic in _of_torque(own):
            if topic.name in table:
                raise ValueError(
                    f'{topic.name} is the topic of the torque {own.name} and of another'
                )
            table[topic.name] = topic
    for name, sensor in sensors.items():
        if name in table and table[name].role != 'sensor':
            raise ValueError(f'sensors.names has {name}, which is a topic; give another name')
        table[name] = _of_sensor(name, sensor)
    for name in commanded:
        actuator = kind_of(name)
        if name != actuator.topic:
            table.pop(actuator.topic, None)
            table[name] = _of_actuator(name, actuator)
    if thrusters := names.get('thruster.names'):
        table['thruster'] = _with_mean_thrust(table['thruster'], thrusters, tick_s)
    return table


def _with_mean_thrust(topic, names, tick_s):
    def of(samples):
        return thrust_of(samples.system).mean_thrusts(samples.states.orbit_s, tick_s)

    shows = (Shown(tuple(f'{name}_mean_thrust_n' for name in names), of),)
    return replace(topic, shows=shows, panel=Panel('mean thrust in a tick', 'N', names))
