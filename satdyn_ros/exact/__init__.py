"""Motions in closed form, one a file, and which of them a system and a state have."""

from . import paladini
from .action_angle import ActionAngle
from .body_fixed import BodyFixed
from .classify import RotationClass, axis_wander, rotation_class
from .equivalents import ChargedBody, ConductingFluid
from .exact_motion import ExactMotion, Fact
from .fluid import FluidBody
from .free import Free
from .immersed import Immersed
from .planar import Planar
from .recognise import explain, recognise
from .stationary import Stationary
from .steady import Steady
from .symmetric import Symmetric

__all__ = [
    'ActionAngle',
    'BodyFixed',
    'ChargedBody',
    'ConductingFluid',
    'ExactMotion',
    'Fact',
    'FluidBody',
    'Free',
    'Immersed',
    'Planar',
    'RotationClass',
    'Stationary',
    'Steady',
    'Symmetric',
    'axis_wander',
    'explain',
    'paladini',
    'recognise',
    'rotation_class',
]
