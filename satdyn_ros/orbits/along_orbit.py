"""What the environment is along an orbit: tables of what depends on time alone."""

from collections.abc import Callable, Sequence
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
    igrf_years_ns,
    leap_seconds_ns,
    shadow_margins,
    sun_position,
    turned,
)
from .axes_of_date import tabled_gcrs_to_intermediate
from .orbit import Orbit
from .pieces import (
    Piece,
    Pieces,
    Stretch,
    ending_at,
    fitted,
    no_longer,
    roots,
    whole_seconds,
    within_days,
)

# Of how many times a library is asked in a call, which no other thread of Python interrupts.
_ROWS = 16
# In the longest piece the Earth, and the field with it, turns by 1.5 rad.
_LONGEST_S = 20_000.0
# Where steps end beside a contact with the shadow, in shares of a piece.
_BESIDE_A_CONTACT = np.array([-4e-3, -1e-3, -2.5e-4, 0.0, 2.5e-4, 1e-3, 4e-3])


class AlongOrbit:
    """
    The environment of a body on an orbit, functions of the time from tick 0 in tables.

    Vectors are in inertial axes, with the centre of the Earth as the origin.

    The time from tick 0 is counted by the stamps, which have no leap seconds: where one goes by,
    TT is a second later, and the Sun and the axes of date jump by what they move in it.  Pieces
    end there, and where the slope of the IGRF jumps.

    Parameters
    ----------
    orbit : Orbit
        where the body is
    epoch_ns : ns
        Unix time of tick 0
    field_model : str
        none, dipole or igrf
    air : Exponential, Msis or None
        what its density follows, None: there is none
    has_sun : bool
        whether the Sun shines
    with_jumps : bool
        as by rules below 4 pieces run across the jumps, are as long as those of the orbit, and the
        air of the last of a day has the next's
    with_short_steps : bool
        not as by rules below 5, where steps beside a contact with the shadow are as long as others

    Raises
    ------
    ValueError
        the field does not know the time of tick 0
    """

    def __init__(
        self,
        orbit: Orbit,
        epoch_ns: int,
        field_model: str = 'none',
        air: Exponential | Msis | None = None,
        has_sun: bool = False,
        with_jumps: bool = False,
        with_short_steps: bool = True,
    ):
        self.orbit, self.epoch_ns = orbit, epoch_ns
        self.field_model, self.air, self.has_sun = field_model, air, has_sun
        self._with_jumps, self._with_short_steps = with_jumps, with_short_steps
        if field_model != 'none':
            # Of either model: it refuses a time that it does not know.
            self._g_t = dipole_vector(epoch_ns)

    @cached_property
    def magnetic_field(self) -> Pieces:
        """The Earth's field B [T], three functions."""
        years_ns = igrf_years_ns() if self.field_model == 'igrf' else ()
        return self._fitted(self.modelled_field, jumps_ns=years_ns)

    @cached_property
    def magnetic_field_and_rate(self) -> Pieces:
        """The Earth's field B [T] and its derivative along the orbit [T/s], six functions."""
        return self.magnetic_field.with_derivatives()

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
                _, _, r_t = self._position(t_s)
                return air.log_density(geodetic(r_t)[2])[:, None]

            return self._fitted(exponential)
        assert air is not None

        def msis(t_s):
            unix_ns, _, r_t = self._position(t_s)
            unix_s = np.rint(unix_ns / SECOND_NS).astype(np.int64)
            return air.log_density(unix_s, *geodetic(r_t))[:, None]

        # It knows whole seconds alone, and jumps where the day does.
        stretches: Sequence[Stretch] = self.orbit.stretches
        if not self._with_jumps:
            stretches = no_longer(stretches, _LONGEST_S)
        make = whole_seconds(msis, self.epoch_ns, with_end=self._with_jumps)
        return Pieces(make, within_days(stretches, self.epoch_ns))

    @cached_property
    def sun(self) -> Pieces:
        """The position of the Sun [m], three functions; steps end at the edges of the shadow."""
        contacts_in = roots(self._shadow_margins)

        def contacts_and_beside(piece):
            # There the light goes with the 3/2th power of time, which no polynomial is: steps grow
            # from short ones on.
            shares = _BESIDE_A_CONTACT if self._with_short_steps else np.zeros(1)
            beside = contacts_in(piece)[:, None] + piece.stretch.length_s * shares
            return beside[(piece.begin_s < beside) & (beside < piece.end_s)]

        return self._fitted(self._sun_at, corners=contacts_and_beside)

    @cached_property
    def to_itrs(self) -> Pieces:
        """What turns components in GCRS into those in ITRS: nine functions, row by row."""
        return self._fitted(lambda t_s: self._to_itrs_at(t_s).reshape(-1, 9))

    @property
    def asked(self) -> tuple[Pieces, ...]:
        """The tables of the models that are asked for and may end, whatever moves by them."""
        if self._with_jumps:
            return ()
        field = () if self.field_model == 'none' else (self.magnetic_field,)
        return (*field, self.sun) if self.has_sun else field

    def modelled_field(self, t_s: np.ndarray) -> np.ndarray:
        """Return the Earth's field B [T] (N, 3) as its model, not its table, has it."""
        unix_ns, to_itrs, r_t = self._position(t_s)
        is_dipole = self.field_model == 'dipole'
        B_t = dipole_field(self._g_t, r_t) if is_dipole else igrf_field(unix_ns, r_t)
        return turned(to_itrs.swapaxes(-1, -2), B_t)

    def modelled_sun(self, t_s: np.ndarray) -> np.ndarray:
        """Return the position of the Sun [m] (N, 3) as the ephemeris, not its table, has it."""
        return sun_position(self.unix_ns(t_s))

    def unix_ns(self, t_s: np.ndarray) -> np.ndarray:
        """Return times from tick 0 as Unix times."""
        return self.epoch_ns + np.rint(t_s * SECOND_NS).astype(np.int64)

    def on_earth(self, t_s: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """
        Return where the body is above the Earth at times (N,).

        The matrices (N, 3, 3) that turn components in inertial axes into ITRS, r_t (N, 3) [m]
        there, and latitude and longitude (N,) [rad] on WGS 84.
        """
        _, to_itrs, r_t = self._position(t_s)
        latitude, longitude, _ = geodetic(r_t)
        return to_itrs, r_t, latitude, longitude

    def _fitted(
        self,
        function,
        corners: Callable[[Piece], np.ndarray] | None = None,
        jumps_ns: Sequence[int] | np.ndarray = (),
    ):
        stretches: Sequence[Stretch] = self.orbit.stretches
        if not self._with_jumps:
            ends_ns = np.union1d(leap_seconds_ns(), np.asarray(jumps_ns, np.int64))
            ends_s = ((ends_ns - self.epoch_ns) / SECOND_NS).tolist()
            stretches = ending_at(no_longer(stretches, _LONGEST_S), ends_s)
        return Pieces(fitted(function), stretches, corners=corners)

    def _position(self, t_s):
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
