"""Torques on the body, one in a file, and what one of your own is made of."""

from ..base.key import Key
from ..kernel.functions import select
from ..kernel.time_table import Table, interpolate, table_of
from .body_torque import BodyTorque

__all__ = ['BodyTorque', 'Key', 'Table', 'interpolate', 'select', 'table_of']
