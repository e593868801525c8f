"""The constants of the equations of motion of equations.py, made from one system or from many."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from ..kernel.rows import components, from_components
from ..kernel.time_table import Table
from ..orbits.pieces import Pieces
from ..torques.applied import Applied
from ..torques.corner_search import CornerSearch
from ..torques.gravity_gradient import GravityGradient
from ..torques.weight import Weight
from .rotor import Rotor
from .system import System

# The most by which the axes turn in a step [rad].
STEP_TURN = 0.5

# A viscous friction [N m s] that is none.
_TINY = 1e-300

# The torques that every system has.
_SHIPPED = 3

# Where among the numbers of Constants those are that the walk reads, and how many there are of a
# rotor, with 1 / J among them, and of an event function.
START_S, LONGEST_STEP, ANOMALY_RATE, AXES_RATE, NORMAL_AT = range(5)
ROTOR_SIZE, INVERSE_AT, EVENT_SIZE = 6, 5, 5

# Tuples, matrices by rows; arrays while they are made from one system or many.
Triple = Any
Matrix = Any


class RotorConstants(NamedTuple):
    """The constants of one turning rotor; inertia_inverse: 1 / J."""

    axis: Triple
    torque: float
    friction: float
    inertia_inverse: float


class CoulombFriction(NamedTuple):
    """The dry friction of a rotor; torque: C, per_speed [s/rad]: 1 / s_c."""

    torque: float
    per_speed: float


class Imbalance(NamedTuple):
    """The torque [N m] of an imbalance on the body is s^2 (cos theta along + sin theta across)."""

    along: Triple
    across: Triple


class EventFunction(NamedTuple):
    """
    What of a rotor ends a step, see drives.py: its speed [rad/s] or, where held, p' [N m].

    held_inertia: J of a rotor that is held at its speed, else zero.  low, high: between which what
    is watched stays.  effort: the motor's torque [N m], less gain times the speed; of one that is
    held, less p'.
    """

    held_inertia: float
    low: float
    high: float
    effort: float
    gain: float


class OrbitTable(NamedTuple):
    """A piece of an orbit that is known as a table; pull [m^3/s^2]: 3 mu."""

    pull: float
    table: Table


class Constants(NamedTuple):
    """
    The constants of one motion as plain numbers.

    Matrices are tuples of rows or, where all three are diagonal, as of most bodies, of the numbers
    of the diagonal: the equations have no terms for the zeros beside it.

    start_s: of the motion, from tick 0; longest_step [s]: in which the axes turn by STEP_TURN;
    anomaly_rate [rad/s]: the root of mu / l^3; axes_rate [rad/s] and normal: the size and the
    direction of Omega.  momentum [N m s]: h.  gradient [1/s^2]: 3 mu / l^3; outward and ahead: P
    and Q; semi_latus_rectum [m] and speed [m/s], the root of mu / l: of the orbit, zero without
    one.  slow_rate [rad/s]: far below the rates at which the field swings the body, or torques
    that begin at nothing turn it, for a body at rest.  does_work: whether anything does work that
    no potential has.  integrates_anomaly: whether the true anomaly is integrated.  corner_search:
    as of the system.

    rotors: those that turn.  events: the event functions of their drives, where one has a torque
    that depends on its speed, coulomb: their dry friction, imbalances: theirs, where one has any;
    else none.  modes: the constants of each, as its kind has them.  table: of the orbit, where it
    is known as one, in place of all that says where it is; else none.  torques: the constants of
    each, whose type says which torque it is: of the weight, the gravity gradient and the applied
    torque, then those of the system.
    """

    start_s: float
    longest_step: float
    anomaly_rate: float
    axes_rate: float
    normal: Triple
    carrier_inertia: Matrix
    carrier_inverse: Matrix
    momentum: Triple
    eccentricity: float
    gradient: float
    outward: Triple
    ahead: Triple
    semi_latus_rectum: float
    speed: float
    slow_rate: float
    does_work: bool
    integrates_anomaly: bool
    corner_search: CornerSearch
    rotors: tuple[RotorConstants, ...]
    events: tuple[EventFunction, ...]
    coulomb: tuple[CoulombFriction, ...]
    imbalances: tuple[Imbalance, ...]
    modes: tuple[Any, ...]
    table: tuple[OrbitTable, ...]
    torques: tuple[Any, ...]


def constants_of(system: System, start_s: float = 0.0) -> Constants:
    """Return the constants of the equations for a system that starts at start_s."""
    undriven = _undriven_constants(system.undriven)
    outward, ahead = _line(system, start_s, undriven.outward, undriven.ahead)
    rotors = zip(undriven.rotors, system.turning_rotors, strict=True)
    *field, _ = undriven.torques[:_SHIPPED]
    own = (torque.constants for torque in system.torques)
    return undriven._replace(
        outward=tuple(map(float, outward)),
        ahead=tuple(map(float, ahead)),
        start_s=float(start_s),
        does_work=undriven.does_work or bool(system.is_driven),
        rotors=tuple(
            rotor._replace(torque=float(system.rotor_torque[i])) for rotor, (i, _) in rotors
        ),
        torques=(*field, Applied.Constants(tuple(_applied(system).tolist())), *own),
    )


def write_driven(
    numbers: np.ndarray,
    indices: Any,
    start_s: Any,
    line: Sequence[Triple],
    applied_b: Iterable[Any],
    rotor_torque: Iterable[Any],
    own: Mapping[int, Any],
) -> None:
    """
    Write what commands set, and what depends on the start, into the numbers of Constants.

    numbers (P,), or (P, K) of K motions, each of the rest then a column (K,): those of another
    start and of other commands of the same kind.  indices: of each among them, as numbered()
    gives.  line: as of line_at.  applied_b: as of applied_by.  rotor_torque: of the turning
    rotors.  own: by their indices among system.torques, the constants of those that are commanded.
    """
    numbers[indices.start_s] = start_s
    for at, values in zip((indices.outward, indices.ahead), line, strict=False):
        numbers[at[0] : at[0] + 3] = values
    for at, torque in zip(indices.rotors, rotor_torque, strict=True):
        numbers[at.torque] = torque
    applied = indices.torques[_SHIPPED - 1].torque_b
    numbers[applied[0] : applied[0] + 3] = applied_b
    for i, constants in own.items():
        _write(numbers, indices.torques[_SHIPPED + i], constants)


def write_events(
    numbers: np.ndarray, indices: Any, friction: Iterable[float], events: Iterable[EventFunction]
) -> None:
    """
    Write the event functions of turning rotors, none of which is held, as write_driven does.

    friction: of each rotor without its drive [N m s].
    """
    every = zip(indices.rotors, indices.events, friction, events, strict=False)
    for rotor, of_event, own, event in every:
        numbers[rotor.friction] = own + event.gain
        _write(numbers, of_event, event)


def _write(numbers, indices, values):
    for at, x in zip(indices, values, strict=True):
        if isinstance(at, tuple):
            _write(numbers, at, x)
        elif isinstance(at, int):
            numbers[at] = x


def line_at(system: System, start_s: float) -> list[Triple]:
    """Return P and Q in turning axes of c and ahead of it at the start; none: no axes turn."""
    if not system.has_turning_axes:
        return []
    return list(_line(system, start_s, *perifocal_line(system)))


def perifocal_line(system: System) -> tuple[Triple, Triple]:
    """Return P and Q of a system, outward and ahead at the pericentre."""
    undriven = _undriven_constants(system.undriven)
    return undriven.outward, undriven.ahead


def turned_line(P: Triple, Q: Triple, f: Any) -> list[Triple]:
    """Return the components of P and Q turned in their plane by an angle f [rad]."""
    cosine, sine = np.cos(f), np.sin(f)
    both = list(zip(P, Q, strict=True))
    return [[cosine * p + sine * q for p, q in both], [cosine * q - sine * p for p, q in both]]


def applied_by(
    torque_b: Iterable[Any], axes: Iterable[Iterable[Any]], rotor_torque: Iterable[Any]
) -> tuple[Any, Any, Any]:
    """
    Return the torque on the body [N m], from outside and from the motors of all rotors.

    Vectors are three components each.  All are numbers, or of K systems columns (K,).
    """
    x, y, z = torque_b
    for (a, b, c), torque in zip(axes, rotor_torque, strict=True):
        with_motor = x - torque * a, y - torque * b, z - torque * c
        if np.ndim(torque):
            both = zip((x, y, z), with_motor, strict=True)
            x, y, z = (np.where(torque == 0.0, before, after) for before, after in both)
        elif torque:
            x, y, z = with_motor
    return x, y, z


def with_tables(
    constants: Constants, system: System, table_of: Callable[[Pieces], Table]
) -> Constants:
    """Return constants with the tables of some time, which table_of takes from pieces."""
    orbit, table = system.orbit, constants.table
    if orbit.pieces is not None:
        table = (OrbitTable(3.0 * float(orbit.mu), table_of(orbit.pieces)),)
    own = (torque.constants_with(table_of) for torque in system.torques)
    return constants._replace(table=table, torques=(*constants.torques[:_SHIPPED], *own))


# A controller drives the same system anew at every tick.
_known: WeakKeyDictionary[System, Constants] = WeakKeyDictionary()


def _undriven_constants(system):
    if system not in _known:
        constants = _constants(system)
        torques = constants.torques
        plain = constants._replace(torques=torques[:_SHIPPED])
        # One that is held turns with the body.
        if _are_diagonal(plain, [np.outer(r.axis, r.axis) for r in system.switching_rotors]):
            plain = _without_zeros(plain)
        plain = _as_tuples(plain)
        _known[system] = plain._replace(torques=plain.torques + torques[_SHIPPED:])
    return _known[system]


def flat_constants_of_many(system: System, count: int) -> tuple[Constants, np.ndarray]:
    """
    Return the floats of the Constants of count systems, one after the other, (count, P).

    The Constants returned before them give the number of rotors and whether work is done, the
    same for all.
    """
    constants = _constants(system)
    line = _line(system, 0.0, components(constants.outward), components(constants.ahead))
    outward, ahead = map(from_components, line)
    constants = constants._replace(outward=outward, ahead=ahead)
    inertia = np.eye(3) if _are_diagonal(constants) else np.eye(3) + 0.1
    rotors = (Rotor('free', inertia=0.1),) * len(constants.rotors)
    kinds: list[Any] = [type(mode) for mode in system.modes]
    modes = tuple(kind(name='one') for kind in kinds)
    one = constants_of(System(inertia, rotors, modes=modes))._replace(
        does_work=bool(constants.does_work), integrates_anomaly=constants.integrates_anomaly
    )
    rows = [
        np.broadcast_to(np.reshape(part, (-1, size)), (count, size))
        for part, size in _parts(_without_zeros(constants), one)
    ]
    return one, np.concatenate(rows, axis=1)


# What overflows in these two halts the propagation; a warning would come before its sentence.
@np.errstate(over='ignore', invalid='ignore')
def _applied(system):
    axes = (components(rotor.axis) for rotor in system.rotors)
    return from_components(applied_by(components(system.torque_b), axes, system.rotor_torque))


@np.errstate(over='ignore', invalid='ignore')
def _constants(system):
    """Return the Constants as arrays, of a system whose own constants may be arrays."""
    orbit = system.orbit.constants
    axes_rate, longest_step = 0.0, np.inf
    if system.has_turning_axes:
        axes_rate, longest_step = orbit.anomaly_rate, STEP_TURN / orbit.anomaly_rate
    momentum = np.zeros(3)
    for rotor in system.rotors:
        if rotor.mode == 'constant_momentum':
            momentum = momentum + np.asarray(rotor.momentum)[..., None] * rotor.axis
    weight = np.linalg.norm(system.weight_moment, axis=-1)
    size = np.trace(system.inertia, axis1=-2, axis2=-1)
    at_rest = sum(torque.largest for torque in system.torques)
    return Constants(
        start_s=0.0,
        longest_step=longest_step,
        anomaly_rate=orbit.anomaly_rate,
        axes_rate=axes_rate,
        normal=orbit.normal,
        carrier_inertia=system.carrier_inertia,
        carrier_inverse=system.carrier_inverse,
        momentum=momentum,
        eccentricity=orbit.eccentricity,
        gradient=orbit.gradient,
        outward=orbit.outward,
        ahead=orbit.ahead,
        semi_latus_rectum=orbit.semi_latus_rectum,
        speed=orbit.speed,
        slow_rate=1e-3 * np.sqrt(np.abs(orbit.gradient) + (weight + at_rest) / size),
        does_work=bool(system.is_driven or system.orbit.is_eccentric),
        integrates_anomaly=system.integrates_anomaly,
        corner_search=system.corner_search,
        rotors=_rotors_of(system),
        events=(),
        coulomb=_coulomb_of(system),
        imbalances=_imbalances_of(system),
        modes=tuple(mode.constants for mode in system.modes),
        table=(),
        torques=(
            Weight.Constants(system.weight_moment),
            GravityGradient.Constants(system.inertia),
            Applied.Constants(_applied(system)),
            *(torque.constants for torque in system.torques),
        ),
    )


def _rotors_of(system):
    return tuple(
        RotorConstants(
            axis=rotor.axis,
            torque=system.rotor_torque[i],
            # Where there is any, the error of a step looks at the momentum.
            friction=rotor.friction + (_TINY if np.any(rotor.coulomb_friction) else 0.0),
            inertia_inverse=1.0 / rotor.inertia,
        )
        for i, rotor in system.turning_rotors
    )


def _coulomb_of(system):
    rotors = [rotor for _, rotor in system.turning_rotors]
    if not any(np.any(rotor.coulomb_friction) for rotor in rotors):
        return ()
    return tuple(
        CoulombFriction(rotor.coulomb_friction, 1.0 / rotor.friction_speed) for rotor in rotors
    )


def _imbalances_of(system):
    rotors = [rotor for _, rotor in system.turning_rotors]
    if not any(rotor.is_unbalanced for rotor in rotors):
        return ()
    imbalances = []
    for rotor in rotors:
        U_s, U_d, e_1 = rotor.static_imbalance, rotor.dynamic_imbalance, rotor.zero_direction
        sides = e_1, np.cross(rotor.axis, e_1)
        imbalances.append(Imbalance(*(U_d * e + U_s * np.cross(rotor.position, e) for e in sides)))
    return tuple(imbalances)


def _line(system, start_s, P, Q):
    """Return the components of P and Q, in turning axes of c and ahead of it at the start."""
    return turned_line(P, Q, system.orbit.anomaly(start_s)) if system.has_turning_axes else (P, Q)


def _matrices(constants):
    return constants.carrier_inertia, constants.carrier_inverse, constants.torques[1].inertia


def _are_diagonal(constants, others=()):
    """Return whether the matrices of constants that are arrays have zeros beside the diagonal."""
    beside = ~np.eye(3, dtype=bool)
    return not any(matrix[..., beside].any() for matrix in (*_matrices(constants), *others))


def _without_zeros(constants):
    """Return constants that are arrays with diagonals in place of diagonal matrices."""
    if not _are_diagonal(constants):
        return constants
    K, K_inverse, I = (M.diagonal(axis1=-2, axis2=-1) for M in _matrices(constants))
    weight, _, *others = constants.torques
    return constants._replace(
        carrier_inertia=K,
        carrier_inverse=K_inverse,
        torques=(weight, GravityGradient.Constants(I), *others),
    )


def _as_tuples(part):
    """Return arrays as numbers or as tuples of numbers; tuples with names keep them."""
    if isinstance(part, bool | CornerSearch):
        return part
    if isinstance(part, tuple):
        inner = map(_as_tuples, part)
        return type(part)(*inner) if hasattr(part, '_fields') else tuple(inner)
    if isinstance(part, np.ndarray) and part.ndim:
        rows = part.tolist()
        return tuple(map(tuple, rows)) if part.ndim > 1 else tuple(rows)
    return float(part)


def _parts(constants, one):
    """Yield the arrays of Constants, and how many numbers each is in those of one motion."""
    for part, like in zip(constants, one, strict=True):
        if isinstance(part, tuple):
            yield from _parts(part, like)
        elif not isinstance(part, bool | CornerSearch):
            yield part, np.size(like)
