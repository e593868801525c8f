"""What the environment is along an orbit: tables with the pieces of the orbit's own."""

import numpy as np

from ..base.nanoseconds import SECOND_NS
from ..environment import dipole_field, dipole_vector, gcrs_to_itrs, igrf_field, turned
from .kepler import KeplerOrbit
from .pieces import Pieces, fitted
from .tabled import TabledOrbit


def magnetic_field(orbit: KeplerOrbit | TabledOrbit, model: str, epoch_ns: int) -> Pieces:
    """
    Return the Earth's field along an orbit, three functions of the time from tick 0 [T].

    In inertial axes.  model: 'dipole' or 'igrf'; epoch_ns: the Unix time of tick 0.  ValueError:
    the model does not know that time.
    """
    # Of either model: here an epoch is refused that it does not know.
    g_t = dipole_vector(epoch_ns)

    def field(t_s):
        unix_ns = epoch_ns + np.rint(t_s * SECOND_NS).astype(np.int64)
        r_i, _ = orbit.position_velocity(t_s)
        to_itrs = gcrs_to_itrs(unix_ns)
        r_t = turned(to_itrs, r_i)
        B_t = dipole_field(g_t, r_t) if model == 'dipole' else igrf_field(unix_ns, r_t)
        return turned(to_itrs.swapaxes(-1, -2), B_t)

    return Pieces(fitted(field), orbit.stretches)
