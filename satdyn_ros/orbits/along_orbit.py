"""What the environment is along an orbit: tables of what depends on time alone."""

from collections.abc import Callable
from functools import cached_property, lru_cache

import numpy as np

from ..base.nanoseconds import SECOND_NS
from ..environment import (
    Exponential,
    Msis,
    air_velocity,
    dipole_field,
    dipole_vector,
    gcrs_to_itrs,
    geodetic,
    igrf_field,
    shadow_margins,
    sun_position,
    turned,
)
from .axes_of_date import tabled_gcrs_to_intermediate
from .kepler import KeplerOrbit
from .pieces import Piece, Pieces, fitted, roots, whole_seconds, within_days
from .tabled import TabledOrbit

# Of how many times a library is asked in a call, which no other thread of Python interrupts.
_ROWS = 16


class AlongOrbit:
    """
    The environment of a body on an orbit, functions of the time from tick 0 in tables.

    epoch_ns: the Unix time of tick 0.  field_model: 'none', 'dipole' or 'igrf'.  air: what its
    density follows, None: there is none.  has_sun: whether the Sun shines.  Vectors are in
    inertial axes, with the centre of the Earth as the origin.

    ValueError: the field does not know the time of tick 0.
    """

    def __init__(
        self,
        orbit: KeplerOrbit | TabledOrbit,
        epoch_ns: int,
        field_model: str = 'none',
        air: Exponential | Msis | None = None,
        has_sun: bool = False,
    ):
        self.orbit, self.epoch_ns = orbit, epoch_ns
        self.field_model, self.air, self.has_sun = field_model, air, has_sun
        if field_model != 'none':
            # Of either model: it refuses a time that it does not know.
            self._g_t = dipole_vector(epoch_ns)

    @cached_property
    def magnetic_field(self) -> Pieces:
        """The Earth's field B [T], three functions."""
        return self._fitted(self.modelled_field)

    @cached_property
    def air_velocity(self) -> Pieces:
        """The velocity w of the body through air that turns with the Earth [m/s], three."""

        def velocity(t_s):
            pole_i = self._to_itrs_at(t_s)[..., 2, :]
            return air_velocity(*self.orbit.position_velocity(t_s), pole_i)

        return self._fitted(velocity)

    @cached_property
    def log_density(self) -> Pieces:
        """The logarithm of the density of the air [kg/m^3], one function."""
        air = self.air
        if isinstance(air, Exponential):

            def exponential(t_s):
                _, _, r_t = self._place(t_s)
                return air.log_density(geodetic(r_t)[2])[:, None]

            return self._fitted(exponential)
        assert air is not None

        def msis(t_s):
            unix_ns, _, r_t = self._place(t_s)
            unix_s = np.rint(unix_ns / SECOND_NS).astype(np.int64)
            return air.log_density(unix_s, *geodetic(r_t))[:, None]

        # It knows whole seconds alone, and jumps where the day does.
        stretches = within_days(self.orbit.stretches, self.epoch_ns)
        return Pieces(whole_seconds(msis, self.epoch_ns), stretches)

    @cached_property
    def sun(self) -> Pieces:
        """The place of the Sun [m], three functions; steps end at the edges of the shadow."""
        return self._fitted(self._sun_at, corners=roots(self._shadow_margins))

    @cached_property
    def to_itrs(self) -> Pieces:
        """What turns components in GCRS into those in ITRS: nine functions, row by row."""
        return self._fitted(lambda t_s: self._to_itrs_at(t_s).reshape(-1, 9))

    def modelled_field(self, t_s: np.ndarray) -> np.ndarray:
        """Return the Earth's field B [T] (N, 3) as its model, not its table, has it."""
        unix_ns, to_itrs, r_t = self._place(t_s)
        is_dipole = self.field_model == 'dipole'
        B_t = dipole_field(self._g_t, r_t) if is_dipole else igrf_field(unix_ns, r_t)
        return turned(to_itrs.swapaxes(-1, -2), B_t)

    def modelled_sun(self, t_s: np.ndarray) -> np.ndarray:
        """Return the place of the Sun [m] (N, 3) as the ephemeris, not its table, has it."""
        return sun_position(self.unix_ns(t_s))

    def unix_ns(self, t_s: np.ndarray) -> np.ndarray:
        """Return times from tick 0 as Unix times."""
        return self.epoch_ns + np.rint(t_s * SECOND_NS).astype(np.int64)

    def _fitted(self, function, corners: Callable[[Piece], np.ndarray] | None = None):
        return Pieces(fitted(function), self.orbit.stretches, corners=corners)

    def _place(self, t_s):
        unix_ns, (r_i, _) = self.unix_ns(t_s), self.orbit.position_velocity(t_s)
        to_itrs = self._to_itrs_at(t_s)
        return unix_ns, to_itrs, turned(to_itrs, r_i)

    def _shadow_margins(self, t_s):
        r_i, _ = self.orbit.position_velocity(t_s)
        return np.stack(shadow_margins(r_i, self._sun_at(t_s)), axis=-1)

    def _to_itrs_at(self, t_s):
        return gcrs_to_itrs(self.unix_ns(t_s), tabled_gcrs_to_intermediate)

    # Several tables have the same nodes.
    @cached_property
    def _sun_at(self):
        return _kept(lambda t_s: sun_position(self.unix_ns(t_s)))


def _kept(function):
    """Return a function of times (N,) that is kept for those that it was last asked for."""
    at = lru_cache(8)(lambda times: _by_parts(function, np.frombuffer(times)))
    return lambda t_s: at(t_s.tobytes())


def _by_parts(function, t_s):
    parts = np.split(t_s, range(_ROWS, len(t_s), _ROWS))
    return np.concatenate([function(part) for part in parts])
