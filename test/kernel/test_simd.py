"""SIMD vectors compute what NumPy does, whatever processor the code is made for."""

import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numba import njit
from numba.core.errors import TypingError

from satdyn_ros.kernel.simd import (
    PACK,
    all_true,
    broadcast,
    load,
    packed,
    select,
    store,
    store_all,
    unflatten,
    width,
    zero,
)

WIDE = 8
ROOT = Path(__file__).parents[2]
A, B = np.random.default_rng(1).normal(size=(2, 2 * WIDE))


@njit
def arithmetic(a, b, out, like):
    """Write the results of every operation, one after the other."""
    for i in range(len(a) // width(like)):
        x, y = load(a, i, like), load(b, i, like)
        place = 6 * i
        store(out, place, x + y * 2.0)
        store(out, place + 1, 3.0 - x / y)
        store(out, place + 2, -(x - y))
        store(out, place + 3, math.sqrt(abs(x)))
        store(out, place + 4, select(x < y, broadcast(1.0, like), x))
        store(out, place + 5, x * broadcast(0.5, like))


@njit
def arithmetic_of_vectors(a, b, out):
    arithmetic(a, b, out, zero(WIDE))


def expected(a, b, wide):
    """Return what arithmetic writes, by NumPy."""
    results = a + b * 2.0, 3.0 - a / b, -(a - b), np.sqrt(abs(a)), np.where(a < b, 1.0, a), a * 0.5
    return np.stack(results).reshape(6, -1, wide).swapaxes(0, 1).ravel()


def test_arithmetic_is_that_of_numpy():
    """Every operation, of floats and of SIMD vectors, to the last bit."""
    out = np.zeros(6 * len(A))
    arithmetic_of_vectors(A, B, out)
    np.testing.assert_array_equal(out, expected(A, B, WIDE))
    arithmetic(A, B, out, 0.0)
    np.testing.assert_array_equal(out, expected(A, B, 1))


def test_nan_is_less_than_nothing():
    """A comparison with nan is false, and select takes the other side."""
    found = np.zeros(WIDE)

    @njit
    def run(a, out):
        x = load(a, 0, zero(WIDE))
        store(out, 0, select(x < broadcast(1.0, x), broadcast(1.0, x), broadcast(2.0, x)))

    run(np.array([np.nan, 0.0] * (WIDE // 2)), found)
    np.testing.assert_array_equal(found, [2.0, 1.0] * (WIDE // 2))


@pytest.mark.parametrize(
    ('last', 'expected'), [(0.5, True), (1.0, False), (2.0, False), (np.nan, False)]
)
def test_all_true(last, expected):
    """Every float must be less; an equal one is not, nor is nan."""

    @njit
    def run(a, b):
        return all_true(load(a, 0, zero(WIDE)) < load(b, 0, zero(WIDE)))

    assert run(np.array([0.0] * (WIDE - 1) + [last]), np.ones(WIDE)) == expected


def test_a_tuple_is_packed_and_stored():
    """Floats stand in their order, with zeros up to a whole pack."""
    out = np.full(8, np.nan)

    @njit
    def run(out, values):
        store_all(out, 0, packed(values))

    run(out, (1.0, 2.0, 3.0, 4.0, 5.0))
    np.testing.assert_array_equal(out, [1.0, 2.0, 3.0, 4.0, 5.0, 0.0, 0.0, 0.0])
    assert PACK == 4


def test_nested_tuples_are_filled_in_order():
    """Every number has the place that it has among all; a bool stays as it is, in its place."""

    @njit
    def run(like, numbers):
        return unflatten(like, numbers, 0.0)

    like = (0.0, (0.0, 0.0), True, ((0.0,), 0.0))
    assert run(like, np.arange(6.0)) == (0.0, (1.0, 2.0), True, ((4.0,), 5.0))


def test_an_array_with_gaps_is_refused():
    """A row of every second number would be read as if all belonged to it."""
    with pytest.raises(TypingError, match='contiguous arrays alone'):
        arithmetic(A[::2], B[::2], np.zeros(6 * len(A)), 0.0)


VECTORS = """
import re
import numpy as np
from numba import njit
from satdyn_ros.kernel.simd import load, store, zero

@njit
def run(a, b):
    for i in range(len(a) // 8):
        store(b, i, load(a, i, zero(8)) * load(b, i, zero(8)))

run(np.ones(16), np.ones(16))
code = next(iter(run.inspect_asm().values()))
print(len(re.findall(r'mulpd|fmul\\s+v', code)))
"""


@pytest.mark.parametrize('processor', ['', pytest.param('generic', marks=pytest.mark.long)])
def test_they_are_vectors_on_every_processor(processor):
    """The code multiplies vectors, where the compiler itself makes none of a loop too."""
    environment = {'NUMBA_CPU_NAME': processor} if processor else {}
    program = subprocess.run(
        [sys.executable, '-c', VECTORS],
        env=os.environ | environment,
        stdout=subprocess.PIPE,
        check=True,
        cwd=ROOT,
    )
    assert int(program.stdout) >= 1


FUNCTIONS = {
    function.__name__: function
    for function in (
        *(math.sin, math.cos, math.tan, math.asin, math.acos, math.atan),
        *(math.exp, math.log, math.sinh, math.cosh, math.tanh, math.sqrt, abs),
    )
}


@pytest.mark.parametrize('name', FUNCTIONS)
def test_a_function_of_a_vector_has_the_bits_of_the_scalar_one(name):
    """Lane by lane, also where the scalar one gives nan."""
    function = FUNCTIONS[name]
    values = np.array([-2.0, -0.9, -1e-9, 0.0, 1e-300, 0.3, 0.999, 40.0])

    @njit(error_model='numpy')
    def run(a, of_vector, of_floats):
        store(of_vector, 0, function(load(a, 0, zero(WIDE))))
        for i in range(WIDE):
            of_floats[i] = function(a[i])

    found, right = np.zeros(WIDE), np.zeros(WIDE)
    run(values, found, right)
    np.testing.assert_array_equal(found.view(np.int64), right.view(np.int64))


def test_comparisons_and_extremes_are_those_of_floats():
    """With a counterpart and with one float, on either side; equal numbers are among them."""

    @njit
    def each(x, y):
        return (
            select(x < y, 1.0, 0.0),
            select(x <= y, 1.0, 0.0),
            select(x > 0.5, x, 0.0),
            select(0.5 >= x, 2.0, x),
            min(x, y),
            max(x, 0.0),
        )

    @njit
    def run(a, b, of_vector, of_floats):
        vectors = each(load(a, 0, zero(WIDE)), load(b, 0, zero(WIDE)))
        for j in range(6):
            store(of_vector, j, vectors[j])
        for i in range(WIDE):
            floats = each(a[i], b[i])
            for j in range(6):
                of_floats[j, i] = floats[j]

    a = np.array([-1.0, 0.0, 0.5, 0.5, 0.7, 2.0, np.nan, 3.0])
    b = np.array([1.0, 0.0, 0.5, 0.4, 0.9, 1.0, 1.0, np.nan])
    found, right = np.zeros((6, WIDE)), np.zeros((6, WIDE))
    run(a, b, found.reshape(-1), right)
    np.testing.assert_array_equal(found, right)
