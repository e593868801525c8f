"""What a torque on the body is: one class, from which all else follows."""

import inspect
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from hashlib import sha256
from numbers import Real
from typing import Any, ClassVar, TypeVar

import numpy as np

from ..base.imports import own_module
from ..base.key import Key
from ..kernel.time_table import Table
from ..orbits.pieces import Pieces
from .own_source import source_of

_Same = TypeVar('_Same', bound='BodyTorque')


def _no_torque(*seen: Any) -> tuple[float, ...]:
    raise NotImplementedError


class BodyTorque:
    """
    A torque on the body; each kind is a subclass.

    A class without name or Constants is a base of others, and no torque.

    torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants) -> (x, y, z) [N m], body axes: t_s is the
    time from tick 0 [s], r_i [m] and v_i [m/s] position and velocity on the orbit, zero without
    one.  It is a plain function of floats.  It is called once with symbols in their place, from
    which code is made, and with columns of them for tables of states.  So it may use arithmetic,
    whole powers, comparisons, min, max, hypot and the functions of math that kernel/functions.py
    has, and chooses by select where another function would use if.

    Three more functions of the same arguments are optional:

        signs(...) -> (x, ...): where the torque has a corner, one of these changes its sign, and
            steps end there
        potential(...) -> V [J]: the torque is that of V.  If the torque and its axes are steady, V
            is part of the energy that is conserved; otherwise the torque does work
        force(...) -> (x, y, z) [N], body axes: published beside the torque; it moves nothing

    A torque with states has rates(..., constants, states) -> (x', ...) [1/s], with which they are
    integrated; torque, signs and potential are then functions of (..., constants, states).

    Attributes
    ----------
    name : str
        the beginning of its keys
    keys : tuple of Key
        what a scenario says about it
    topic : str
        on which it is published if it acts and publish.topics says so; by default NAME_torque
    title : str
        of its panel; by default the words of the topic
    Constants : NamedTuple
        floats, tuples of floats and arrays, from which the torque is computed
    is_steady : bool
        whether it depends on attitude and rate alone, as seen from axes that turn with a circular
        orbit
    largest : N m
        the size to which it grows from nothing at once, by which the steps of a body at rest are
        judged; 0: it does not
    pieces : mapping
        by the name of a field of Constants that is a Table: what makes it for one piece of time
        after the other, for what depends on time alone, such as the magnetic field along the orbit
    states : tuple of str
        names of variables of its own, such as the lag of a valve
    initial, scales : tuples or functions
        their values at the start, and the sizes to which their errors are compared; as functions
        initial(t_s, r_i, v_i, q_ib, omega_bi_b, constants) and scales(constants)

    Examples
    --------
    >>> from typing import NamedTuple
    >>> class Push(BodyTorque):
    ...     name = 'push'
    ...     class Constants(NamedTuple):
    ...         size: float
    ...     @staticmethod
    ...     def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
    ...         return constants.size, 0.0, 0.0
    >>> Push(Push.Constants(0.1)).name
    'push'
    """

    name: ClassVar[str]
    keys: ClassVar[tuple[Key, ...]] = ()
    topic: ClassVar[str]
    title: ClassVar[str]
    is_steady: ClassVar[bool] = False
    largest: float = 0.0
    Constants: ClassVar[Any]
    torque: ClassVar[Callable[..., tuple[float, ...]]] = staticmethod(_no_torque)
    signs: ClassVar[Callable[..., tuple[float, ...]] | None] = None
    potential: ClassVar[Callable[..., float] | None] = None
    force: ClassVar[Callable[..., tuple[float, ...]] | None] = None
    states: tuple[str, ...] = ()
    initial: Any = ()
    scales: Any = ()
    rates: ClassVar[Callable[..., tuple[float, ...]] | None] = None

    def __init__(self, constants: Any, pieces: Mapping[str, Pieces] | None = None):
        fields, own = getattr(constants, '_fields', ()), self.Constants
        if fields != own._fields:
            raise TypeError(f'its Constants are {constants!r}; they must have {own._fields}')
        # By the type of its own the equations know the function.
        self.constants = own(*map(_as_floats, constants, fields))
        self.pieces = dict(pieces or {})

    def __init_subclass__(cls) -> None:
        """Let the equations call the function of a new torque, if it is a whole one."""
        if isinstance(name := getattr(cls, 'name', None), str):
            cls.topic = vars(cls).get('topic', f'{name}_torque')
            cls.title = vars(cls).get('title', cls.topic.replace('_', ' '))
        if _missing(cls):
            return
        if 'Constants' not in vars(cls) or cls.Constants in KIND_OF:
            # Those of another torque, by which the equations would call its function.
            names = {'__module__': cls.__module__, '__qualname__': f'{cls.__qualname__}.Constants'}
            cls.Constants = type('Constants', (cls.Constants,), {'__slots__': (), **names})
        KIND_OF[cls.Constants] = KNOWN[cls.full_name()] = cls

    @classmethod
    def full_name(cls) -> str:
        """Return the name by which the command line and bags know it: module:Class."""
        return f'{cls.__module__}:{cls.__qualname__}'

    @classmethod
    def is_shipped(cls) -> bool:
        """Return whether it comes with the package."""
        return cls.__module__.startswith('satdyn_ros.')

    @classmethod
    def functions(cls) -> dict[str, Any]:
        """Return the functions that the equations may call, by their names."""
        found = {name: getattr(cls, name, None) for name in _PARAMETERS}
        return {name: function for name, function in found.items() if callable(function)}

    @classmethod
    def source(cls) -> str:
        """Return the texts of the modules that it and the functions it calls are in."""
        classes = [kind for kind in cls.__mro__ if kind is not object]
        return source_of([*classes, *cls.functions().values()])

    @classmethod
    def version(cls) -> str:
        """Return what a bag says of it: the version of its package, if it has one, and a hash."""
        package = sys.modules.get(cls.__module__.partition('.')[0])
        number = getattr(package, '__version__', '')
        return f'{number} {sha256(cls.source().encode()).hexdigest()[:16]}'.strip()

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> 'BodyTorque | None':
        """
        Return the torque of a scenario's values by their names; None: it does not act.

        By default each field of Constants is the key of its name, after the name of the torque.
        """
        names = [f'{cls.name}.{field}' for field in cls.Constants._fields]
        if missing := [name for name in names if name not in values]:
            raise ValueError(
                f'it has no key {missing[0]} for this field of its Constants, and no of(values) '
                'of its own'
            )
        return cls(cls.Constants(*(values[name] for name in names)))

    @classmethod
    def among(cls: type[_Same], torques: Iterable[Any]) -> _Same | None:
        """Return the torque of this kind among some, or None."""
        return next((torque for torque in torques if isinstance(torque, cls)), None)

    @classmethod
    def of_many(cls, torques: Sequence[Any]) -> Any:
        """Return what is commanded as M torques at once: one with constants of columns (M,)."""
        return torques[0]

    @property
    def inner_names(self) -> tuple[str, ...]:
        """Return the names of its variables among the inner coordinates."""
        return tuple(f'{self.name}.{state}' for state in self.states)

    def constants_with(self, table_of: Callable[[Pieces], Table]) -> Any:
        """Return the constants with the tables of some time, which table_of takes from pieces."""
        tables = {name: table_of(pieces) for name, pieces in self.pieces.items()}
        return self.constants._replace(**tables) if tables else self.constants

    def stops(self) -> np.ndarray:
        """
        Return the times [s] from tick 0 at which it is not smooth, where steps end, (K,).

        By default those where the pieces of its tables end.
        """
        tables = [part for part in self.constants if isinstance(part, Table)]
        return np.concatenate([np.zeros(0), *(table.ends_s for table in tables)])


def pieces_of(torques: Iterable[BodyTorque]) -> tuple[Pieces, ...]:
    """Return the tables that some torques have, each once."""
    return tuple(dict.fromkeys(each for torque in torques for each in torque.pieces.values()))


def scales_of(constants: Any) -> tuple[Any, ...]:
    """Return the scales of the variables of the torque that has these constants, one of each."""
    scales = KIND_OF[type(constants)].scales
    return tuple(scales(constants) if callable(scales) else scales)


def _as_floats(part, name):
    """Return numbers as floats, and arrays as contiguous ones of floats, in the same tuples."""
    if isinstance(part, tuple):
        names = getattr(part, '_fields', [name] * len(part))
        inner = map(_as_floats, part, names)
        return type(part)(*inner) if hasattr(part, '_fields') else tuple(inner)
    if isinstance(part, np.ndarray) and part.dtype.kind in 'biuf':
        return np.ascontiguousarray(part, float)
    if isinstance(part, Real | np.bool_):
        return float(part)
    raise TypeError(
        f'{name} of its Constants is {part!r}; it must be a float, an array of floats, or a tuple '
        'of these'
    )


# Every kind of torque that this process has met, by its full name.
KNOWN: dict[str, type[BodyTorque]] = {}
# The same by the class of their constants.
KIND_OF: dict[type, Any] = {}


# The parameters of the functions of a torque.
_SEEN = 't_s', 'r_i', 'v_i', 'q_ib', 'omega_bi_b', 'constants'
_POWER = 'c_b', 'along_b', 'gradient', 'turn_rate', 'growth_rate', 'constants'
_PARAMETERS = {
    'torque': _SEEN,
    'signs': _SEEN,
    'potential': _SEEN,
    'force': _SEEN,
    'field': ('c_b', 'gradient', 'constants'),
    'orbit_power': _POWER,
    'rates': _SEEN,
    'initial': _SEEN,
    'scales': ('constants',),
}
# Those that see the variables of the torque, if it has any.
_OF_STATES = 'torque', 'signs', 'potential', 'rates'


def checked_kind(kind: Any, name: str = '') -> type[BodyTorque]:
    """
    Return a class that is a whole torque; ValueError, in one sentence that names it: it is not.

    name: by which it was asked for, its own unless it is given.
    """
    if not (isinstance(kind, type) and issubclass(kind, BodyTorque)):
        raise ValueError(f'the torque {name or kind} is not a BodyTorque; give MODULE:CLASS')
    if why := _missing(kind):
        raise ValueError(f'the torque {name or kind.full_name()} {why}')
    return kind


def _missing(kind):
    """Return what a class lacks to be a torque, as the end of a sentence; '': nothing."""
    name, constants = getattr(kind, 'name', None), getattr(kind, 'Constants', None)
    if not (isinstance(name, str) and name):
        return 'has no name, a text with which its keys begin'
    if not (isinstance(constants, type) and issubclass(constants, tuple)):
        return 'has no Constants, a NamedTuple of floats, tuples of floats and arrays'
    if not hasattr(constants, '_fields'):
        return 'has Constants that are not a NamedTuple'
    if not (isinstance(kind.keys, tuple | list) and all(isinstance(k, Key) for k in kind.keys)):
        return f'has the keys {kind.keys!r}; they must be a tuple of Key'
    foreign = [key.name for key in kind.keys if not key.name.startswith(f'{name}.')]
    if foreign and not kind.is_shipped():
        return f'has the key {foreign[0]}; its keys must begin with {name}.'
    if not (str(kind.topic).isidentifier() and str(kind.topic).isascii()):
        return f'has the topic {kind.topic}; it must have only letters, digits and _'
    for name, function in kind.functions().items():
        has_states = kind.rates is not None and name in _OF_STATES
        parameters = (*_PARAMETERS[name], *(['states'] if has_states else []))
        if not _takes(function, len(parameters)):
            return f'has a {name} that is not a static method {name}({", ".join(parameters)})'
    if kind.states and kind.rates is None:
        return f'has the states {", ".join(kind.states)} and no rates'
    return ''


def _takes(function, count):
    """Return whether a function can be called with so many arguments."""
    try:
        inspect.signature(function).bind(*range(count))
    except (TypeError, ValueError):
        return False
    return True


def torque_of(kind: type[BodyTorque], values: Mapping[str, Any]) -> BodyTorque | None:
    """
    Return the torque of a kind for a scenario's values by their names; None: it does not act.

    ValueError, in one sentence that names the class: it cannot be made of them.
    """
    try:
        torque = kind.of(values)
        if torque is None:
            return None
        if type(torque) is not kind:
            raise TypeError(f'its of returns {torque!r}; it must return a {kind.__name__} or None')
        if kind.torque is BodyTorque.torque and not hasattr(kind, 'field'):
            raise TypeError(f'it has no function torque({", ".join(_SEEN)})')
        stop_times_s = np.asarray(torque.stops(), float)
        if stop_times_s.ndim != 1 or np.isnan(stop_times_s).any():
            raise TypeError('its stops must return times in an array of one dimension')
        _check_states(torque)
        if missing := torque.pieces.keys() - {*kind.Constants._fields}:
            raise TypeError(f'its pieces have {min(missing)}, which its Constants have not')
    except Exception as error:
        raise ValueError(f'the torque {kind.full_name()} cannot be made: {_why(error)}') from None
    return torque


def _check_states(torque: BodyTorque) -> None:
    """Raise TypeError where the variables of a torque are not as many as their scales."""
    names = torque.states
    if torque.rates is None:
        return
    if len({*names}) < len(names) or not all(str(name).isidentifier() for name in names):
        raise TypeError(f'its states are {names!r}; they must be different names')
    scales = scales_of(torque.constants)
    if len(scales) != len(names) or not all(scale > 0.0 for scale in scales):
        raise TypeError(f'its scales are {scales!r}; they must be {len(names)} above 0')
    if not callable(torque.initial) and len(torque.initial) != len(names):
        raise TypeError(f'its initial is {torque.initial!r}; it must have {len(names)} numbers')


def _why(error):
    """Return the text of an error, with its kind where that says more."""
    plain = isinstance(error, ValueError | TypeError | ImportError | SyntaxError)
    return str(error) if plain and str(error) else f'{type(error).__name__}: {error}'


def named(full_name: str) -> type[BodyTorque]:
    """
    Return the torque MODULE:CLASS, imported from the working directory too.

    ValueError, in one sentence: there is none.
    """
    found: Any = KNOWN.get(full_name)
    if found is None:
        module, _, name = full_name.partition(':')
        try:
            found = getattr(own_module(module), name) if module and name else None
        except (Exception, SystemExit) as error:
            raise ValueError(f'the torque {full_name} cannot be loaded: {_why(error)}') from None
    return checked_kind(found, full_name)
