"""Code of functions with loops, against the same functions run by Python."""

import ctypes
import math

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from satdyn_ros.trace.load import Code
from satdyn_ros.trace.loops import text_of
from satdyn_ros.trace.memory import floats, integers, octets

ONE_HALF = 0.5


def arithmetic(numbers_at, counts_at, octets_at):
    numbers, counts, data = floats(numbers_at), integers(counts_at), octets(octets_at)
    x, y, n, k = numbers[0], numbers[1], counts[0], counts[1]
    numbers[2], numbers[3], numbers[4] = x + n, y - ONE_HALF * x, -x / y
    numbers[5], numbers[6] = n / 8, abs(y)
    numbers[7], numbers[8] = min(x, y), max(x, n)
    numbers[9], numbers[10] = np.sqrt(abs(x)), np.sign(y)
    numbers[11], numbers[12], numbers[13] = np.sin(x), np.cos(x), np.arctan2(x, y)
    numbers[14], numbers[15] = np.rint(x), x < y
    counts[2], counts[3], counts[4] = n + k * 3, n // 2, n % 3
    counts[5], counts[6], counts[7] = -k, int(x), data[k] + 256 * data[k + 1]
    return x == y


def branches(numbers_at, counts_at, octets_at):
    numbers, counts = floats(numbers_at), integers(counts_at)
    x, y, n = numbers[0], numbers[1], counts[0]
    is_between = x < y < 1.0 or n in (3, 5)
    both = is_between and not n > 4
    numbers[2] = x if both else n
    if is_between:
        numbers[3] = 1.0
    elif x != x or y == 0.0:
        numbers[3] = 2.0
    else:
        numbers[3] = 3.0
    # What follows is not looked at where what comes before decides.
    return n < 0 or integers(counts_at)[n] >= 0


def sum_to(numbers, count):
    """Return the sum of so many numbers, up to the first that is negative, and their number."""
    total, i = 0.0, 0
    for i in range(count):
        if numbers[i] < 0.0:
            return total, i
        total += numbers[i]
    return total, count


def loops(numbers_at, counts_at, octets_at):
    numbers, counts = floats(numbers_at), integers(counts_at)
    numbers[16], counts[1] = sum_to(numbers, 4)
    product = 1
    for i in range(1, 1 + counts[0]):
        if i == 2:
            continue
        for j in range(i if i > 3 else 1):
            product += j
            if product > 40:
                break
        product *= 2
    while product > 100:
        product -= 7
    counts[2] = product
    return product


def ran(run, function, seed):
    """Return what a function returns and what it leaves of drawn numbers."""
    rng = np.random.default_rng(seed)
    numbers, counts = rng.normal(0.0, 2.0, 20), rng.integers(0, 8, 10)
    data = rng.integers(0, 256, 16).astype(np.uint8)
    if seed % 7 == 0:
        numbers[0] = np.nan
    if seed % 5 == 0:
        numbers[1] = numbers[0]
    found = run(numbers.ctypes.data, counts.ctypes.data, data.ctypes.data)
    return int(found), numbers, counts


@pytest.mark.parametrize('function', [arithmetic, branches, loops])
def test_code_does_what_python_does(function, monkeypatch):
    """Of two hundred draws, bit by bit; a NaN is a NaN."""
    code = Code(text_of('it', function), name='it')
    words = [ctypes.c_int64] * 3
    compiled = ctypes.PYFUNCTYPE(ctypes.c_int64, *words)(code.address('it'))
    # On processors with AVX-512 NumPy has an arctan2 of its own, with other last digits.
    monkeypatch.setattr(np, 'arctan2', math.atan2)
    for seed in range(1, 200):
        if function is arithmetic and seed % 7 == 0:
            # Python has no integer of it.
            continue
        by_python, by_code = (ran(run, function, seed) for run in (function, compiled))
        assert by_code[0] == by_python[0]
        for one, other in zip(by_code[1:], by_python[1:], strict=True):
            assert_array_equal(one, other)


def unfit(numbers_at):
    total = 0
    total = 0.5 * total  # type: ignore[assignment]
    return total > 0


def test_a_variable_keeps_its_kind():
    """A float given to an integer is refused by the name of the function, and not rounded."""
    with pytest.raises(TypeError, match="unfit has <class 'float'> in place of <class 'int'>"):
        text_of('it', unfit)
