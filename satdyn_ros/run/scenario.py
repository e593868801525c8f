"""One validated description of a run."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from ..actuators import Equipment
from ..base.key import Key
from ..base.sentences import nearest, refuse
from ..dynamics import inertia
from ..dynamics.integrals import first_integrals
from ..dynamics.motion import Motion, States
from ..dynamics.system import State, System
from ..integrate.propagation import Propagation
from ..kernel import rotation
from ..sensors import Sensor
from ..torques.body_torque import BodyTorque, checked_kind, torque_of
from . import (
    checks,
    environment,
    in_place,
    modes,
    orbits,
    parts,
    pointing,
    rotors,
    sensors,
    unlikely_values,
)
from .keys import GROUPS, KEYS, NAMES_OF_EACH, keys_of
from .parameter_file import (
    ParameterFile,
    flattened,
    with_texts,
    without_rclpys,
    yaml_of_parameters,
)
from .rules import PLATES_FOLLOW_THE_SURFACE, RULES, corner_search
from .ticks import rate_of
from .topics import Topic, topics_with

_ATTITUDE = 'initial.attitude'


@dataclass(frozen=True)
class Frames:
    """
    The frame ids of the inertial, orbital and body axes, and of those that turn with the Earth.

    has_earth: whether /tf has the last.  sensors: frame ids of the sensors' axes, each with its
    mounting, a quaternion to body axes.
    """

    inertial: str = 'inertial'
    orbital: str = 'lvlh'
    body: str = 'base_link'
    earth: str = 'earth'
    has_earth: bool = False
    sensors: tuple[tuple[str, tuple[float, ...]], ...] = ()


class Scenario:
    """
    A validated run: immutable, every key in `values` by its dotted name, described in `keys`.

    Scenario.from_yaml and Scenario.from_dict read one.

    Parameters
    ----------
    given : mapping
        values by the dotted names of their keys
    torques : classes
        torques of your own, whose keys the scenario has too
    warnings : sentences
        about the source of the values
    rules : int
        of the bag that it is read from
    at_s : s
        as for with_values

    Attributes
    ----------
    typed : dict
        the given texts with a unit, and the given parts, by the names of their keys
    warnings : sentences
        about values that are allowed but rarely intended

    Raises
    ------
    ValueError
        a value is not allowed, in one sentence that names the key

    Examples
    --------
    >>> Scenario.from_dict({'publish': {'rate': 10}})['publish.rate']
    10.0
    """

    def __init__(
        self,
        given: Mapping[str, Any] | None = None,
        torques: Iterable[type[BodyTorque]] = (),
        warnings: Iterable[str] = (),
        rules: int = RULES,
        at_s: float = 0.0,
    ):
        given, self.rules = parts.laid_under(given or {}), rules
        self.torques = tuple(checked_kind(kind) for kind in torques)
        names = {name: KEYS[name].checked(given.get(name, ())) for name in NAMES_OF_EACH}
        keys: dict[str, Key] = keys_of(names, self.torques, sensors.given_types(given))
        unknown = [name for name in given if name not in keys]
        if unknown:
            raise ValueError(_unknown(unknown[0], given, keys))
        checked = {name: keys[name].checked(value) for name, value in given.items()}
        named = parts.named(given)
        self.typed = named | {name: x for name, x in given.items() if keys[name].has_unit(x)}
        values = {name: key.default for name, key in keys.items()} | checked
        self._followed: dict[str, Any] = {}
        if rules >= PLATES_FOLLOW_THE_SURFACE:
            of_surface = environment.of_the_surface(names['surface.names']).items()
            self._followed = {name: values[key] for name, key in of_surface if name not in given}
            values |= self._followed
        if not orbits.type_of(values).has_lvlh and 'initial.frame' not in given:
            values['initial.frame'] = 'inertial'
        with np.errstate(all='ignore'):
            refuse(checks.units(values))
            doubts = unlikely_values.in_place(values, self.typed)
            self._warnings = *warnings, *checks.divided(values), *doubts
            values |= checks.as_units(values) | in_place.resolved(values, given)
            for check in checks.ALL_CHECKS:
                refuse(check(values))
            # It may refuse what its keys allow one by one.
            orbits.orbit_of(values, rules)
            pointing.check(values, given)
            values |= in_place.NOT_GIVEN | dict.fromkeys(named, '')
            if pointed := pointing.resolved(values, at_s, rules):
                values |= pointed | {_ATTITUDE: KEYS[_ATTITUDE].checked(pointed[_ATTITUDE])}
        self.keys: Mapping[str, Key] = MappingProxyType(keys)
        self.values: Mapping[str, Any] = MappingProxyType(values)
        for kind in self.torques:
            # It may refuse what its keys allow one by one.
            torque_of(kind, self.values)
        if values['motion.method'] == 'exact':
            self.motion()

    # -- reading and writing ---------------------------------------------------------------------

    @classmethod
    def from_dict(
        cls, nested: Mapping[str, Any], torques: Iterable[type[BodyTorque]] = ()
    ) -> 'Scenario':
        """
        Return the scenario of nested or dotted keys.

        Parameters
        ----------
        nested : mapping
            values by key.  An orbit.file, or an orbit.tle of one text, without a line break is the
            name of a file, relative to the working directory; with one it is the text.  An
            orbit.tle of two texts is a file, and the number or name of a satellite in it
        torques : classes
            torques of your own

        Raises
        ------
        ValueError
            as for the class
        """
        return cls(with_texts(dict(flattened(nested))), torques)

    @classmethod
    def from_yaml(
        cls,
        path: str | Path,
        satellite: str | None = None,
        torques: Iterable[type[BodyTorque]] = (),
    ) -> 'Scenario':
        """
        Return the scenario of a ROS 2 parameter file, or of a shipped one by its name.

        Parameters
        ----------
        path : str or Path
            the file, or the name of a shipped scenario
        satellite : str
            which one, if the file has several, such as /sat4/satdyn or /sat4
        torques : classes
            torques of your own

        Raises
        ------
        ValueError
            as for the class; or the file has several satellites, or not this one
        """
        return cls._of_file(ParameterFile.read([path]), satellite, torques)

    @classmethod
    def from_yaml_text(
        cls,
        text: str,
        origin: str = 'scenario',
        satellite: str | None = None,
        torques: Iterable[type[BodyTorque]] = (),
    ) -> 'Scenario':
        """
        Return the scenario of a ROS 2 parameter file's text.

        Parameters
        ----------
        text : str
            YAML
        origin : str
            names the text in errors
        satellite : str
            which one, if the text has several
        torques : classes
            torques of your own

        Raises
        ------
        ValueError
            as for from_yaml
        """
        return cls._of_file(ParameterFile.of_texts([(text, origin)]), satellite, torques)

    @classmethod
    def _of_file(cls, file, satellite, torques):
        full_name = file.full_name(satellite)
        values = without_rclpys(file.flown(full_name))
        return cls(values, torques, file.unused(full_name))

    def to_yaml(self) -> str:
        """Return the text of a ROS 2 parameter file with every key that has a value of its own."""
        own = {name: x for name, x in self.values.items() if not self._is_resolved(name)}
        optional = {name for name, key in KEYS.items() if key.is_optional}
        for name in set(map(rotors.unnamed, own)) & optional:
            for each in [each for each in own if rotors.unnamed(each) == name]:
                if own[each] == KEYS[name].default:
                    del own[each]
        return yaml_of_parameters(own)

    @classmethod
    def of_many(cls, values: Mapping[str, Any]) -> 'Scenario':
        """
        Return M scenarios as one, with a system and an initial state of arrays.

        Parameters
        ----------
        values : mapping
            of every key, known to be valid (many.py); values that differ as (M, 1) or (M, 1, k)
        """
        many = object.__new__(cls)
        # Without an instant of tick 0 there is no environment, which many do not fly in together.
        timeless = MappingProxyType({**values, 'time.epoch_ns': 0})
        many.values, many.keys, many.torques, many.rules = timeless, KEYS, (), RULES
        return many

    def with_values(self, changes: Mapping[str, Any], at_s: float = 0.0) -> 'Scenario':
        """
        Return the scenario with some keys changed.

        Parameters
        ----------
        changes : mapping
            new values by the dotted names of their keys
        at_s : s
            time from tick 0 for which an initial.pointing among them holds

        Raises
        ------
        ValueError
            as for the class
        """
        # A part gives what it says, whatever was given before.
        changes = parts.laid_under(changes)
        # What follows from other keys follows from their new values.
        replaced = in_place.replaced(changes)
        left_out = {*replaced, *self._followed}
        kept = {name: x for name, x in self.values.items() if name not in left_out}
        # A warning begins with the key that it is about.
        new = {*changes, *replaced}
        stay = [text for text in self._warnings if not {*in_place.of(text.split()[0])} & new]
        changed = Scenario({**kept, **changes}, self.torques, stay, self.rules, at_s)
        typed = {n: text for n, text in self.typed.items() if n not in {*changes, *replaced}}
        changed.typed = typed | changed.typed
        if all(name.startswith('initial.') for name in changes):
            # A learning loop starts the same body at every episode: what follows from it stays.
            vars(changed)['system'] = self.system
        return changed

    def with_seed(self) -> 'Scenario':
        """Return the scenario with a seed of 0 drawn, where it has sensors."""
        if self['sensors.seed'] or not self['sensors.names']:
            return self
        return self.with_values({'sensors.seed': sensors.drawn_seed()})

    def with_epoch(self, wall_ns: int) -> 'Scenario':
        """Return the scenario with an epoch of 0 set to a time, rounded to a microsecond."""
        if self.epoch_ns:
            return self
        return self.with_values({'time.epoch_ns': round(wall_ns, -3)})

    def _is_resolved(self, name):
        """Return whether a key is given in place of another, which has its value."""
        is_pointing = name in pointing.POINTING and not self['initial.pointing']
        return name in in_place.IN_PLACE or parts.names_one(name) or is_pointing

    def __getitem__(self, name: str) -> Any:
        return self.values[name]

    def __deepcopy__(self, memo: object) -> 'Scenario':
        """Return itself: it never changes."""
        return self

    def __repr__(self) -> str:
        method, frame = self['motion.method'], self['initial.frame']
        what = f'{float(self.rate):g} Hz'
        if (key := environment.needs_epoch(self.values)) and not self.epoch_ns:
            return f'<Scenario: {key} {self[key]}, {method}, from {frame}, {what}>'
        return f'<Scenario: {self.system}, {method}, from {frame}, {what}>'

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Scenario)
            and dict(self.values) == dict(other.values)
            and self.torques == other.torques
        )

    def __hash__(self) -> int:
        return hash(tuple(self.values.items()))

    # -- what it describes -----------------------------------------------------------------------

    @property
    def initial_conditions(self) -> tuple[str, ...]:
        """The keys that a request may give."""
        return tuple(key.name for key in self.keys.values() if key.changes == 'service')

    @property
    def is_fixed(self) -> bool:
        """Whether the attracting centre is in a fixed direction: no orbit, no LVLH."""
        return not orbits.type_of(self.values).has_lvlh

    @property
    def frames(self) -> Frames:
        """The frame ids."""
        mounted = tuple(
            (self[f'sensors.{name}.frame_id'], self[f'sensors.{name}.mounting'])
            for name in self.sensors
        )
        return Frames(
            self['frames.inertial'],
            self['frames.orbital'],
            self['frames.body'],
            self['frames.earth'],
            'geodetic' in self.topics,
            mounted,
        )

    @property
    def topics(self) -> tuple[str, ...]:
        """The published topics."""
        return self['publish.topics']

    @cached_property
    def topic_table(self) -> dict[str, Topic]:
        """The topics that it may have, by their names in publish.topics and sensors.names."""
        kinds = sensors.kinds(self.values)
        names = {name: self[name] for name in NAMES_OF_EACH}
        topics, tick_s = self.equipment.topics, float(1 / self.rate)
        return topics_with(self.torques, kinds, topics, names, tick_s)

    @cached_property
    def equipment(self) -> Equipment:
        """The actuators."""
        return Equipment(self.values, rotors.rotors_of(self.values))

    @property
    def inputs(self) -> tuple[str, ...]:
        """The topics of what can be commanded, by their names in the table of topics."""
        return self.equipment.topics

    @cached_property
    def sensors(self) -> dict[str, Sensor]:
        """The sensors by name, in the order in which they publish."""
        return sensors.of(self.values, float(self.rate))

    @property
    def epoch_ns(self) -> int:
        """The stamp of tick 0."""
        return self['time.epoch_ns']

    @cached_property
    def rate(self) -> Fraction:
        """Ticks a second, the simplest fraction that rounds to the given number."""
        return rate_of(self['publish.rate'])

    @property
    def ticks_per_wall_s(self) -> float:
        """Ticks a second of the wall clock, 0: as many as possible."""
        return float(self.rate) * self['time.factor']

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is allowed and rarely meant, each in one sentence."""
        return self._warnings + unlikely_values.warnings(self.values, self.rules, self.typed)

    def warnings_about(self, names: Iterable[str]) -> list[str]:
        """Return the warnings about some keys."""
        return [sentence for sentence in self.warnings if sentence.split()[0] in set(names)]

    @cached_property
    def system(self) -> System:
        """What moves, with no torque applied but those that are its own."""
        if (key := environment.needs_epoch(self.values)) and not self.epoch_ns:
            raise ValueError(
                f'time.epoch_ns is 0, the wall clock at the first tick; {key} {self[key]} needs '
                'the instant of tick 0: give time.epoch'
            )
        orbit = orbits.orbit_of(self.values, self.rules)
        along_orbit = environment.along(self.values, orbit, self.rules)
        own = (torque for kind in self.torques if (torque := torque_of(kind, self.values)))
        return System(
            inertia=inertia.entries(self['body.inertia']),
            rotors=rotors.rotors_of(self.values),
            orbit=orbit,
            weight_moment=np.array(self['body.weight_moment']),
            environment=along_orbit,
            torques=(
                *environment.torques_of(self.values, along_orbit),
                *own,
                *self.equipment.torques(),
            ),
            corner_search=corner_search(self.rules),
            modes=modes.modes_of(self.values),
        )

    @cached_property
    def initial_state(self) -> State:
        """The initial conditions as a state at tick 0."""
        return self.state_at(0.0)

    def state_at(self, orbit_s: float) -> State:
        """
        Return the initial conditions as a state.

        Parameters
        ----------
        orbit_s : s
            time from tick 0 at which LVLH is taken
        """
        q_ib, omega_bi_b = np.array(self['initial.attitude']), self['initial.angular_velocity']
        if self['initial.frame'] == 'lvlh':
            orbit = self.system.orbit
            q_ib = rotation.normalise(rotation.multiply(orbit.lvlh(orbit_s), q_ib))
            rate_b = rotation.rotate(rotation.conjugate(q_ib), orbit.lvlh_rate(orbit_s))
            omega_bi_b = rate_b + omega_bi_b
        speeds, angles = rotors.speeds_and_angles(self.values, self.system.rotors)
        return State(q_ib, np.array(omega_bi_b), speeds, angles, modes.inner(self.values))

    def motion(self) -> Motion:
        """
        Return the motion from tick 0.

        Raises
        ------
        ValueError
            motion.method is exact, and there is no closed form
        """
        return self.motion_from(self.system, self.initial_state, 0.0)

    def motion_from(
        self,
        system: System,
        state: State,
        start_s: float,
        most_steps: int | None = None,
        after: Motion | None = None,
    ) -> Motion:
        """
        Return the motion of a system from a state, by motion.method.

        Parameters
        ----------
        system : System
            what moves
        state : State
            its state at start_s
        start_s : s
            time from tick 0
        most_steps : int
            as for a Propagation
        after : Motion
            one of the same body under other torques that ends there, if there is one
        """
        method = self['motion.method']
        if method != 'numeric':
            from .. import exact

            motion = exact.recognise(system, state, start_s)
            if motion is not None:
                return motion
            if method == 'exact':
                reason = exact.explain(system, state)
                raise ValueError(f'motion.method is exact, but there is no closed form: {reason}')
        before = after if isinstance(after, Propagation) else None
        return Propagation(system, state, start_s, self['motion.tolerance'], most_steps, before)

    def integrals(self, states: States) -> dict[str, np.ndarray]:
        """
        Return the first integrals that this scenario conserves, name to values (N,).

        Parameters
        ----------
        states : States
            N rows of its motion
        """
        return first_integrals(self.system, states)


def _unknown(name: str, given: Mapping[str, Any], keys: Iterable[str]) -> str:
    """Return the sentence on a key that there is not."""
    what, _, rest = name.partition('.')
    named, _, leaf = rest.partition('.')
    said, group = f'{name} is not a parameter of a scenario', f'{what}.{named}' if leaf else what
    leaves = [key.removeprefix(f'{group}.') for key in keys if key.startswith(f'{group}.')]
    if leaves and (leaf or what not in GROUPS):
        return f'{said}; {group} has {", ".join(leaves)}'
    names = given.get(f'{what}.names')
    names = list(map(str, names)) if isinstance(names, list | tuple) else []
    if leaf and f'{what}.names' in KEYS and named not in names:
        has = f'; it has {", ".join(names)}' if names else ''
        return f'{name} is given, but {what}.names has no {named}{has}'
    said += f'; the nearest is {nearest(name, keys)}'
    if not rest or leaves or what in GROUPS:
        return said
    return f'{said}; a key of a torque of your own needs --torque MODULE:CLASS'
