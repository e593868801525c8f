"""What moves and from where: a body with its rotors in an attracting field, and its state."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import isnan
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..orbits import FixedDirection, Orbit
from ..orbits.along_orbit import AlongOrbit
from ..orbits.pieces import Pieces
from ..torques.body_torque import BodyTorque, pieces_of
from ..torques.corner_search import CornerSearch
from .inner_mode import InnerMode
from .rotor import Rotor

_ZERO, _NAN = np.zeros(3), np.full((), np.nan)
# What another torque on the same body does not change.
_KEPT = (
    'turning_rotors',
    'switching_rotors',
    'carrier_inertia',
    'carrier_inverse',
    'undriven',
    'has_turning_axes',
)


@dataclass(frozen=True, eq=False)
class System:
    """
    A gyrostat with R rotors in a Newtonian field, with the torques that are applied to it.

    Attributes
    ----------
    inertia : (3, 3), kg m^2, body axes
        locked rotors and flexible parts included, about the mass centre, or about the fixed point
        where weight_moment is not zero
    rotors : R rotors
        the rotors
    orbit : FixedDirection, KeplerOrbit or TabledOrbit
        where the attracting centre is
    weight_moment : (3,), N m, body axes
        weight times the position of the mass centre from the fixed point
    torque_b : (3,), N m, body axes
        torque on the body
    rotor_torque : (R,), N m
        from the body on the rotors, or one for all
    torques : torques
        other torques on the body
    environment : AlongOrbit or None
        what there is along the orbit beside the attracting field
    rotor_target : (R,), rad/s
        speeds that the drives are commanded instead of a torque, nan: none
    corner_search : CornerSearch
        how steps find the corners at which they end
    modes : modes
        of flexible and other parts inside
    """

    inertia: np.ndarray
    rotors: tuple[Rotor, ...] = (Rotor(),)
    orbit: Orbit = FixedDirection()
    weight_moment: np.ndarray = field(default_factory=lambda: _ZERO)
    torque_b: np.ndarray = field(default_factory=lambda: _ZERO)
    rotor_torque: np.ndarray = field(default_factory=lambda: np.zeros(()))
    torques: tuple[BodyTorque, ...] = ()
    environment: AlongOrbit | None = None
    rotor_target: np.ndarray = field(default_factory=lambda: _NAN)
    corner_search: CornerSearch = CornerSearch()
    modes: tuple[InnerMode, ...] = ()

    def __post_init__(self) -> None:
        for name in ('rotor_torque', 'rotor_target'):
            commands = np.asarray(getattr(self, name), float)
            if commands.shape != (len(self.rotors),):
                commands = np.broadcast_to(commands, len(self.rotors))
            object.__setattr__(self, name, commands)

    def __deepcopy__(self, memo: object) -> 'System':
        """Return itself: it never changes."""
        return self

    def __repr__(self) -> str:
        if self.inertia.ndim > 2:
            body = f'{len(self.inertia)} bodies'
        else:
            moments = ', '.join(f'{x:g}' for x in np.linalg.eigvalsh(self.inertia))
            body = f'moments [{moments}] kg m^2'
        rotors = [f'{rotor.label} {rotor.mode}' for rotor in self.rotors if rotor.mode != 'none']
        modes = [f'{mode.name} {mode.group()}' for mode in self.modes]
        driven = ', driven' if self.is_driven else ''
        return f'<System: {", ".join([body, *rotors, *modes])}{driven}, {self.orbit}>'

    @cached_property
    def is_driven(self) -> bool:
        """Whether anything does work that no potential has: a torque, a motor, friction."""
        return self.takes_work or not all(map(self._has_potential, self.torques))

    @cached_property
    def is_newtonian(self) -> bool:
        """Whether nothing acts but the Newtonian field and the weight, as in the papers."""
        return not (self.takes_work or self.torques or self.modes)

    @property
    def takes_work(self) -> bool:
        """Whether a torque, motor, friction, damping or imbalance does work of no potential."""
        return bool(
            self.torque_b.any()
            or self.rotor_torque.any()
            or np.isfinite(self.rotor_target).any()
            or any(rotor.is_damped or rotor.is_unbalanced for rotor in self.rotors)
            or any(mode.is_damped for mode in self.modes)
        )

    def _has_potential(self, torque):
        """Return whether a torque derives from a potential that is fixed in the axes."""
        is_fixed = self.has_turning_axes or not self.orbit.has_lvlh
        return torque.potential is not None and torque.is_steady and is_fixed

    @cached_property
    def has_turning_axes(self) -> bool:
        """Whether the equations are stated in axes that turn with a circular orbit."""
        orbit = self.orbit
        return (
            orbit.has_lvlh
            and not orbit.is_eccentric
            and all(torque.is_steady for torque in self.torques)
        )

    @property
    def integrates_anomaly(self) -> bool:
        """Whether the true anomaly is integrated with the attitude."""
        is_of_constants = self.orbit.has_lvlh and self.orbit.pieces is None
        return is_of_constants and not self.has_turning_axes

    @cached_property
    def pieces(self) -> tuple[Pieces, ...]:
        """Return the tables of what depends on time alone: of the orbit and of the torques."""
        of_orbit = self.orbit.pieces
        return (() if of_orbit is None else (of_orbit,)) + pieces_of(self.torques)

    @cached_property
    def turning_rotors(self) -> tuple[tuple[int, Rotor], ...]:
        """Return the rotors that have a speed of their own, with their indices among all."""
        return tuple((i, rotor) for i, rotor in enumerate(self.rotors) if rotor.turns_freely)

    @cached_property
    def switching_rotors(self) -> tuple[Rotor, ...]:
        """Return the motors whose torque may depend on their speed."""
        return tuple(rotor for rotor in self.rotors if rotor.switches)

    @cached_property
    def inner_names(self) -> tuple[str, ...]:
        """Return the names of its inner coordinates, such as flexible.panel.displacement."""
        of_modes = [(mode.displacement_name, mode.rate_name) for mode in self.modes]
        of_torques = [torque.inner_names for torque in self.torques]
        return tuple(name for names in (*of_modes, *of_torques) for name in names)

    @property
    def has_turning_rotor(self) -> bool:
        """Whether a rotor has a speed of its own."""
        return bool(self.turning_rotors)

    @cached_property
    def carrier_inertia(self) -> np.ndarray:
        """
        Return the inertia K (3, 3) that turns with the rate omega [kg m^2].

        That of the whole body less J a a^T for each rotor with a speed of its own (see rotor.py)
        and d d^T for each mode of a part inside (see inner_mode.py).
        """
        K = self.inertia
        for _, rotor in self.turning_rotors:
            outer = rotor.axis[..., :, None] * rotor.axis[..., None, :]
            K = K - np.asarray(rotor.inertia)[..., None, None] * outer
        for mode in self.modes:
            K = K - mode.coupling[..., :, None] * mode.coupling[..., None, :]
        return K

    @cached_property
    def carrier_inverse(self) -> np.ndarray:
        """Return the inverse (3, 3) of the carrier's inertia [1/(kg m^2)]."""
        return np.linalg.inv(self.carrier_inertia)

    @cached_property
    def undriven(self) -> 'System':
        """Return the system without torques, the same one for all that driven() gives."""
        return replace(self, torque_b=_ZERO, rotor_torque=np.zeros(()), rotor_target=_NAN)

    def driven(self, **torques: Any) -> 'System':
        """Return the system under other torques, by its fields, with the same inertias."""
        driven = replace(self, **torques)
        # A controller drives the body anew at every tick.
        for name in _KEPT:
            vars(driven)[name] = getattr(self, name)
        return driven

    def rotor_momentum(self, state: 'State') -> np.ndarray:
        """
        Return sum p a (3,) of state in body axes [N m s], the part of H beside K omega.

        It is constant unless a motor torque or friction acts.
        """
        h = np.zeros(3)
        for rotor, speed in zip(self.rotors, self.rotor_speeds(state), strict=True):
            h = h + rotor.axial_momentum(speed, state.omega_bi_b) * rotor.axis
        return h

    def check(self, state: 'State') -> None:
        """Raise ValueError where state lacks the speed or the angle of a free rotor."""
        if not self.has_turning_rotor:
            return
        for name in ('rotor_speed', 'rotor_angle'):
            values, count = getattr(state, name).tolist(), len(self.rotors)
            if len(values) != count:
                raise ValueError(
                    f'{name} has the length {len(values)}; it must be {count}, one per rotor'
                )
            for rotor, value in zip(self.rotors, values, strict=True):
                if rotor.turns_freely and isnan(value):
                    raise ValueError(
                        f'{name} of {rotor.label} is missing; '
                        f'a rotor of mode {rotor.mode} needs it'
                    )

    def rotor_speeds(self, state: 'State') -> np.ndarray:
        """Return the rotors' speeds (R,) of state [rad/s]; ValueError: their number is wrong."""
        speeds = state.rotor_speed
        return (
            speeds
            if len(speeds) == len(self.rotors)
            else np.broadcast_to(speeds, len(self.rotors))
        )


@dataclass(frozen=True, eq=False)
class State:
    """
    Attitude and rates at one instant.

    Parameters
    ----------
    q_ib : (4,), x, y, z, w
        attitude, body to inertial
    omega_bi_b : (3,), rad/s, body axes
        rate of the body relative to inertial axes
    rotor_speed : (R,), rad/s
        relative to the body, nan for a rotor without a speed of its own; with one rotor a plain
        number will do
    rotor_angle : (R,), rad
        relative to the body, likewise; a number for every free rotor
    inner : dict
        inner coordinates by name, such as flexible.panel.displacement; those of modes that are
        left out begin at zero, those of torques as these say
    """

    q_ib: np.ndarray
    omega_bi_b: np.ndarray
    rotor_speed: np.ndarray
    rotor_angle: np.ndarray
    inner: Mapping[str, float]

    def __init__(
        self,
        q_ib: np.ndarray,
        omega_bi_b: np.ndarray,
        rotor_speed: ArrayLike = np.nan,
        rotor_angle: ArrayLike = np.nan,
        inner: Mapping[str, Any] | None = None,
    ) -> None:
        object.__setattr__(self, 'q_ib', q_ib)
        object.__setattr__(self, 'omega_bi_b', omega_bi_b)
        object.__setattr__(self, 'rotor_speed', np.atleast_1d(rotor_speed))
        object.__setattr__(self, 'rotor_angle', np.atleast_1d(rotor_angle))
        object.__setattr__(self, 'inner', dict(inner or {}))
