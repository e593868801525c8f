"""What a torque on the body is: one class, from which all else follows."""

import inspect
import sys
from collections.abc import Callable, Iterable, Mapping
from hashlib import sha256
from typing import Any, ClassVar

import numpy as np

from ..base.key import Key
from ..base.lazy import own_module
from ..kernel.compile import add_source
from ..kernel.time_table import Table
from ..orbits.pieces import Pieces


class BodyTorque:
    """
    A torque on the body; each kind is a subclass.

    name: the beginning of its keys.  keys: what a scenario says of it.  topic: on which it is
    published where it acts and publish.topics says so, NAME_torque unless it is given.  title:
    that of its panel, the words of the topic unless it is given.  Constants: a NamedTuple of
    floats, tuples of floats and arrays, from which the torque is computed.  is_steady: whether it
    depends on attitude and rate alone, as seen from axes that turn with a circular orbit.

    torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants) -> (x, y, z) [N m], body axes, is compiled:
    t_s are seconds from tick 0, r_i [m] and v_i [m/s] the place on the orbit, zero without one.
    It is computed for many motions side by side as well, where its arguments are SIMD vectors: it
    may use arithmetic, comparisons, min, max and the functions of math, and chooses by
    kernel.simd.select where another function would by if.

    pieces: by the name of a field of Constants, a Table, what makes it for one piece of time after
    the other: what depends on time alone, such as the magnetic field along the orbit.

    Two more functions of the same arguments, where a torque has them.  signs(...) -> (x, ...): one
    of these numbers changes its sign where the torque has a corner, and steps end there.
    potential(...) -> V [J]: the torque is that of V.  Where the torque is steady and so are its
    axes, V is part of the energy that is conserved; elsewhere the torque does work.

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
    Constants: ClassVar[Any]
    signs: ClassVar[Callable[..., tuple[float, ...]] | None] = None
    potential: ClassVar[Callable[..., float] | None] = None

    def __init__(self, constants: Any, pieces: Mapping[str, Pieces] | None = None):
        self.constants, self.pieces = _as_floats(constants), dict(pieces or {})

    def __init_subclass__(cls) -> None:
        """
        Let the equations call the function of a new torque.

        TypeError: a key is not its own, or its topic has no name that ROS takes.
        """
        if not hasattr(cls, 'Constants'):
            return
        is_ours = cls.__module__.startswith('satdyn_ros.')
        foreign = [key.name for key in cls.keys if not key.name.startswith(f'{cls.name}.')]
        if foreign and not is_ours:
            raise TypeError(f'{foreign[0]} is a key of {cls.name}; it must begin with {cls.name}.')
        cls.topic = vars(cls).get('topic', f'{cls.name}_torque')
        cls.title = vars(cls).get('title', cls.topic.replace('_', ' '))
        if not (cls.topic.isidentifier() and cls.topic.isascii()):
            raise TypeError(f'the topic {cls.topic} must have letters, digits and _ alone')
        # numba tells compiled code that is kept apart by the names of types.
        source = '' if is_ours else cls.source()
        told = sha256(f'{cls.full_name()} {source}'.encode()).hexdigest()[:16]
        cls.Constants.__name__ = f'{cls.__name__}Constants{told}'
        KIND_OF[cls.Constants] = KNOWN[cls.full_name()] = cls
        if not is_ours:
            add_source(cls.source())

    @classmethod
    def full_name(cls) -> str:
        """Return the name by which the command line and bags know it: module:Class."""
        return f'{cls.__module__}:{cls.__qualname__}'

    @classmethod
    def source(cls) -> str:
        """Return the text of the module that it is in, or of itself where there is no module."""
        try:
            module = inspect.getmodule(cls)
            return inspect.getsource(cls if module is None else module)
        except (OSError, TypeError):
            # Typed into an interpreter.
            return cls.torque.__code__.co_code.hex()

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
        given = (values[f'{cls.name}.{field}'] for field in cls.Constants._fields)
        return cls(cls.Constants(*given))

    @staticmethod
    def torque(
        t_s: float,
        r_i: tuple[float, ...],
        v_i: tuple[float, ...],
        q_ib: tuple[float, ...],
        omega_bi_b: tuple[float, ...],
        constants: Any,
    ) -> tuple[float, ...]:
        """Return the torque [N m] in body axes."""
        raise NotImplementedError

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


def _as_floats(part):
    """Return numbers as floats, and arrays as contiguous ones of floats, in the same tuples."""
    if isinstance(part, tuple):
        inner = map(_as_floats, part)
        return type(part)(*inner) if hasattr(part, '_fields') else tuple(inner)
    return np.ascontiguousarray(part, float) if isinstance(part, np.ndarray) else float(part)


# Every kind of torque that this process has met, by its full name.
KNOWN: dict[str, type[BodyTorque]] = {}
# The same by the class of their constants, which compiled code knows.
KIND_OF: dict[type, Any] = {}


def named(full_name: str) -> type[BodyTorque]:
    """
    Return the torque MODULE:CLASS, imported from the working directory too.

    ValueError, in one sentence: there is none.
    """
    if full_name not in KNOWN:
        module, _, name = full_name.partition(':')
        try:
            found = getattr(own_module(module), name) if module and name else None
        except Exception as error:
            raise ValueError(f'the torque {full_name} cannot be loaded: {error}') from None
        if not (isinstance(found, type) and issubclass(found, BodyTorque)):
            raise ValueError(f'the torque {full_name} is not a BodyTorque; give MODULE:CLASS')
        return found
    return KNOWN[full_name]
