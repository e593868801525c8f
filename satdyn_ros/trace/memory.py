"""Memory by its addresses, for functions with loops: as Python reads it, and loops.py as code."""

import ctypes
from typing import Any


def floats(address: int) -> Any:
    """Return the floats at an address, to be indexed as an array is, unchecked."""
    return ctypes.cast(address, ctypes.POINTER(ctypes.c_double))


def integers(address: int) -> Any:
    """Return the integers at an address, as floats does."""
    return ctypes.cast(address, ctypes.POINTER(ctypes.c_int64))


def octets(address: int) -> Any:
    """Return the bytes at an address, to be read as floats are."""
    return ctypes.cast(address, ctypes.POINTER(ctypes.c_uint8))


def call(code: int, table: int) -> None:
    """Call the function at an address with that of a table of the addresses of its arrays."""
    ctypes.CFUNCTYPE(None, ctypes.c_int64)(code)(table)
