"""A motion: whatever answers at(t_s) with states, by propagation or in closed form."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ..environment import lit_fraction, sun_direction
from ..environment.sun import AU_M, ILLUMINANCE_LX
from ..kernel import rotation
from ..orbits import Orbit
from ..orbits.along_orbit import AlongOrbit
from ..torques.magnetic import torquer_dipole
from .inner_mode import column_of
from .system import State, System

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True, eq=False)
class States:
    """
    A table of N states of one motion.

    For many motions at the same times, the tables have one more axis in front.

    Attributes
    ----------
    t_s : (N,), s
        since the motion began
    q_ib : (N, 4), x, y, z, w
        attitude, body to inertial
    omega_bi_b : (N, 3), rad/s, body axes
        rate of the body relative to inertial axes
    rotor_speed, rotor_angle : (N, R), rad/s, rad
        of each rotor relative to the body, nan where it has none
    work : (N,), J
        what the applied torques and the orbit's ellipticity have added to the energy
    orbit : FixedDirection, KeplerOrbit or TabledOrbit
        the orbit
    orbit_s : (N,), s
        the same instants from tick 0
    turn_b : (N, 3), rad, or None
        integral of omega_bi_b since the row before
    rotor_torque : (N, R), N m, or None
        torques of the motors
    met_limit : (N, R), bool, or None
        whether a rotor came to its limit of speed since the row before
    environment : AlongOrbit or None
        the environment along the orbit
    inner : dict of (N,)
        inner coordinates by name, as in State
    torquer_dipole_b : (N, 3), A m^2, body axes, or None
        dipole of the magnetorquers
    """

    t_s: np.ndarray
    q_ib: np.ndarray
    omega_bi_b: np.ndarray
    rotor_speed: np.ndarray
    rotor_angle: np.ndarray
    work: np.ndarray
    orbit: Orbit
    orbit_s: np.ndarray
    turn_b: np.ndarray | None = None
    rotor_torque: np.ndarray | None = None
    met_limit: np.ndarray | None = None
    environment: AlongOrbit | None = None
    inner: Mapping[str, np.ndarray] = field(default_factory=dict)
    torquer_dipole_b: np.ndarray | None = None

    def __repr__(self) -> str:
        many = f'{len(self.q_ib)} motions, ' if self.q_ib.ndim > 2 else ''
        span = f', t_s {self.t_s.min():g} to {self.t_s.max():g}' if len(self) else ''
        return f'<States: {many}{len(self)} rows{span}, {self.orbit}>'

    def __len__(self) -> int:
        return len(self.t_s)

    def __getitem__(self, i: int) -> State:
        """Return the state in row i."""
        return State(
            self.q_ib[i],
            self.omega_bi_b[i],
            self.rotor_speed[i],
            self.rotor_angle[i],
            {name: float(values[i]) for name, values in self.inner.items()},
        )

    def rows(self, chosen: slice | np.ndarray) -> 'States':
        """Return the table of some rows."""

        def some(table):
            return None if table is None else table[chosen]

        return States(
            self.t_s[chosen],
            self.q_ib[..., chosen, :],
            self.omega_bi_b[..., chosen, :],
            self.rotor_speed[..., chosen, :],
            self.rotor_angle[..., chosen, :],
            self.work[..., chosen],
            self.orbit,
            self.orbit_s[chosen],
            turn_b=some(self.turn_b),
            rotor_torque=some(self.rotor_torque),
            met_limit=some(self.met_limit),
            torquer_dipole_b=some(self.torquer_dipole_b),
            environment=self.environment,
            inner={name: values[..., chosen] for name, values in self.inner.items()},
        )

    @cached_property
    def _position_velocity(self):
        return self.orbit.position_velocity(self.orbit_s)

    @property
    def r_i(self) -> np.ndarray:
        """Return the position [m], inertial, shape (N, 3); zero for a fixed direction."""
        return self._position_velocity[0]

    @property
    def v_i(self) -> np.ndarray:
        """Return the velocity [m/s], inertial, shape (N, 3); zero for a fixed direction."""
        return self._position_velocity[1]

    @cached_property
    def _q_bi(self):
        return rotation.conjugate(self.q_ib)

    @cached_property
    def c_b(self) -> np.ndarray:
        """Return the unit vector from the attracting centre to the body, body axes, (N, 3)."""
        return rotation.rotate(self._q_bi, self.orbit.direction(self.orbit_s))

    @cached_property
    def sun_i(self) -> np.ndarray:
        """The position of the Sun from the Earth's centre [m], inertial axes, (N, 3)."""
        assert self.environment is not None
        return self.environment.sun.values(self.orbit_s, np.arange(3))

    @cached_property
    def sun_direction_b(self) -> np.ndarray:
        """The unit vector to the Sun, body axes, (N, 3)."""
        return rotation.rotate(self._q_bi, sun_direction(self.r_i, self.sun_i)[0])

    @cached_property
    def lit_fraction(self) -> np.ndarray:
        """The part of the Sun's disc that the Earth leaves free, (N,)."""
        return lit_fraction(self.r_i, self.sun_i)

    @cached_property
    def illuminance_lx(self) -> np.ndarray:
        """The illuminance of a plate that faces the Sun [lx], (N,)."""
        _, distance_m = sun_direction(self.r_i, self.sun_i)
        return self.lit_fraction * ILLUMINANCE_LX * (AU_M / distance_m) ** 2

    @cached_property
    def magnetic_field_b(self) -> np.ndarray:
        """The Earth's magnetic field [T], body axes, (N, 3)."""
        assert self.environment is not None
        field_i = self.environment.magnetic_field.values(self.orbit_s, np.arange(3))
        return rotation.rotate(self._q_bi, field_i)

    @cached_property
    def lvlh_rate_b(self) -> np.ndarray:
        """Return the angular velocity of LVLH in body axes [rad/s], shape (N, 3)."""
        return rotation.rotate(self._q_bi, self.orbit.lvlh_rate(self.orbit_s))

    @cached_property
    def q_lb(self) -> np.ndarray:
        """Return the attitude body to LVLH, shape (N, 4); a fixed direction has none."""
        return rotation.multiply(rotation.conjugate(self.orbit.lvlh(self.orbit_s)), self.q_ib)

    @property
    def roll_pitch_yaw(self) -> np.ndarray:
        """
        Return the 3-2-1 angles of the body relative to LVLH [rad], shape (N, 3).

        Of a fixed direction, which has no LVLH, they are those relative to inertial axes.
        """
        return rotation.roll_pitch_yaw(self.q_lb if self.orbit.has_lvlh else self.q_ib)

    def to_pandas(self) -> 'pandas.DataFrame':
        """
        Return the table as a DataFrame, a column for each number, named as `satdyn export` does.

        Of several rotors the columns are rotor_0_speed_rad_s and so on, in their order; what no
        rotor has is left out.  ImportError: pandas is not installed.  ValueError: the states are
        of many motions.
        """
        try:
            import pandas
        except ImportError:
            raise ImportError(
                'to_pandas needs pandas: pip install pandas', name='pandas'
            ) from None
        if self.q_ib.ndim > 2:
            raise ValueError('to_pandas takes the states of one motion, and these are of many')
        vectors = {'q_ib_%s': self.q_ib, 'omega_bi_b_%s_rad_s': self.omega_bi_b}
        if self.orbit.has_lvlh:
            vectors |= {'r_i_%s_m': self.r_i, 'v_i_%s_m_s': self.v_i, 'q_lb_%s': self.q_lb}
        columns = {'t_s': self.t_s} | {
            form % axis: column
            for form, table in vectors.items()
            for axis, column in zip('xyzw', table.T, strict=False)
        }
        columns |= zip(('roll_rad', 'pitch_rad', 'yaw_rad'), self.roll_pitch_yaw.T, strict=True)
        count = self.rotor_speed.shape[-1]
        for i in range(count):
            rotor = 'rotor' if count == 1 else f'rotor_{i}'
            columns[f'{rotor}_angle_rad'] = self.rotor_angle[:, i]
            columns[f'{rotor}_speed_rad_s'] = self.rotor_speed[:, i]
        columns |= {column_of(name): values for name, values in self.inner.items()}
        return pandas.DataFrame(columns).dropna(axis='columns', how='all')


def joined(tables: Sequence[States]) -> States:
    """Return tables of one run that follow each other as one."""

    def column(name):
        columns = [getattr(table, name) for table in tables]
        return None if any(each is None for each in columns) else np.concatenate(columns)

    return States(
        t_s=column('t_s'),
        q_ib=column('q_ib'),
        omega_bi_b=column('omega_bi_b'),
        rotor_speed=column('rotor_speed'),
        rotor_angle=column('rotor_angle'),
        work=column('work'),
        orbit=tables[0].orbit,
        orbit_s=column('orbit_s'),
        turn_b=column('turn_b'),
        rotor_torque=column('rotor_torque'),
        met_limit=column('met_limit'),
        torquer_dipole_b=column('torquer_dipole_b'),
        environment=tables[0].environment,
        inner={
            name: np.concatenate([table.inner[name] for table in tables])
            for name in tables[0].inner
        },
    )


class Halted(RuntimeError):  # noqa: N818 - it says what happened to a motion
    """
    The end of a propagation that cannot reach a requested time; its text is one sentence.

    Attributes
    ----------
    reached_s : s
        how far it came since the motion began
    states : States
        the requested rows up to there, in ascending t_s, possibly none
    """

    def __init__(self, sentence: str, reached_s: float, states: States):
        super().__init__(sentence)
        self.reached_s, self.states = reached_s, states


class TableEnded(Halted):
    """The end of a propagation where what depends on time alone is known no further."""


class Motion(ABC):
    """
    One motion of a system from a state.

    name and source ('Agostinelli 1977, eqs 28-32') say what it is.  period_s is the exact period
    of the reduced motion, or None.

    Parameters
    ----------
    system : System
        what moves
    state : State
        its state at the start
    start_s : s
        time of the start from tick 0

    Raises
    ------
    ValueError
        the state lacks the speed or the angle of a free rotor
    """

    name: str
    source: str
    period_s: float | None = None

    def __init__(self, system: System, state: State, start_s: float = 0.0):
        system.check(state)
        self.system, self.state, self.start_s = system, state, start_s

    def __repr__(self) -> str:
        period = f', period {self.period_s:g} s' if self.period_s else ''
        return f'<{type(self).__name__}: {self.name} ({self.source}){period}, {self.system}>'

    def at(self, t_s: ArrayLike) -> States:
        """
        Return the states at some times, in any order; row i depends on t_s[i] alone.

        Parameters
        ----------
        t_s : float or (N,), s
            since the motion began

        Raises
        ------
        ValueError
            a time is negative or not finite
        Halted
            the motion cannot be propagated that far; it still answers the times before
        """
        t_s = _checked(t_s)
        return self._table(t_s, None, *self._states(t_s))

    def counting_at(self, t_s: ArrayLike) -> States:
        """
        Return the states as at() does, with turn_b, which is zero in the first row.

        The turn to a row depends only on its time and on that of the row before.

        Parameters
        ----------
        t_s : (N,), s
            since the motion began, ascending
        """
        t_s = _checked(t_s)
        turn_b = np.zeros((len(t_s), 3))
        return self._table(t_s, turn_b, *self._states(t_s, turn_b))

    @abstractmethod
    def _states(self, t_s, turn_b=None) -> tuple:
        """
        Return q_ib (N, 4), omega_bi_b (N, 3), rotor_speed and _angle (N, R), inner and work (N,).

        Where they are known, rotor_torque and met_limit (N, R) too.  turn_b: as of States, zeros
        that are added to; None: it is not wanted.
        """

    def _table(
        self,
        t_s,
        turn_b,
        q_ib,
        omega_bi_b,
        rotor_speed,
        rotor_angle,
        inner,
        work,
        rotor_torque=None,
        met_limit=None,
    ):
        return States(
            t_s=t_s,
            q_ib=q_ib,
            omega_bi_b=omega_bi_b,
            rotor_speed=rotor_speed,
            rotor_angle=rotor_angle,
            work=work,
            orbit=self.system.orbit,
            orbit_s=self.start_s + t_s,
            turn_b=turn_b,
            rotor_torque=rotor_torque,
            met_limit=met_limit,
            environment=self.system.environment,
            inner=inner,
            torquer_dipole_b=np.broadcast_to(torquer_dipole(self.system.torques), (len(t_s), 3)),
        )


def _checked(t_s: ArrayLike) -> np.ndarray:
    """Return times (N,) for which a motion has states."""
    # A copy has the one memory layout for which there is compiled code.
    t_s = np.array(t_s, float, ndmin=1)
    # One by one is ten times as fast where there is one.
    ends_s = t_s if len(t_s) < 2 else (t_s.min(), t_s.max())
    if not all(0.0 <= each < np.inf for each in ends_s):
        bad = t_s[~(np.isfinite(t_s) & (t_s >= 0.0))][0]
        raise ValueError(f't_s is {bad:g}; it must be finite and at least 0 s')
    return t_s
