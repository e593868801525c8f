"""
Where a satellite is to point: reference attitudes, as functions of a sample of a run.

A function takes what has r_i [m] and v_i [m/s] (3,), inertial, and stamp_ns, as each sample of a
Simulation has, and returns a Reference: attitude, rate and angular acceleration.

>>> from satdyn_ros import guidance
>>> q_ir, omega_ri_r, alpha_ri_r = guidance.nadir(simulation.sample)  # doctest: +SKIP
"""

from .directions import nadir, sun, target
from .given import from_aem, inertial
from .reference import Reference

__all__ = ['Reference', 'from_aem', 'inertial', 'nadir', 'sun', 'target']
