"""Motions in closed form, one a file, and which of them a system and a state have."""

from .exact_motion import ExactMotion
from .free import Free
from .immersed import FluidBody, Immersed
from .planar import Planar
from .recognise import explain, recognise
from .stationary import Stationary
from .steady import Steady
from .symmetric import Symmetric

__all__ = [
    'ExactMotion',
    'FluidBody',
    'Free',
    'Immersed',
    'Planar',
    'Stationary',
    'Steady',
    'Symmetric',
    'explain',
    'recognise',
]
