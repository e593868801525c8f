"""What moves: a body with its rotors, its motion, the equations and what they conserve."""

from ..base.imports import modules_of

__getattr__, __dir__ = modules_of(__name__)
