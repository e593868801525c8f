"""The table of a scenario's keys: type, unit, range, default and meaning of each."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

from ..actuators import ACTUATORS, Actuator
from ..base.key import Key, part_key
from ..dynamics.mode_kinds import MODE_KINDS
from ..dynamics.rotor_keys import ROTOR_KEYS, ROTOR_NAMES
from ..environment.environment_keys import ENVIRONMENT_KEYS
from ..orbits.fixed import GRADIENT
from ..orbits.orbit_keys import keys_of_orbits
from ..sensors import KINDS
from ..sensors.sensor_keys import keys_of_sensor, keys_of_sensors
from ..torques import ENVIRONMENT_TORQUES, BodyTorque
from ..torques.plates import COEFFICIENTS, KEYS_OF_A_PLATE, KEYS_OF_THE_SURFACE
from ..torques.weight import Weight
from .ticks import LAST_STAMP_NS
from .topics import NO_NAMES, STATE_TOPICS, topics_with


def _of_actuator(kind: type[Actuator]) -> Iterator[Key]:
    """Yield the keys of a kind of actuators; one that says a size of it may be that of a part."""
    yield from map(
        part_key, dict.fromkeys(key.name.split('.')[0] for key in kind.keys if key.unit)
    )
    yield from (replace(key, is_optional=True) for key in kind.keys)


# 5 deg of roll and 10 deg of pitch to LVLH.
_DEFAULT_ATTITUDE = (
    0.0434534024273578,
    0.0870727897926938,
    -0.0038016801040236755,
    0.9952465414778341,
)
_INT64 = 2**63 - 1

KEYS = {
    key.name: key
    for key in (
        Key(
            'body.inertia',
            'double_array',
            (800.0, 900.0, 600.0),
            'kg m^2',
            '3 principal moments, the 6 tensor entries ixx iyy izz ixy ixz iyz, or 9 row-major; '
            'locked rotor included; about the mass centre, or about the fixed point where there '
            'is a weight moment',
            lengths=(3, 6, 9),
        ),
        *Weight.keys,
        *(replace(key, is_optional=True) for kind in ENVIRONMENT_TORQUES for key in kind.keys),
        *KEYS_OF_THE_SURFACE,
        *(replace(kind.names, is_optional=True) for kind in MODE_KINDS),
        ROTOR_NAMES,
        part_key('rotor'),
        *ROTOR_KEYS,
        *keys_of_orbits(),
        *ENVIRONMENT_KEYS,
        GRADIENT,
        Key(
            'initial.attitude',
            'double_array',
            _DEFAULT_ATTITUDE,
            '',
            'unit quaternion x, y, z, w from body to initial.frame',
            lengths=(4,),
            changes='service',
        ),
        Key(
            'initial.roll_pitch_yaw',
            'double_array',
            (),
            'rad',
            '3-2-1 angles of the body relative to initial.frame, in place of initial.attitude, '
            'which then has the value; empty: not given',
            lengths=(0, 3),
            changes='service',
        ),
        Key(
            'initial.pointing',
            'string',
            '',
            '',
            'what initial.pointing_axis points at, in place of initial.attitude, which then has '
            'the value: the attracting centre, the Sun, or initial.direction; empty: not given',
            choices=('', 'nadir', 'sun', 'inertial'),
            changes='service',
        ),
        Key(
            'initial.pointing_axis',
            'double_array',
            (0.0, 0.0, 1.0),
            '',
            'the body axis that points, with initial.pointing',
            lengths=(3,),
            changes='service',
        ),
        Key(
            'initial.second_axis',
            'double_array',
            (1.0, 0.0, 0.0),
            '',
            'the body axis that is then as near as possible to the velocity for nadir, and to the '
            'normal of the orbit else (orbit.type fixed: inertial Z)',
            lengths=(3,),
            changes='service',
        ),
        Key(
            'initial.direction',
            'double_array',
            (0.0, 0.0, 0.0),
            '',
            'what is pointed at, inertial axes; initial.pointing inertial only',
            lengths=(3,),
            changes='service',
        ),
        Key(
            'initial.frame',
            'string',
            'lvlh',
            '',
            'frame of the initial attitude and rate; orbit.type fixed: inertial',
            choices=('inertial', 'lvlh'),
            changes='service',
        ),
        Key(
            'initial.angular_velocity',
            'double_array',
            (0.0, 0.0, 0.0),
            'rad/s',
            'initial body rate relative to initial.frame, body axes',
            lengths=(3,),
            changes='service',
        ),
        Key(
            'motion.method',
            'string',
            'numeric',
            '',
            'numeric: propagation; exact: closed form, refused where there is none; auto: exact '
            'where one applies',
            choices=('numeric', 'exact', 'auto'),
        ),
        Key(
            'motion.tolerance',
            'double',
            1e-13,
            '',
            'relative local error of the numeric propagation',
            low=1e-14,
            high=1e-3,
        ),
        Key('publish.rate', 'double', 100.0, 'Hz', 'ticks per second', above=0.0, high=1e4),
        Key(
            'publish.topics',
            'string_array',
            STATE_TOPICS[:4],
            '',
            'the topics to publish',
            choices=STATE_TOPICS,
            changes='running',
        ),
        Key(
            'time.epoch_ns',
            'integer',
            0,
            'ns',
            'stamp of tick 0; 0: the wall clock at the first tick, rounded to a microsecond',
            low=0,
            high=LAST_STAMP_NS,
        ),
        Key(
            'time.epoch',
            'epoch',
            '',
            '',
            'stamp of tick 0 in UTC, in place of time.epoch_ns, which then has the value; empty: '
            'not given',
        ),
        Key(
            'time.factor',
            'double',
            1.0,
            's/s',
            'simulated seconds per wall second; 0: as fast as possible',
            low=0.0,
            high=1e6,
            changes='running',
        ),
        Key(
            'time.publish_clock',
            'bool',
            False,
            '',
            "publish /clock just before each sample, with the sample's stamp",
        ),
        Key(
            'realtime.priority',
            'integer',
            0,
            '',
            'SCHED_FIFO priority of the thread that paces the ticks, where the system allows it; '
            '0: none',
            low=0,
            high=99,
        ),
        Key(
            'realtime.cpu',
            'integer',
            -1,
            '',
            'the processor that this thread runs on; -1: any',
            low=-1,
            high=4095,
        ),
        Key(
            'realtime.lock_memory',
            'bool',
            False,
            '',
            'keep the process in memory (mlockall), where the system allows it',
        ),
        Key(
            'step.ticks',
            'integer',
            1,
            '',
            'number of ticks in one ~/step',
            low=1,
            high=10**9,
            changes='running',
        ),
        Key(
            'torque.timeout',
            'double',
            1.0,
            's',
            'simulated time after which an applied torque drops to zero; 0: never',
            low=0.0,
            changes='running',
        ),
        *(key for kind in ACTUATORS.values() for key in _of_actuator(kind)),
        *keys_of_sensors(),
        Key('record.enabled', 'bool', False, '', 'record from the first tick'),
        Key('record.directory', 'string', '.', '', 'directory for bags'),
        Key(
            'record.compression',
            'string',
            'zstd',
            '',
            "compression of a bag's chunks",
            choices=('none', 'lz4', 'zstd'),
        ),
        Key(
            'record.max_size_bytes',
            'integer',
            0,
            'byte',
            'size at which a bag continues in a new file; 0: never',
            low=0,
            high=_INT64,
        ),
        Key(
            'record.max_duration_s',
            'double',
            0.0,
            's',
            'simulated time after which a bag continues in a new file; 0: never',
            low=0.0,
        ),
        Key('frames.inertial', 'string', 'inertial', '', 'frame id of the inertial axes'),
        Key('frames.orbital', 'string', 'lvlh', '', 'frame id of LVLH'),
        Key('frames.body', 'string', 'base_link', '', 'frame id of the body axes'),
        Key(
            'frames.earth',
            'string',
            'earth',
            '',
            'frame id of the axes that turn with the Earth',
            is_optional=True,
        ),
    )
}


# The first parts of keys.
GROUPS = frozenset(name.split('.')[0] for name in KEYS)
_NONE: Mapping[str, str] = MappingProxyType({})
# What describes one rotor.
_OF_A_ROTOR = tuple(
    name.removeprefix('rotor.')
    for name in KEYS
    if name.startswith('rotor.') and name != 'rotor.names'
)


# By the keys of names what describes each of those that have one, and names that none may have.
_OF_EACH: dict[str, tuple[Sequence[Key], tuple[str, ...]]] = {
    'rotor.names': ([KEYS[f'rotor.{leaf}'] for leaf in _OF_A_ROTOR], _OF_A_ROTOR),
    'surface.names': (KEYS_OF_A_PLATE, tuple(key.name for key in COEFFICIENTS)),
    **{kind.names.name: (kind.of_each(), ()) for kind in MODE_KINDS},
    **{kind.keys[0].name: (kind.of_each, ()) for kind in ENVIRONMENT_TORQUES if kind.of_each},
    **{
        kind.keys[0].name: ((part_key(kind.keys[0].name.split('.')[0]), *kind.of_each), ())
        for kind in ACTUATORS.values()
        if kind.of_each
    },
}
# The keys that decide on other keys.
NAMES_OF_EACH = tuple(_OF_EACH)
# Of what has a direction: the key of its names, and the last word of the key of the direction.
DIRECTIONS = tuple(
    (names, key.name.rpartition('.')[2])
    for names, (keys, _) in _OF_EACH.items()
    for key in keys
    if key.is_direction
)


def keys_of(
    names: Mapping[str, tuple[str, ...]] = NO_NAMES,
    torques: Sequence[type[BodyTorque]] = (),
    sensors: Mapping[str, str] = _NONE,
) -> dict[str, Key]:
    """
    Return the keys of a scenario with these names and these torques, by name.

    Parameters
    ----------
    names : dict of tuples of str
        by rotor.names and the other NAMES_OF_EACH
    torques : sequence of classes
        their kinds
    sensors : dict of str
        the type, by the names of those for which it is given

    Raises
    ------
    ValueError
        a name is not an identifier, or is itself a key; a torque or a sensor has a key or a topic
        of another's name
    """
    named: dict[str, Key] = {}
    for key, given in names.items():
        group, (keys, taken) = key.partition('.')[0], _OF_EACH[key]
        _check_names(group, given, taken)
        named |= _of_each(group, given, keys)
    of_torques = {key.name: key for torque in torques for key in torque.keys}
    if known := of_torques.keys() & {*KEYS, *named}:
        raise ValueError(f'{min(known)} is a key of a torque; a scenario has a key of this name')
    table = topics_with(torques, {name: KINDS[kind] for name, kind in sensors.items()})
    if torques:
        states = tuple(name for name, topic in table.items() if topic.role == 'state')
        of_torques['publish.topics'] = replace(KEYS['publish.topics'], choices=states)
    for name, kind in sensors.items():
        named |= {key.name: key for key in keys_of_sensor(name, kind)}
    return KEYS | named | of_torques if named or of_torques else KEYS


def _of_each(group, names, keys):
    """Return the keys of each of some parts by their names."""
    full_names = (
        (f'{group}.{name}.{key.name.rpartition(".")[2]}', key) for name in names for key in keys
    )
    return {full_name: replace(key, name=full_name) for full_name, key in full_names}


def _check_names(group, names, taken):
    for name in names:
        if not (name.isidentifier() and name.isascii()) or name in (*taken, 'names'):
            raise ValueError(
                f'{group}.names has {name!r}; a name has letters, digits and _, does not '
                f'begin with a digit and is none of {", ".join(("names", *taken))}'
            )
