"""Code does what Python does with the same numbers, bit by bit."""

import ctypes
import itertools
import math
import random
import struct

import numpy as np
import pytest

from satdyn_ros.kernel import functions
from satdyn_ros.trace import ieee
from satdyn_ros.trace.emit import Program
from satdyn_ros.trace.graph import Graph, apply
from satdyn_ros.trace.load import Code

SPECIAL = [0.0, -0.0, math.inf, -math.inf, math.nan, 1.0, -1.0, 0.5, 5e-324, 1e308, 745.0, 2.0**53]
INPUTS = 6
TAKES_TWO = 'fadd', 'fsub', 'fmul', 'fdiv', 'atan2', 'fmod'


def code_of(function, count, lanes=1, cpu=None):
    """Return function(x (count,)) -> tuple as what takes an array (count, lanes) of numbers."""
    graph = Graph()
    found = function([graph.input('x', i) for i in range(count)])
    program = Program()
    program.add('evaluate', graph, {('out', i): each for i, each in enumerate(found)}, lanes)
    program.add_sequence('run', ('x', 'out'), [('evaluate', {})])
    code = Code(program.text, cpu=cpu)
    run = ctypes.CFUNCTYPE(None, ctypes.c_void_p)(code.address('run'))

    def call(x):
        x, out = np.ascontiguousarray(x, float), np.empty((len(found), lanes))
        table = np.array([x.ctypes.data, out.ctypes.data])
        run(table.ctypes.data)
        assert code
        return out

    return call


def bits(x):
    """Return the bits of a number; any nan is any other."""
    return 'nan' if math.isnan(x) else struct.pack('>d', x).hex()


@pytest.mark.parametrize('name', ieee.OPERATIONS)
@pytest.mark.parametrize('lanes', [1, 8])
def test_each_operation_is_as_in_python(name, lanes):
    """Of zeros, infinities, nan, of what overflows, and of numbers drawn at random."""
    rng = random.Random(name)
    takes_two = name in TAKES_TWO or name[0] in 'ou'
    numbers = [*SPECIAL, *(rng.gauss(0.0, 10.0 ** rng.randint(-8, 8)) for _ in range(8))]
    given = itertools.product(numbers, numbers) if takes_two else ((x,) for x in numbers)
    is_truth = name in ('olt', 'ole', 'ogt', 'oge', 'oeq', 'une')

    def function(x):
        found = apply(name, *x)
        return (functions.select(found, 1.0, 0.0) if is_truth else found,)

    cases = list(given)
    run = code_of(function, len(cases[0]), lanes)
    for begin in range(0, len(cases), lanes):
        some = (cases[begin : begin + lanes] + cases[:lanes])[:lanes]
        found = run(np.array(some).T)[0]
        assert [*map(bits, found)] == [bits(*function(each)) for each in some], some


def drawn(rng, count):
    """Return a function of INPUTS numbers, of so many operations drawn at random."""
    names = ['fadd', 'fsub', 'fmul', 'fneg', 'fabs', 'divide', 'minimum', 'maximum', 'select']
    names += ['power', 'modulo', 'subroutine', *ieee.OF_C_LIBRARY, 'sqrt', 'floor']
    operations = [(rng.choice(names), *(rng.random() for _ in range(4))) for _ in range(count)]

    def function(x):
        values = [*x, 0.5, -0.0, 1e300]
        for name, *shares in operations:
            a, b, c, d = (values[int(share * len(values))] for share in shares)
            values.append(_result(name, a, b, c, d))
        return values[-20:]

    return function


def _result(name, a, b, c, d):
    if name == 'select':
        return functions.select(a < b, c, d)
    if name == 'power':
        # As a symbol has it; Python's own is the C library's.
        return a * a * a if isinstance(a, float) else a**3
    if name == 'modulo':
        rest = apply('fmod', a, b)
        is_other = ((rest < 0.0) & (b > 0.0)) | ((rest > 0.0) & (b < 0.0))
        right = functions.select(is_other, rest + b, rest)
        return right if isinstance(a, float) and isinstance(b, float) else a % b
    if name == 'subroutine':
        first, second = functions.subroutine(_inner, a, b)
        return first - second
    if name in ('divide', 'minimum', 'maximum'):
        return getattr(functions, name)(a, b)
    if name in TAKES_TWO:
        return apply(name, a, b)
    return apply(name, a)


def _number(rng):
    return rng.choice([*SPECIAL, *(rng.gauss(0.0, 1.0) for _ in SPECIAL)])


def _inner(a, b):
    return a * b - functions.floor(a), a + b


@pytest.mark.parametrize('lanes', [1, 4, 8])
@pytest.mark.parametrize('seed', range(5))
def test_random_graphs_are_as_in_python(seed, lanes):
    """A hundred operations on what others gave; what is known is computed as Python computes."""
    rng = random.Random(seed)
    function = drawn(rng, 100)
    run = code_of(function, INPUTS, lanes)
    for _ in range(8):
        x = [[_number(rng) for _ in range(lanes)] for _ in range(INPUTS)]
        for l, found in enumerate(run(x).T):
            right = function([float(each[l]) for each in x])
            assert [*map(bits, found)] == [bits(float(each)) for each in right]


def truths(x):
    """Return what comparisons are, as numbers, in a choice, and joined; // and % too."""
    a, b, *_ = x
    return (
        (a < b) * 3.0 + (a >= 0.0),
        functions.select((a < 1.0) & (b < 1.0), a, b),
        functions.select((a < 0.0) | (b < 0.0), a, b),
        abs(a == b) - functions.select(a != b, 2.0, 0.5),
        functions.select(a, 1.0, 2.0),
        a // b,
        a % b,
    )


@pytest.mark.parametrize('lanes', [1, 8])
def test_truths_are_numbers_and_are_joined(lanes):
    """As of Python's own, 1 and 0."""
    run, rng = code_of(truths, INPUTS, lanes), np.random.default_rng(3)
    for _ in range(20):
        x = rng.choice([-2.5, -1.0, 0.5, 1.0, 3.0], (INPUTS, lanes))
        right = [truths([float(v) for v in each]) for each in x.T]
        np.testing.assert_array_equal(run(x).T, np.array(right, float))


@pytest.mark.parametrize('cpu', ['x86-64', 'haswell', 'znver2'])
def test_other_processors_have_the_same_bits(cpu):
    """Where there are only sums, products, quotients and roots."""

    def function(x):
        a, b, c, d, *_ = x
        for _ in range(30):
            a, b, c, d = a * b + c, b - c * d, functions.divide(a, d + 2.0), functions.sqrt(abs(a))
        return a, b, c, d

    x = np.random.default_rng(1).normal(size=(INPUTS, 1))
    here, there = code_of(function, INPUTS)(x), code_of(function, INPUTS, cpu=cpu)(x)
    assert here.tobytes() == there.tobytes()
    assert [*map(bits, here[:, 0])] == [*map(bits, function(x[:, 0].tolist()))]
