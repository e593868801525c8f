"""What theory says of a system without its motion: equilibria, stability, steady motions."""

from ..base.imports import modules_of

__getattr__, __dir__ = modules_of(__name__)
